"""Sessions in notebooks: buttons, a picture of the world and the live automaton, through anywidget."""

from understudy.ui.notebook.show_session import show_session as show_session

__all__ = ["show_session"]
