"""The model of a novice, who presses late or wrongly, looks away, and may misunderstand the two forward states.

Its parameters were fixed before the first run and not changed since. Ranges are those that the literature gives for
people in general, or a choice of ours, marked as chosen, where it has none for such a task. Each novice's traits are
drawn uniformly from them by its seed. `SharedTraits` are the same for all.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from math import isnan
from types import MappingProxyType

import numpy as np

from understudy.model.library import Library, TrainedAutomaton
from understudy.training.session import Session
from understudy.training.trainee import SessionView
from understudy_lab.tasks.servo_teacher import EMERGED_PX, MIDDLE_PX, OTHER_PX, THERE_PX, blob_x, four_states
from understudy_lab.tasks.soccer import Soccer, StartPose, kit
from understudy_lab.teachers.person import ReactionTime, SimulatedPerson
from understudy_lab.teachers.teacher import FIRST_SEED

RANGES: Mapping[str, tuple[float, float, str]] = MappingProxyType(
    {
        "reaction_s": (
            0.3,
            0.7,
            "Mean time from seeing that something is to be done to the press. A simple reaction takes 0.24 s (0.1 to "
            "0.47; Card, Moran and Newell 1983), and each doubling of the alternatives adds about 0.15 s (Hick 1952): "
            "0.5 s for four or five buttons.",
        ),
        "slips": (
            0.01,
            0.06,
            "Chance that a press hits another button: a few percent of choices in reaction experiments are wrong "
            "(Luce 1986); people new to it slip no less (slips as in Reason 1990).",
        ),
        "lapses": (
            0.05,
            0.3,
            "Share of the time in which they do not look. Thoughts wander in 15 to 50 % of samples while reading "
            "(Smallwood and Schooler 2006) and in 47 % in daily life (Killingsworth and Gilbert 2010); in a short task "
            "with something to do, less.",
        ),
        "misjudged": (
            -0.3,
            0.6,
            "By which share they misjudge how near the robot must be to be there (chosen: told `very near`).",
        ),
        "left_out": (
            0.0,
            0.4,
            "Chance of each of the situations `ball left`, `ball right` and `ball lost` not to occur to them as one to "
            "put the robot into (chosen; one at least does).",
        ),
        "off_middle_px": (
            -20.0,
            20.0,
            "Where they see the middle of a frame of 160 px, off from where it is (chosen).",
        ),
        "misunderstood": (
            0.2,
            0.2,
            "Chance of a mistake (Reason 1990) about forwardL and forwardR, which they were given `some suggestions` "
            "on: using one of them only, or each for the other side, or either, whichever comes to mind (chosen; "
            "a third each).",
        ),
    }
)
"""The range and source of each trait: least, most, source."""

CARRY_S = (5.0, 15.0)
"""The time to put the robot elsewhere, s (chosen)."""
PATIENCE_S = (20.0, 40.0)
"""The time without success after which they put the robot elsewhere, s (chosen)."""
AT_EDGE = 0.3
"""The share of novices who turn the robot while the ball is near the edge, not only once it is lost (chosen)."""
EDGE_PX = (20.0, 40.0)
"""The distance that those novices consider near the edge, px (chosen)."""
MINUTES_S = 300.0
"""The teaching time of each novice, s (paper section 4.2)."""

SITUATIONS = ("ball left", "ball right", "ball lost")
MISTAKES = ("one only", "other side", "either")
UNDERSTOOD = "none"

SUCCESS = 0.5
"""A novice succeeds if the robot gets to the ball in this share of its trials at least, from the automaton alone."""


@dataclass(frozen=True, slots=True)
class SharedTraits:
    """The traits that all novices share (chosen, where no source is named)."""

    spread: float = 0.3
    """The standard deviation of reactions, as a share of their mean (spreads in Luce 1986)."""
    least_s: float = 0.15
    """The shortest reaction time, s."""
    stop_s: float = 0.2
    """A press due within this time cannot be cancelled, s (stop-signal reaction time, Logan and Cowan 1984)."""
    lapse_s: float = 4.0
    """The mean duration of a lapse, s; single ones last 0.5 to 1.5 times as long."""
    emerged_px: float = EMERGED_PX
    """The distance from the edge at which they see the ball as inside the frame while the robot turns, px."""
    other_px: float = OTHER_PX
    """The distance beyond the middle at which they see the ball in the other half of the frame, px."""
    distance_m: float = 2.5
    """The largest distance from the ball at which they put the robot, m; the smallest is 0.4 of it."""
    given_s: float = MINUTES_S


PARAMETERS = (
    *RANGES,
    "at_edge",
    "edge_px",
    "carry_s",
    "patience_s",
    *(each.name for each in fields(SharedTraits)),
)
"""The names of all parameters: those from which traits are drawn, and the shared ones."""


ALIKE = SharedTraits()


def make_shared_traits(scaled: Mapping[str, float]) -> SharedTraits:
    """Return the shared traits, with some of them multiplied by factors."""
    return SharedTraits(**{name: value * scaled.get(name, 1.0) for name, value in asdict(ALIKE).items()})


@dataclass(frozen=True, slots=True)
class Traits:
    """The traits of one novice."""

    reaction_s: float
    slips: float
    lapses: float
    misjudged: float
    off_middle_px: float
    situations: tuple[str, ...]
    mistake: str
    search: str
    edge_px: float  # 0: they turn only once the ball is lost
    carry_s: float
    patience_s: float


def draw_traits(seed: int, *, scaled: Mapping[str, float] = MappingProxyType({})) -> Traits:
    """Draw the traits of the novice of a seed; `scaled` multiplies some without changing the other draws."""

    def within(name: str, bounds: tuple[float, float], share: float) -> float:
        return (bounds[0] + (bounds[1] - bounds[0]) * share) * scaled.get(name, 1.0)

    draws = np.random.default_rng([seed, 2])
    traits = {
        name: within(name, (least, most), float(draws.random())) for name, (least, most, _) in RANGES.items()
    }
    omitted = draws.random(len(SITUATIONS))
    situations_left = [
        each for each, share in zip(SITUATIONS, omitted.tolist(), strict=True) if share >= traits["left_out"]
    ]
    situations = situations_left or [SITUATIONS[int(np.argmax(omitted))]]
    mistaken, which, left, at_edge, edge, carry, patience = draws.random(7).tolist()
    return Traits(
        reaction_s=traits["reaction_s"],
        slips=min(1.0, traits["slips"]),
        lapses=min(0.9, traits["lapses"]),
        misjudged=traits["misjudged"],
        off_middle_px=traits["off_middle_px"],
        situations=tuple(situations),
        mistake=MISTAKES[int(3 * which)] if mistaken < traits["misunderstood"] else UNDERSTOOD,
        search="left" if left < 0.5 else "right",
        edge_px=within("edge_px", EDGE_PX, edge) if at_edge < AT_EDGE * scaled.get("at_edge", 1.0) else 0.0,
        carry_s=within("carry_s", CARRY_S, carry),
        patience_s=within("patience_s", PATIENCE_S, patience),
    )


BEARINGS_DEG: Mapping[str, tuple[float, float]] = MappingProxyType(
    {"ball left": (8.0, 28.0), "ball right": (-28.0, -8.0), "ball lost": (50.0, 310.0)}
)
"""The range of the ball's bearing in degrees where the robot is put down, by situation."""
FIELD_M = 2.85
"""The distance in m from the ball at which a robot touches the nearest line of the field."""


class Novice(SimulatedPerson):
    """A simulated novice who teaches with the buttons."""

    def __init__(self, traits: Traits, seed: int, habits: SharedTraits = ALIKE) -> None:
        draws = np.random.default_rng([seed, 3])
        mean_s = traits.reaction_s
        super().__init__(draws, ReactionTime(mean_s, habits.spread * mean_s, habits.least_s))
        self.traits, self.habits = traits, habits
        self.slipped = 0
        self.shown: Counter[str] = Counter()
        """The number of times the robot was put into each situation."""
        self.switched: set[tuple[str, str]] = set()
        """The switches that this novice meant to show, from and to."""
        self._away_until = 0.0
        self._side: str | None = None  # where they last saw the ball
        self._unlike_since: float | None = None  # when the robot began not to do what they wish

    def teach(self) -> TrainedAutomaton:
        """Put the robot into one situation after another, drive it for five minutes, and return its automaton."""
        traits, draws, given_s = self.traits, self._draws, self.habits.given_s
        body = Soccer([FIRST_SEED + int(draws.integers(2**40))], self.choose_start(traits.situations[0]))
        session = Session(body, Library(kit), four_states(Library(kit)))
        turn = int(draws.integers(len(traits.situations)))
        while self.seconds < given_s:
            situation = traits.situations[turn % len(traits.situations)]
            body.starts = [self.choose_start(situation)]
            session.reset(FIRST_SEED + int(draws.integers(2**40)))
            self.seconds = min(given_s, self.seconds + traits.carry_s)
            self._side = None
            self.shown[situation] += 1
            left = given_s - self.seconds
            self.show(session, self.wish, until=self.there, limit_s=min(traits.patience_s, left))
            turn += 1
        return session.make_trained_automaton()

    @property
    def draws(self) -> np.random.Generator:
        """The random generator of this novice."""
        return self._draws

    def look_afresh(self) -> None:
        """Forget on which side the ball was, because the robot has been moved."""
        self._side = None

    def notice(self, session: Session, patience_s: float) -> bool:
        """Watch the robot for one tick, correct it if it has been wrong for `patience_s`, and return whether it did."""
        screen, before = session.view(), self.presses
        wished = self.wish(screen)
        if wished in (None, screen.state):
            self._unlike_since = None
        elif self._unlike_since is None:
            self._unlike_since = self.seconds
        since = self._unlike_since
        waits = since is None or self.seconds - since < patience_s
        self._consider(session, None if waits else wished, self.seconds)
        return self.presses > before

    def say(self, session: Session, wished: str | None) -> None:
        """Press a button now, possibly a wrong one, or confirm (None), and run one tick."""
        self.press(session, wished)
        session.tick()

    def press(self, session: Session, wished: str | None) -> None:
        """Press a button now, possibly a wrong one, or confirm (None)."""
        if wished is None:
            session.confirm()
            self.presses += 1
        else:
            self._press(session, wished)

    def consider(self, session: Session, wished: str | None) -> None:
        """Press a wished button once the reaction time has passed, if this novice is looking."""
        self._consider(session, wished, self.seconds)

    def cancel_press(self) -> None:
        """Give up a press that is wished but not made yet."""
        self._due = None

    def choose_start(self, situation: str) -> StartPose:
        """Return the range of places in which this novice puts the robot down, by situation."""
        farthest_m = self.habits.distance_m
        return StartPose((0.4 * farthest_m, min(farthest_m, FIELD_M)), BEARINGS_DEG[situation])

    def there(self, screen: SessionView) -> bool:
        """Return whether the robot is at the ball in this novice's judgment."""
        return screen.features["blob_size(ball)"] >= THERE_PX / (1.0 + self.traits.misjudged) ** 2

    def wish(self, screen: SessionView) -> str | None:
        """Return the state that the robot should be in, or None where this novice accepts the current one."""
        x, state = blob_x(screen), screen.state
        if isnan(x):
            if self._side is not None:
                return self._side
            return None if state in ("left", "right") else self.traits.search
        off = x - MIDDLE_PX - self.traits.off_middle_px
        self._side = "left" if off < 0 else "right"
        inside = min(x, 2 * MIDDLE_PX - x)
        if inside < self.traits.edge_px:
            return self._side
        if state in ("left", "right"):
            return self._forward() if inside > self.traits.edge_px + self.habits.emerged_px else None
        if state == "start" or abs(off) > self.habits.other_px:
            return self._forward(now=state)
        return None

    def _forward(self, *, now: str = "") -> str:
        """Return the forward state that this novice believes to belong to the side of the ball."""
        right = self._side == "right"
        if self.traits.mistake == UNDERSTOOD:
            return "forwardR" if right else "forwardL"
        if self.traits.mistake == "other side":
            return "forwardL" if right else "forwardR"
        if self.traits.mistake == "one only" or now == "forwardL":
            return "forwardL"
        if now == "forwardR":
            return now
        return self._either

    _either = "forwardL"
    buttons: tuple[str, ...] = ("left", "right", "forwardL", "forwardR")
    """The buttons that a slip may hit."""

    def _consider(self, session: Session, wished: str | None, now: float) -> None:
        tick_s = session.body.tick_s
        if self.seconds < self._away_until:
            return
        mean_s, share = self.habits.lapse_s, self.traits.lapses
        if self._draws.random() < tick_s * share / (1.0 - share) / mean_s:
            self._away_until = self.seconds + float(self._draws.uniform(0.5 * mean_s, 1.5 * mean_s))
            return
        due = self._due
        if due is not None and wished != due[0] and due[1] - now <= self.habits.stop_s:
            if now >= due[1] - 1e-9:
                self._press(session, due[0])  # too late to hold it back
            return
        super()._consider(session, wished, now)

    def _press(self, session: Session, wished: str) -> None:
        self.switched.add((session.view().state, wished))
        others = [state for state in self.buttons if state != wished]
        if self._draws.random() < self.traits.slips:
            wished = others[int(self._draws.integers(len(others)))]
            self.slipped += 1
        self._either = ("forwardL", "forwardR")[int(self._draws.integers(2))]
        super()._press(session, wished)
