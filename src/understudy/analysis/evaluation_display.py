"""Representations of an evaluation: a line for `repr`, a card in notebooks, and a plot."""

from __future__ import annotations

from understudy.analysis.intervals import exact_interval_of_share
from understudy.model.drawing import Axes, call_markup, call_plot


class EvaluationDisplay:
    """The part of an evaluation that represents it."""

    def _repr_html_(self) -> str:
        return call_markup("html_cards:write_evaluation_html", self, exact_interval_of_share)

    def plot(self, ax: Axes | None = None) -> Axes:
        """Plot the share of worlds that had finished by each time, with exact 95 % intervals.

        Parameters
        ----------
        ax
            Axes of matplotlib to draw into. None: in a new figure.

        Returns
        -------
        Axes
            The axes: time in s to the right, share of worlds upward.
        """
        return call_plot("evaluation_plot:plot_evaluation", self, exact_interval_of_share, ax)
