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
        ("opaque", "i4"),  # 1: hides what is behind it
    ],
    align=True,
)
"""A disc."""

VIEW = np.dtype(
    [
        ("left", "f8"),  # where it appears, cut by the frame
        ("right", "f8"),
        ("power", "f8"),  # of the camera with respect to the disc: its tangents' length squared
        ("squared", "f8"),  # distance to its center, squared
        ("height_px", "f8"),
        ("color", "i4"),  # -1: no blob, it only hides others
        ("opaque", "i4"),
    ],
    align=True,
)
"""A disc in the frame."""

SCREEN = np.dtype(
    [
        ("left", "f8"),
        ("right", "f8"),
        ("across_x", "f8"),  # from one end to the other
        ("across_y", "f8"),
        ("squared", "f8"),  # distance of the camera from its line times its length, squared
    ],
    align=True,
)
"""A segment in the frame."""
