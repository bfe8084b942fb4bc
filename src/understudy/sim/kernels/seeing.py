"""What a camera looks at, and how it appears in its frame, as records of plain numbers.

In the camera's frame (m): x along its view, y to the left. Across the frame counts the tangent to the right of the
middle, -y / x, so that its edges are at -tan and +tan of half the angle of view.
"""

from __future__ import annotations

import numpy as np

THING = np.dtype(
    [
        ("x", "f8"),
        ("y", "f8"),
        ("radius", "f8"),
        ("height", "f8"),
        ("color", "i4"),  # index, -1 none
        ("opaque", "i4"),  # 1: hides what is behind it; 0: does not; -1: nothing hides it either
    ],
    align=True,
)
"""A disc."""

VIEW = np.dtype(
    [
        ("left", "f8"),  # where it appears, cut by the frame
        ("right", "f8"),
        ("power", "f8"),  # of the camera with respect to a disc: its tangents' length squared
        ("squared", "f8"),  # distance to a disc's center, squared
        ("height_px", "f8"),
        ("nearness", "f8"),  # of a segment: 1 / distance along the view, in the middle of the frame
        ("slope", "f8"),  # and by how much that grows across the frame
        ("cut_left", "f8"),  # memory for what hides one view: the list of cuts has no relation to this view
        ("cut_right", "f8"),
        ("color", "i4"),  # of a disc; -1: no blob, it only hides others
        ("opaque", "i4"),
    ],
    align=True,
)
"""A disc or a segment in the frame."""
