"""Representations of values: a line for `repr`, and plots and notebook pictures, drawn by the package `viz`.

A value must not import what draws it: `viz` is a higher layer. So its methods name the function that draws, and the
function is looked up when it is called.
"""

from __future__ import annotations

from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any, TypeAlias

if TYPE_CHECKING:
    import matplotlib.axes

Axes: TypeAlias = "matplotlib.axes.Axes"
"""Axes of matplotlib, into which a plot is drawn."""
PACKAGE = "understudy.viz"


def call_plot(function: str, *args: Any, **settings: Any) -> Axes:
    """Call a function of `viz` that plots, named `module:function`; return the axes that it plotted into."""
    axes: Axes = resolve_name(f"{PACKAGE}.{function}")(*args, **settings)
    return axes


def call_markup(function: str, *args: Any) -> str:
    """Call a function of `viz` that makes SVG or HTML, named `module:function`; return the text."""
    text: str = resolve_name(f"{PACKAGE}.{function}")(*args)
    return text


MOST_LETTERS = 120
"""The length of a line for `repr`; longer ones are cut."""


def format_repr(value: object, name: str, *facts: str) -> str:
    """Format a value in one line for `repr`, such as "<Automaton 'goto(A)': 4 states, 2 features>"."""
    text = f"{type(value).__name__} {name}: {', '.join(facts)}".replace("\n", " ").removesuffix(": ")
    return f"<{text if len(text) <= MOST_LETTERS - 2 else text[: MOST_LETTERS - 3] + '…'}>"


def format_number_of(number: int, one: str, many: str = "") -> str:
    """Format a number with its noun: "1 state", "3 states"."""
    return f"{number} {one if number == 1 else many or one + 's'}"
