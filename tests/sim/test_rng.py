"""Random draws: the same to the last digit on all computers, and those of the former generator where it is named."""

from __future__ import annotations

from decimal import Decimal, getcontext
from math import cos, log, pi, sqrt, ulp

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from understudy.sim.kernels.rng import FORMER, compute_logarithm, draw_normal, draw_uniform
from understudy.sim.scenario.files import list_builtin_scenarios, load_scenario
from understudy.sim.world import World

getcontext().prec = 40


@given(st.floats(min_value=2.0**-53, max_value=1.0) | st.floats(min_value=1e-300, max_value=1e300))
def test_the_logarithm_is_within_one_ulp(x: float) -> None:
    exact = Decimal(x).ln()
    assert abs(Decimal(compute_logarithm(x)) - exact) <= Decimal(ulp(float(exact)))


@pytest.mark.parametrize("x", [1.0, 2.0**-53, 1.0 - 2.0**-53, 0.5, sqrt(0.5)])
def test_the_logarithm_at_its_ends(x: float) -> None:
    assert abs(compute_logarithm(x) - log(x)) <= ulp(log(x))


DRAWN = {  # seed, item, tick, stream
    (0, 0, 0, 0): "-0x1.cbcb92108957ap-2",
    (1, 0, 0, 0): "0x1.72b94d7b1850bp-2",
    (7, 3, 100, 18): "0x1.d0fd5af7ee191p-3",
    (2**40, 11, 5, 16): "-0x1.7fe25300943a2p-2",
}


@pytest.mark.parametrize(("key", "drawn"), DRAWN.items())
def test_a_seed_draws_the_same_on_all_computers(key: tuple[int, int, int, int], drawn: str) -> None:
    assert draw_normal(*key, 2).hex() == drawn


@pytest.mark.parametrize("key", DRAWN)
def test_the_former_generator_draws_with_the_library_of_the_computer(key: tuple[int, int, int, int]) -> None:
    seed, item, tick, stream = key
    turn = draw_uniform(seed, item, tick, stream + 1)
    expected = sqrt(-2.0 * log(1.0 - draw_uniform(*key))) * cos(2.0 * pi * turn)
    assert draw_normal(*key, FORMER) == expected
    assert draw_normal(*key, 2) == pytest.approx(expected, abs=1e-14)


@pytest.mark.parametrize("name", list_builtin_scenarios())
def test_a_scenario_may_name_the_former_generator(name: str) -> None:
    """Its worlds are those of the present one, but for the last digits."""
    now, former = (World(replace(load_scenario(name), generator=number), range(20)) for number in (2, FORMER))
    for each in ("x", "y", "heading"):
        np.testing.assert_allclose(now.state.robots[each], former.state.robots[each], rtol=0, atol=1e-9)
