"""Packing of numbers or bytes into one line of text without loss: base64 of zlib."""

from __future__ import annotations

import sys
import zlib
from array import array
from base64 import b64decode, b64encode
from collections.abc import Iterable


def pack_column(column: Iterable[float]) -> str:
    """Pack a column of numbers into text, as little-endian float64."""
    return pack_bytes(_swap_if_big_endian(array("d", column)).tobytes())


def pack_bytes(data: bytes) -> str:
    """Pack bytes into text."""
    return b64encode(zlib.compress(data, 9)).decode("ascii")


def unpack_bytes(text: str, *, most: int) -> bytes:
    """Unpack the bytes from a text made by `pack_bytes`; refuse damaged text and more than `most` bytes.

    Refusals are ValueErrors.
    """
    try:
        packed = b64decode(text.encode("ascii"), validate=True)
        unzip = zlib.decompressobj()
        data = unzip.decompress(packed, most + 1)
        whole = unzip.eof and not unzip.unused_data
    except (ValueError, zlib.error) as error:
        raise ValueError("it is damaged") from error
    if not whole or len(data) > most:
        raise ValueError(f"it is cut short, or more than {most} bytes")
    return data


def unpack_column(text: str, *, length: int) -> array[float]:
    """Unpack the `length` numbers from a text made by `pack_column`; refuse damaged text with a ValueError."""
    try:
        packed = b64decode(text.encode("ascii"), validate=True)
        unzip = zlib.decompressobj()
        data = unzip.decompress(
            packed, 8 * length + 1
        )  # never more than asked for, even if the text claims more
        whole = unzip.eof and not unzip.unused_data
    except (ValueError, zlib.error) as error:
        raise ValueError("it is damaged") from error
    if not whole or len(data) != 8 * length:
        raise ValueError(f"it does not hold exactly {length} numbers")
    return _swap_if_big_endian(array("d", data))


def _swap_if_big_endian(column: array[float]) -> array[float]:
    if sys.byteorder == "big":
        column.byteswap()
    return column
