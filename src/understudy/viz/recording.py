"""A run kept for its picture: all of a short one, every so often of a long one, in bounded memory."""

from __future__ import annotations

from understudy.sim.view import Frame

MOST_BUFFERED_FRAMES, LEAST_FRAMES, MOST_ROWS = 20_000, 600, 2_000_000


class Recording:
    """Frames of a run: when they become too many, every other one goes, and from then on half as many come."""

    def __init__(self, most: int | None = None) -> None:
        """`most` frames are kept; if left out, as many as are good for so many robots."""
        self._most, self._frames, self._every, self._seen = most, list[Frame](), 1, 0
        self._last: Frame | None = None

    def see(self, frame: Frame) -> None:
        """The next moment of the run."""
        most = self._most or min(
            MOST_BUFFERED_FRAMES, max(LEAST_FRAMES, MOST_ROWS // max(1, len(frame.doing)))
        )
        if self._seen % self._every == 0:
            if len(self._frames) >= most:
                self._frames, self._every = self._frames[::2], 2 * self._every
            if self._seen % self._every == 0:
                self._frames.append(frame)
        self._seen += 1
        self._last = frame

    @property
    def frames(self) -> list[Frame]:
        """What was kept; the first moment and the last are always among it."""
        late = self._last is not None and self._frames[-1] is not self._last
        return [*self._frames, self._last] if late and self._last is not None else list(self._frames)
