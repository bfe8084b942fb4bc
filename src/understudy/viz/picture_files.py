"""Write the pictures that a body draws of itself as an animated GIF, or the last one as a PNG."""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from understudy.storage.atomic_write import write_atomically

LAST_MS = 2500
"""How long the last picture of an animation stays, ms."""
QUALITY = 92


def encode_jpeg(picture: NDArray[np.uint8]) -> bytes:
    """Encode a picture [height, width, 3] as a JPEG, with sharp edges of colors."""
    from PIL import Image

    encoded = BytesIO()
    Image.fromarray(picture).save(encoded, "JPEG", quality=QUALITY, subsampling=0)
    return encoded.getvalue()


def write_picture_gif(pictures: Sequence[NDArray[np.uint8]], path: Path | str, *, per_s: float) -> None:
    """Write pictures [height, width, 3] as an animated GIF, `per_s` of them a second; there must be at least one."""
    from PIL import Image

    first, *others = [Image.fromarray(each).quantize() for each in pictures]
    times = [round(1000 / per_s / 10) * 10] * len(others) + [LAST_MS]
    encoded = BytesIO()
    first.save(encoded, "GIF", save_all=True, append_images=others, duration=times, loop=0)
    write_atomically(Path(path), encoded.getvalue())


def write_picture_png(picture: NDArray[np.uint8], path: Path | str) -> None:
    """Write a picture [height, width, 3] as a PNG."""
    from PIL import Image

    encoded = BytesIO()
    Image.fromarray(picture).save(encoded, "PNG")
    write_atomically(Path(path), encoded.getvalue())
