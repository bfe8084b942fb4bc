"""Show sessions in notebooks."""

from __future__ import annotations

from asyncio import get_running_loop
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING

from understudy.errors import SessionError
from understudy.extras import ExtraMissing
from understudy.training.session import Session
from understudy.ui.notebook.session_driver import SessionDriver

if TYPE_CHECKING:
    from understudy.ui.notebook.session_widget import SessionWidget


def show_session(
    session: Session, *, speed: float = 1.0, library_folder: Path | str | None = None
) -> SessionWidget:
    """Show a session in a notebook, to teach and to try a robot there.

    The world runs in real time, between the cells, while the widget is on a screen. The session stays usable from
    cells: `session.lesson` has every press, and what cells change is shown. A session that is shown already gets a
    further view. What was pressed is in the session's journal if it has one, as in all user interfaces.

    Parameters
    ----------
    session
        A session whose body is a simulated world, or the squads of one.
    speed
        How many times as fast as real time the world runs: 0.25, 0.5, 1, 2, 4, 8, 16 or infinity.
    library_folder
        Folder of the library in which *Save* saves the automaton. None: there is no such button, and
        `save_automaton` saves it from a cell.

    Returns
    -------
    SessionWidget
        The widget, which a notebook shows where it is the last value of a cell.

    Raises
    ------
    ExtraMissing
        If anywidget is not installed.
    SessionError
        If this is not a notebook, or the session cannot be shown in one.
    SettingError
        If the speed is not one of those above, or the body's ticks have no length.
    """
    try:
        from understudy.ui.notebook import session_widget
    except ModuleNotFoundError as error:
        if error.name not in ("anywidget", "ipywidgets", "traitlets"):
            raise
        raise ExtraMissing(what="a session in a notebook", extra="notebook") from None
    try:
        get_running_loop()
    except RuntimeError:
        raise SessionError(
            "show_session works in a cell of a notebook only: a program has no event loop"
        ) from None
    widget = session_widget.find_widget(session)
    if widget is not None:
        return widget
    folder = None if library_folder is None else Path(library_folder)
    return session_widget.SessionWidget(SessionDriver(session, speed=speed, folder=folder, wall=monotonic))
