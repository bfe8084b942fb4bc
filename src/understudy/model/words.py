"""One feature's region in words: "distance_to(A) is below 0.38 m", "angle_to(A) is between 350° and 10°"."""

from __future__ import annotations

from collections.abc import Iterable
from math import degrees, inf, isinf, nextafter

from understudy.model.feature import BoundFeature
from understudy.model.kinds import Categorical, Toroidal
from understudy.model.regions import Part, Region, everything


class Words:
    """How to speak of one feature: its numbers rounded as far as its cuts can still be told apart."""

    def __init__(self, bound: BoundFeature, cuts: Iterable[float], *, known_absent: bool) -> None:
        self.name, self.kind, self._known_absent = str(bound), bound.kind, known_absent
        self._angle = isinstance(bound.kind, Toroidal) and bound.feature.unit == "rad"
        self._unit = "°" if self._angle else f" {bound.feature.unit}" if bound.feature.unit else ""
        shown = sorted({self._shown(cut) for cut in cuts})
        self._digits = 0 if self._angle else 3
        while self._digits < 17 and not self._tells_apart(shown):
            self._digits += 1

    def is_whole(self, region: Region) -> bool:
        """Whether the region says nothing: all present values belong, and absence if it was ever shown."""
        return region.parts == everything(self.kind).parts and region.absent == self._known_absent

    def statement(self, region: Region) -> str:
        """What a region says: the feature's name, "is", and the parts joined by "or"."""
        whole = everything(self.kind).parts
        if region.parts == whole:
            return f"{self.name} is {'anything' if region.absent else 'not absent'}"
        parts = self._labels(region) if isinstance(self.kind, Categorical) else self._parts(region)
        return f"{self.name} is {' or '.join([*parts, *(['absent'] if region.absent else [])])}"

    def number(self, value: float) -> str:
        """A value with its unit."""
        return f"{self._rounded(self._shown(value))}{self._unit}"

    def _labels(self, region: Region) -> list[str]:
        labels = self.kind.labels if isinstance(self.kind, Categorical) else ()
        left_out = [label for index, label in enumerate(labels) if float(index) not in region]
        if len(left_out) == 1 and len(labels) > 2:
            return [f"not {left_out[0]}"]
        return [label for index, label in enumerate(labels) if float(index) in region]

    def _parts(self, region: Region) -> list[str]:
        parts = list(region.parts)
        if isinstance(self.kind, Toroidal):
            if len(parts) > 1 and parts[0][0] == 0.0 and parts[-1][1] == self.kind.period:
                parts = [*parts[1:-1], (parts[-1][0], parts[0][1])]
            return [self._arc(part) for part in parts]
        return [self._interval(part) for part in parts]

    def _arc(self, part: Part) -> str:
        low, high = part
        if high == nextafter(low, inf):
            return self.number(low)
        return f"between {self.number(low)} and {self.number(high)}"

    def _interval(self, part: Part) -> str:
        low, high = part
        above, at_most = _just_above(low), _just_above(high)
        under = f"at most {self.number(high)}" if at_most else f"below {self.number(high)}"
        over = f"above {self.number(low)}" if above else f"at least {self.number(low)}"
        if isinf(low):
            return under
        if isinf(high):
            return over
        if high == nextafter(low, inf):
            return self.number(low)
        if not above and not at_most:
            return f"between {self.number(low)} and {self.number(high)}"
        return f"{over} and {under}"

    def _shown(self, cut: float) -> float:
        value = nextafter(cut, -inf) if _just_above(cut) else cut
        return degrees(value) if self._angle else value

    def _tells_apart(self, shown: list[float]) -> bool:
        rounded = [self._rounded(value) for value in shown]
        return len(set(rounded)) == len(rounded) and "0" not in [
            text.lstrip("-") for text, value in zip(rounded, shown, strict=True) if value
        ]

    def _rounded(self, value: float) -> str:
        if self._angle:
            text = f"{value:.{self._digits}f}"
        else:
            whole_digits = len(str(int(abs(value)))) if abs(value) < 1e9 else 0
            text = f"{value:.{max(self._digits, whole_digits)}g}"
            if "e" in text and 1e-6 <= abs(value) < 1e9:
                text = f"{float(text):.20f}"
        if "." in text and "e" not in text:
            text = text.rstrip("0").rstrip(".")
        return "0" if text == "-0" else text


def _just_above(cut: float) -> bool:
    """Whether a cut is the float after a plainly shorter number, which then lies below it."""
    if isinf(cut):
        return False
    return len(repr(nextafter(cut, -inf))) + 4 < len(repr(cut))
