"""The paper's foraging world: bring food from sources that deplete to the station (paper section 4.1).

One robot per world. It is the built-in scenario `forage`, with other numbers where settings say so.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from understudy.sim.forage_settings import NAME, ForageSettings, corner_cases
from understudy.sim.kit import kit_of
from understudy.sim.scenario.files import load_scenario
from understudy.sim.world import World

__all__ = ["Forage", "ForageSettings", "corner_cases", "kit"]

kit = kit_of(load_scenario(NAME))


class Forage(World):
    """A body of N foraging robots, each in a world of its own that its seed lays out."""

    def __init__(self, seeds: Sequence[int] = (0,), settings: ForageSettings | None = None) -> None:
        self.settings = ForageSettings() if settings is None else settings
        super().__init__(self.settings.scenario(), seeds)

    def success(self) -> NDArray[np.bool_]:
        """Whether all food is at the station now [N]."""
        return np.equal(self.delivered, self.total)
