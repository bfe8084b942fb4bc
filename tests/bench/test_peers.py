"""What peers compute is the base task, and so does the prototype: all equal plain NumPy."""

from __future__ import annotations

import warnings
from importlib import import_module
from math import nan

import numpy as np
import pytest

from tests.bench.reference import Reference, decide
from understudy.bench import programs, standard
from understudy.bench.peers.mesa_base import MesaBase
from understudy.bench.peers.vmas_base import VmasBase
from understudy.bench.prototype import LEVELS, READINGS, Prototype, table
from understudy.errors import UnderstudyError
from understudy.runtime.interpreter import Interpreter
from understudy.runtime.program import link

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
    made = Prototype(robots, programs.base(), programs.BASE, sonar=False)
    reference = Reference(robots)
    for _ in range(30):
        made.run(1)
        reference.run(1)
    order = np.lexsort(made.place[:2])
    expected = reference.places.T[:, np.lexsort(reference.places.T[:2])]
    np.testing.assert_allclose(made.place[:, order], expected, atol=1e-9)


def test_the_program_of_base_decides_as_peers_do() -> None:
    random = np.random.default_rng(0)
    interpreter = Interpreter(link(programs.base(), programs.BASE))
    interpreter.start(0.0)
    commands = {name: (way.get("drive", 0.0), way.get("turn", 0.0)) for name, way in standard.COMMANDS.items()}
    for tick in range(2000):
        beacon, robot = random.uniform(0, 2, 2)
        angle, bearing = random.uniform(0, TAU, 2)
        if random.random() < 0.2:
            robot = bearing = nan
        pulse = interpreter.pulse((robot, bearing, beacon, angle), tick * 0.1)
        expected = decide(beacon, angle, robot, bearing)
        assert commands.get(interpreter_behavior(pulse), (0.0, 0.0)) == expected
