"""A body of one's own in the terminal: its readings in place of a drawing, and teaching by keys."""

from __future__ import annotations

from pathlib import Path

from tests.own_worlds import NAME
from tests.ui.terminal.desks import make_trainer
from tests.ui.terminal.test_main_screen import run

from understudy.addons.bridges.environments.body_maker import BodyMaker
from understudy.model.library import Library
from understudy.sim.body_world import BodyWorld
from understudy.ui.controller.training_plan import LessonChoices, TrainingPlan

CLIMB = LessonChoices(live=False, states=["ahead", "back"], features=["x"], flags=["done"])


@run
async def test_taught_by_keys(tmp_path: Path) -> None:
    maker = BodyMaker(f"{NAME}:make_slope")
    world = BodyWorld(maker, 7, name=maker.name)
    plan = TrainingPlan("climb", tmp_path / "library", world.scenario, Library(maker.find_kit()), CLIMB, 7)
    async with make_trainer(plan, ground=world) as hand:
        assert "No drawing here. Readings:\nx                  7.00 m" in hand.read_part("world")
        assert hand.trainer.paused
        ahead = next(key for key, state in hand.trainer.keys.leads.items() if state == "ahead")
        await hand.press(ahead, "full_stop", "full_stop")
        assert "8.00 m" in hand.read_part("world")
        for _ in range(4):
            await hand.press("full_stop")
        assert hand.trainer.status.text.startswith("The episode is over after 3.0 s.")
        await hand.press("n")
        assert world.seeds == (8,)
        assert "8.00 m" in hand.read_part("world")
        await hand.press("s")
        assert (tmp_path / "library" / "climb.json").is_file()
