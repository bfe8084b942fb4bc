"""Rows of an SQLite file whose tree of pages is broken, as that of a bag that was cut: found page by page.

SQLite reaches rows from the first page of their table on. In a large file it comes upon a page that is lost before it
has seen the rows that are still there. See https://www.sqlite.org/fileformat2.html.
"""

from __future__ import annotations

import mmap
from array import array
from collections.abc import Collection, Iterator, Sequence
from itertools import accumulate
from pathlib import Path
from struct import Struct, error
from typing import NamedTuple

import numpy as np

LEAF = 13
"""The first byte of a page that has rows of a table."""
LEAF_HEAD, CELL, PAGE = Struct(">BHHHB"), Struct(">H"), Struct(">I")
PAGE_SIZE, RESERVED = Struct(">H"), 20
"""The size of a page, at byte 16 of a file, and the place of the number of bytes that are reserved in each page."""
INTEGER_BYTES = {1: 1, 2: 2, 3: 3, 4: 4, 5: 6, 6: 8}
"""The sizes of whole numbers by their type."""
ZERO, ONE = 8, 9
"""The types of the whole numbers 0 and 1, which have no bytes."""
WHOLE_NUMBERS = {*INTEGER_BYTES, ZERO, ONE}
LAST_NUMBER = 2**63 - 1
FIRST_BLOB = 12
"""The type of a blob without bytes; larger ones have even numbers."""


class SalvagedRow(NamedTuple):
    """A row of messages: its number, and the topic's number, the time in ns and the bytes of the message.

    The bytes are None if the topic was not asked for.
    """

    number: int
    topic: int
    time_ns: int
    data: bytes | None


class _NoRow(Exception):
    """Bytes that are no row of the table."""


def salvage_rows(
    path: Path | str, columns: Sequence[str], *, topics: Collection[int], after: int
) -> Iterator[SalvagedRow]:
    """Find the rows of the table of messages on all pages of a file, and yield them by their numbers.

    Parameters
    ----------
    path
        The file.
    columns
        The columns of the table; "topic_id", "timestamp" and "data" are among them.
    topics
        The numbers of the topics whose messages are read.
    after
        Rows up to this number are left out.

    Yields
    ------
    SalvagedRow
        A row all of whose pages are there.
    """
    with Path(path).open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
        pages = _Pages(content, columns)
        numbers, cells = pages.list_rows()
        last = after
        for row in np.argsort(np.array(numbers, np.int64), kind="stable").tolist():
            if numbers[row] <= last:
                continue  # read before, or on a page that was written again elsewhere
            try:
                salvaged = pages.read_row(cells[row], topics)
            except (_NoRow, IndexError, error):
                continue  # a page of a long message is lost
            last = numbers[row]
            yield salvaged


class _Pages:
    def __init__(self, content: mmap.mmap, columns: Sequence[str]) -> None:
        self._content, self._count = content, len(columns)
        self._wanted = [columns.index(name) for name in ("topic_id", "timestamp", "data")]
        (size,) = PAGE_SIZE.unpack_from(content, 16)
        self._size = 65_536 if size == 1 else size
        self._usable = self._size - content[RESERVED]

    def list_rows(self) -> tuple[array[int], array[int]]:
        """List the numbers and the places of all rows that look like messages."""
        numbers, cells = array("q"), array("q")
        for page in range(self._size, len(self._content) - self._size + 1, self._size):
            if self._content[page] != LEAF:
                continue
            try:
                rows = self._list_page(page)
            except (_NoRow, IndexError, error):
                continue  # a page of another table, or of a long message that begins as a leaf does
            for number, cell in rows:
                numbers.append(number)
                cells.append(cell)
        return numbers, cells

    def _list_page(self, page: int) -> list[tuple[int, int]]:
        _, _, count, _, _ = LEAF_HEAD.unpack_from(self._content, page)
        first, rows = LEAF_HEAD.size + CELL.size * count, list[tuple[int, int]]()
        if first > self._usable:
            raise _NoRow
        for at in range(page + LEAF_HEAD.size, page + first, CELL.size):
            (place,) = CELL.unpack_from(self._content, at)
            if not first <= place < self._usable:
                raise _NoRow
            length, number, begin = self._read_cell(page + place)
            self._read_head(begin, length)
            if number > LAST_NUMBER:
                raise _NoRow  # a negative one, which no recorder writes
            rows.append((number, page + place))
        return rows

    def _read_cell(self, cell: int) -> tuple[int, int, int]:
        """Return the length of a row, its number, and where it begins."""
        length, at = self._read_varint(cell)
        number, at = self._read_varint(at)
        return length, number, at

    def _read_head(self, begin: int, length: int) -> tuple[list[int], int]:
        """Return the types of the values of a row, and the length of this list."""
        head, at = self._read_varint(begin)
        end, types = begin + head, list[int]()
        while at < end and len(types) <= self._count:
            type, at = self._read_varint(at)
            types.append(type)
        topic, time, data = (types[each] if each < len(types) else -1 for each in self._wanted)
        is_blob = data >= FIRST_BLOB and data % 2 == 0
        if at != end or len(types) != self._count or not is_blob or not {topic, time} <= WHOLE_NUMBERS:
            raise _NoRow
        if head + sum(_count_bytes(each) for each in types) != length:
            raise _NoRow
        return types, head

    def read_row(self, cell: int, topics: Collection[int]) -> SalvagedRow:
        """Read a row; _NoRow is raised if a page of it is lost."""
        length, number, begin = self._read_cell(cell)
        types, head = self._read_head(begin, length)
        ends = list(accumulate(map(_count_bytes, types), initial=head))
        topic, time, data = self._wanted
        which, time_ns = (
            types[each] - ZERO
            if types[each] in (ZERO, ONE)
            else int.from_bytes(
                self._content[begin + ends[each] : begin + ends[each + 1]], "big", signed=True
            )
            for each in (
                topic,
                time,
            )  # which lie in the page itself, since they come before the bytes of the message
        )
        if which not in topics:
            return SalvagedRow(number, which, time_ns, None)
        return SalvagedRow(
            number, which, time_ns, self._read_payload(begin, length)[ends[data] : ends[data + 1]]
        )

    def _read_payload(self, begin: int, length: int) -> bytes:
        """Read the bytes of a row, which may go on on other pages."""
        most, least = self._usable - 35, (self._usable - 12) * 32 // 255 - 23
        here = length
        if length > most:
            here = least + (length - least) % (self._usable - PAGE.size)
            here = here if here <= most else least
        parts, left = [self._content[begin : begin + here]], length - here
        at = begin + here
        while left > 0:
            (page,) = PAGE.unpack_from(self._content, at)
            at = (page - 1) * self._size
            if page < 2 or at + self._size > len(self._content):
                raise _NoRow
            taken = min(left, self._usable - PAGE.size)
            parts.append(self._content[at + PAGE.size : at + PAGE.size + taken])
            left -= taken
        return b"".join(parts)

    def _read_varint(self, at: int) -> tuple[int, int]:
        """Return a number of variable length, and where it ends."""
        value = 0
        for _ in range(8):
            byte = self._content[at]
            at += 1
            value = value << 7 | byte & 127
            if byte < 128:
                return value, at
        return value << 8 | self._content[at], at + 1


def _count_bytes(type: int) -> int:
    return INTEGER_BYTES.get(type, 8 if type == 7 else (type - FIRST_BLOB) // 2 if type >= FIRST_BLOB else 0)
