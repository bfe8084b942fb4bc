"""Columns of numbers packed into one line of text, bit for bit: base64 of zlib of little-endian float64."""

from __future__ import annotations

import zlib
from base64 import b64decode, b64encode

import numpy as np

from understudy.model.kinds import Column


def pack(column: Column) -> str:
    """A column as text."""
    return b64encode(zlib.compress(np.ascontiguousarray(column, dtype="<f8").tobytes(), 9)).decode("ascii")


def unpack(text: str, *, length: int) -> Column:
    """The column that `pack` made a text of; ValueError saying what is wrong with it."""
    try:
        packed = b64decode(text.encode("ascii"), validate=True)
        unzip = zlib.decompressobj()
        data = unzip.decompress(packed, 8 * length + 1)  # never more than asked for, whatever the text claims
        whole = unzip.eof and not unzip.unused_data
    except (ValueError, zlib.error) as error:
        raise ValueError("it is damaged") from error
    if not whole or len(data) != 8 * length:
        raise ValueError(f"it does not hold exactly {length} numbers")
    return np.frombuffer(data, dtype="<f8").astype(np.float64)
