"""What peers compute is the base task, and so does the prototype: all equal plain NumPy."""

from __future__ import annotations

import sys
import warnings
from math import nan

import numpy as np
import pytest
from tests.lab.bench.reference import Reference, decide

from understudy.model.features import BoundFeature, Feature
from understudy.runtime.interpreter import Interpreter
from understudy.runtime.link import link
from understudy_lab.bench import standard_task
from understudy_lab.bench._handwritten_kernels import decide as decide_flat
from understudy_lab.bench._handwritten_kernels import sonar
from understudy_lab.bench.handwritten_baseline import READINGS, HandwrittenBaseline, table
from understudy_lab.bench.harness import PeerMissing
from understudy_lab.bench.mesa_case import MesaBase
from understudy_lab.bench.standard_task import Column
from understudy_lab.bench.vmas_case import VmasBase

TAU = 2 * np.pi


@pytest.mark.parametrize("kd_tree", [False, True], ids=["space", "tree"])
def test_mesa_does_the_base_task(kd_tree: bool) -> None:
    pytest.importorskip("mesa", exc_type=ImportError)
    peer, reference = MesaBase(60, kd_tree=kd_tree), Reference(60)
    for _ in range(30):
        expected = reference.readings
        peer.run(1)
        reference.run(1)
        np.testing.assert_allclose(peer.readings, expected, atol=1e-9)
        np.testing.assert_allclose(peer.places, reference.places, atol=1e-9)


@pytest.mark.parametrize(("each", "worlds"), [(10, 4), (100, 1)])
def test_vmas_does_the_base_task(each: int, worlds: int) -> None:
    """In single precision, so that a robot within 1e-4 of a decision may take it the other way."""
    pytest.importorskip("torch")
    with warnings.catch_warnings():  # those of the packages it brings are none of ours
        warnings.simplefilter("ignore")
        pytest.importorskip("vmas")
        peer = VmasBase(each, worlds=worlds, threads=1)
    references = [Reference(each, seed) for seed in range(worlds)]
    for _ in range(30):
        np.testing.assert_allclose(
            peer.readings, np.concatenate([world.readings for world in references]), atol=2e-4
        )
        peer.run(1)
        for world in references:
            world.run(1)
    places = np.concatenate([world.places for world in references])
    np.testing.assert_allclose(peer.places, places, atol=2e-4)


@pytest.mark.parametrize("robots", [60, 700])
def test_the_prototype_does_the_base_task(robots: int) -> None:
    made = HandwrittenBaseline(robots, standard_task.make_base_library(), standard_task.BASE, sonar=False)
    reference = Reference(robots)
    for _ in range(30):
        made.run(1)
        reference.run(1)
    order = np.lexsort(made.place[:2])
    expected = reference.places.T[:, np.lexsort(reference.places.T[:2])]
    np.testing.assert_allclose(made.place[:, order], expected, atol=1e-9)


def test_the_program_of_base_decides_as_peers_do() -> None:
    """On 2 000 random readings."""
    random = np.random.default_rng(0)
    program = link(standard_task.make_base_library(), standard_task.BASE)
    interpreter = Interpreter(program)
    interpreter.start(0.0)
    for _ in range(2000):
        beacon, robot = random.uniform(0.0, 2.0, 2)
        angle, bearing = random.uniform(0.0, TAU, 2)
        if random.random() < 0.2:
            robot = bearing = nan
        decided = program.basics[interpreter.pulse((robot, bearing, beacon, angle), 0.0)].behavior.command
        assert (decided.get("drive", 0.0), decided.get("turn", 0.0)) == decide(beacon, angle, robot, bearing)


def test_the_prototype_decides_as_the_interpreter_does() -> None:
    """Ten robots that run the full task's three levels on random readings, for 300 ticks each."""
    library = standard_task.make_full_library()
    program = link(library, standard_task.FULL)
    tests, numbers, roots, children, flags, starts, commands = table(library)
    columns = [_column(bound) for bound in program.features]
    random = np.random.default_rng(1)
    reached = set()
    for _ in range(10):
        interpreter = Interpreter(program)
        interpreter.start(0.0)
        made = HandwrittenBaseline(1, library, standard_task.FULL, sonar=True)
        for tick in range(300):
            values = _random_readings(random)
            state = decide_flat(made.stack[0], tests, numbers, roots, children, flags, starts, values)
            reached.add(state)
            decided = program.basics[interpreter.pulse(values[columns].tolist(), tick * 0.1)].behavior
            expected = [decided.command.get(channel, 0.0) for channel in ("drive", "turn")]
            assert commands[state].tolist() == expected
    assert len(reached) > 10


def _column(bound: BoundFeature) -> int:
    assert isinstance(bound.feature, Feature)
    assert bound.feature.reading is not None
    return READINGS[bound.feature.reading, bound.binding.get("A")]


def _random_readings(random: np.random.Generator) -> Column:
    values = random.uniform(0.0, 1.2, len(READINGS))
    values[[1, 3]] = random.uniform(0.0, TAU, 2)
    if random.random() < 0.5:
        values[2:4] = nan
    return values


def test_sonar_of_the_prototype_equals_many_beams() -> None:
    """The nearest of 2 000 beams in a sector is what the sector reads."""
    made = HandwrittenBaseline(80, standard_task.make_full_library(), standard_task.FULL, sonar=True)
    side, radius, _, most, *_ = made.sizes
    for x, y, heading in made.place.T:
        values = np.zeros(len(READINGS))
        sonar(x, y, np.cos(heading), np.sin(heading), side, made.obstacles, radius, made.edges, most, values)
        for index, (first, last) in enumerate(standard_task.SECTORS.values()):
            angles = heading + np.radians(np.linspace(first, last, 2001))
            ways = np.column_stack([np.cos(angles), np.sin(angles)])
            expected = np.clip(_beams(np.array([x, y]), ways, made.obstacles, side).min() - radius, 0.0, most)
            assert values[4 + index] == pytest.approx(expected, abs=2e-3)


def _beams(place: Column, ways: Column, obstacles: Column, side: float) -> Column:
    """How far each beam [B] goes until it meets an obstacle or the arena's bounds."""
    with np.errstate(divide="ignore"):
        walls = np.where(ways > 0, (side - place) / ways, -place / ways).min(1)
    offsets = obstacles[:, :2] - place
    along = ways @ offsets.T
    beside = (offsets**2).sum(1) - along**2
    depth = np.sqrt(np.clip(obstacles[:, 2] ** 2 - beside, 0.0, None))
    hit = (beside < obstacles[:, 2] ** 2) & (along > 0)
    reached: Column = np.minimum(walls, np.where(hit, along - depth, np.inf).min(1))
    return reached


@pytest.mark.parametrize("module", ["mesa", "torch"])
def test_a_missing_peer_says_how_to_get_it(module: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(PeerMissing, match=r"understudy-robots\[bench(-vmas)?\]"):
        MesaBase(10) if module == "mesa" else VmasBase(10, worlds=1, threads=1)
