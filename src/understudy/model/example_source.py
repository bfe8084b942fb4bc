"""Sources of examples: the place in a recording that an example was made from, and who drove there."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ExampleSource:
    """The place in a recording that an example was made from.

    Parameters
    ----------
    file
        Name of the recording's file.
    time_s
        Time of the tick in the recording, s.
    driver
        Name of the person who drove. Empty: unknown.
    certainty
        How certain the label of the recording is there, from 0 to 1.
    """

    file: str
    time_s: float
    driver: str = ""
    certainty: float = 1.0

    def __str__(self) -> str:
        """Format as a place in a sentence: "anna.csv at 12.3 s, driven by anna"."""
        return f"{self.file} at {self.time_s:.1f} s{f', driven by {self.driver}' if self.driver else ''}"
