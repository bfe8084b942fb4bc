"""The novice of `novices`, at GoTo: turn to the station, drive there, say done."""

from __future__ import annotations

from math import isnan, pi, tau

from understudy.training.session_view import SessionView
from understudy_lab.novices.novice import Novice
from understudy_lab.novices.traits import UNDERSTOOD

THERE_M = 0.3
"""What being there is to a novice who judges it well."""
PLAINLY = 1.5
"""So many times as far away the robot is plainly not there."""
ASTRAY, FACING = 0.6, 0.12
"""So far off its way it has to turn, rad; so near to facing the station it has turned enough."""
OFF_RAD = 0.15
"""How far off ahead is, rad, to a novice who is as far off the middle as any."""


class GotoNovice(Novice):
    """A novice who teaches GoTo(A); what they misunderstood is which way to turn."""

    buttons = ("forward", "rotate_left", "rotate_right", "done")

    def there(self, screen: SessionView) -> bool:
        """The robot says that it is there, and it looks so."""
        return screen.flag is not None and self.wish(screen) is None

    def wish(self, screen: SessionView) -> str | None:
        """The state they would rather have the robot in."""
        distance, state = screen.features["distance_to(A)"], screen.state
        if isnan(distance):
            return None
        there_m = THERE_M * (1.0 + self.traits.misjudged)
        if distance < (PLAINLY * there_m if screen.flag is not None else there_m):
            return None if screen.flag is not None else "done"
        off = (screen.features["angle_to(A)"] + OFF_RAD * self.traits.off_middle_px / 20.0 + pi) % tau - pi
        if state in ("start", "forward", "done"):
            return self._turn(off) if abs(off) > ASTRAY else None if state == "forward" else "forward"
        ahead = off if state == "rotate_left" else -off
        return "forward" if -ASTRAY < ahead < FACING else None

    def _turn(self, off: float) -> str:
        """The way they turn to what is so far to the left, rad."""
        side = "rotate_left" if off > 0 else "rotate_right"
        if self.traits.mistake == UNDERSTOOD:
            return side
        if self.traits.mistake == "one only":
            return "rotate_left"
        return "rotate_left" if self._either == "forwardL" else "rotate_right"
