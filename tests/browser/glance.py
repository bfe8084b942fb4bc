"""What a person takes in at a glance at the page: the screen of the session, read off what is written there."""

from __future__ import annotations

import re
from math import nan, radians
from typing import Any

from playwright.sync_api import Page

from understudy.model.value_kinds import NO, YES
from understudy.training.trainee import Mode, SessionView

LOOK = """() => {
  const all = (selector) => [...document.querySelectorAll(selector)];
  const text = (selector) => document.querySelector(selector)?.innerText ?? "";
  const content = (selector) => document.querySelector(selector)?.textContent ?? "";
  return {
    features: all(".reading").map((each) => [each.dataset.feature, each.querySelector("b").textContent]),
    states: all(".state").map(({ dataset }) => dataset.state),
    state: all(".state.on").map(({ dataset }) => dataset.state)[0] ?? "",
    flag: all(".state.flag.on").length > 0,
    waiting: all(".state.waiting").map(({ dataset }) => dataset.state)[0] ?? null,
    testing: text(".modes [aria-pressed=true]") === "Try",
    clock: content(".time"),
    path: document.querySelector(".path")?.dataset.path ?? "",
    examples: Number(content("#tab-lesson").replace(/\\D+/g, "")),
  };
}"""
"""All that a person takes in at a glance."""
CLOCK = re.compile(r"(\d+):([\d.]+)")


def glance(page: Page) -> SessionView:
    """What the page shows now."""
    seen: dict[str, Any] = page.evaluate(LOOK)
    clock = CLOCK.search(seen["clock"])
    return SessionView(
        time_s=int(clock[1]) * 60 + float(clock[2]) if clock else 0.0,
        mode=Mode.TESTING if seen["testing"] else Mode.TRAINING,
        state=seen["state"],
        path=tuple(seen["path"].split("/")) if seen["path"] else (seen["state"],),
        flag=seen["state"] if seen["flag"] else None,
        features={label: parse_value(text) for label, text in seen["features"]},
        states=tuple(seen["states"]),
        targets={},
        waiting=seen["waiting"],
        examples=seen["examples"],
        undoable=None,
        redoable=None,
    )


def parse_value(text: str) -> float:
    """A value as the page writes it: 3.42 m, −31°, yes; angles in rad, a dash where it is absent."""
    if text in ("yes", "no"):
        return YES if text == "yes" else NO
    found = re.match(r"-?[\d.]+", text.replace("−", "-"))
    if found is None:
        return nan
    return radians(float(found[0])) if text.endswith("°") else float(found[0])
