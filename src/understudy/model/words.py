"""One feature's region in words: "distance_to(A) is below 0.38 m", "angle_to(A) is between 350° and 10°"."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable
from math import ceil, degrees, floor, inf, isinf, nextafter

from understudy.model.features import BoundFeature
from understudy.model.kinds import Categorical, Toroidal
from understudy.model.tree_regions import Part, Region, everything

FULL_TURN = 360.0
MOST_DIGITS = 17


class Words:
    """How to speak of one feature: each number as short as can be, so that it is told apart from the other cuts
    and every value that was shown (`values`) stays on its side: whole degrees, cm, three digits where that will do.
    """

    def __init__(
        self, bound: BoundFeature, cuts: Iterable[float], *, known_absent: bool, values: Iterable[float] = ()
    ) -> None:
        self.name, self.kind, self._known_absent = str(bound), bound.kind, known_absent
        self._angle = isinstance(bound.kind, Toroidal) and bound.feature.unit == "rad"
        self._unit = "°" if self._angle else f" {bound.feature.unit}" if bound.feature.unit else ""
        self._decimals = 0 if self._angle else 2 if bound.feature.unit == "m" else None
        self._said: dict[float, str] = {}
        shown = sorted(value for value in values if value == value)
        self._shown_some = bool(shown)
        before, said = -inf, -inf
        for cut in sorted(set(cuts)):
            at = bisect_left(shown, cut)
            under = self._plain(shown[at - 1]) if at else -inf
            over = self._plain(shown[at]) if at < len(shown) else inf
            exact = self._shown(cut)
            least = said if exact == before else nextafter(said, inf)
            self._said[cut], said = self._shortest(cut, least, under, over)
            before = exact

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
        """A cut, or another value, with its unit."""
        return f"{self._said.get(value) or self._rounded(self._shown(value), 0)[0]}{self._unit}"

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

    def _plain(self, value: float) -> float:
        return degrees(value) if self._angle else value

    def _shown(self, cut: float) -> float:
        return self._plain(nextafter(cut, -inf) if _just_above(cut) else cut)

    def _shortest(self, cut: float, least: float, under: float, over: float) -> tuple[str, float]:
        """A cut in digits and the number they are: `least` or more, and between the values on its sides.

        The value `under` it stays below the number, or at it where it is said as "at most"; that `over` it does not.
        """
        exact, above = self._shown(cut), _just_above(cut)
        taken = self._angle and "0" in self._said.values()
        for more in range(MOST_DIGITS):
            for text, number in self._near(exact, more):
                between = under <= number < over if above else under < number <= over
                vanishes = number == 0.0 != exact and not self._angle
                again = taken and number == FULL_TURN
                if least <= number and between and not vanishes and not again:
                    return text, number
        return repr(exact), exact

    def _near(self, exact: float, more: int) -> list[tuple[str, float]]:
        """The number rounded to so many more digits than usual: to the nearest, then, between values, down and up."""
        text, number = self._rounded(exact, more)
        if self._decimals is None or not self._shown_some:
            return [(text, number)]
        step = 10.0 ** -(self._decimals + more)
        sides = [floor(exact / step) * step, ceil(exact / step) * step]
        return [(text, number), *(self._rounded(side, more) for side in sides)]

    def _rounded(self, value: float, more: int) -> tuple[str, float]:
        if self._decimals is not None:
            text = f"{value:.{self._decimals + more}f}"
        else:
            whole_digits = len(str(int(abs(value)))) if abs(value) < 1e9 else 0
            text = f"{value:.{max(3 + more, whole_digits)}g}"
            if "e" in text and 1e-6 <= abs(value) < 1e9:
                text = f"{float(text):.20f}"
        if "." in text and "e" not in text:
            text = text.rstrip("0").rstrip(".")
        number = float(text)
        seam = text == "-0" or (self._angle and number == FULL_TURN)
        return "0" if seam else text, number


def _just_above(cut: float) -> bool:
    """Whether a cut is the float after a plainly shorter number, which then lies below it."""
    if isinf(cut):
        return False
    return len(repr(nextafter(cut, -inf))) + 4 < len(repr(cut))
