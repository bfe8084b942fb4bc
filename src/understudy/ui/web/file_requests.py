"""Requests of a page that send or bring files, such as a zip of the library, and their replies; however they come."""

from __future__ import annotations

from collections.abc import AsyncIterable, Awaitable, Callable, Mapping, Sequence
from dataclasses import dataclass, field

from understudy.errors import UnderstudyError
from understudy.storage.json_text import encode_json
from understudy.ui.controller.status import describe_error

FRESH = {"Cache-Control": "no-store", "X-Content-Type-Options": "nosniff"}
"""The headers of every reply: it is not kept, and is what it says it is."""


@dataclass(frozen=True, slots=True)
class FileRequest:
    """What a page asks for.

    Attributes
    ----------
    sends
        Whether it sends a content (POST), or only asks (GET).
    query
        The names and values of the address's query, in order.
    chunks
        The content that it sends, in parts; it is read once.
    """

    sends: bool
    query: Sequence[tuple[str, str]]
    chunks: AsyncIterable[bytes]

    def find(self, name: str, otherwise: str = "") -> str:
        """Return the last value of this name in the query."""
        return dict(self.query).get(name, otherwise)

    async def read(self, most: int, problem: str, *, status: int = 413) -> bytes:
        """Read the content; RequestRefused with this problem if it has more bytes than `most`."""
        content = bytearray()
        async for chunk in self.chunks:
            content += chunk
            if len(content) > most:
                raise RequestRefused(status, problem)
        return bytes(content)


@dataclass(frozen=True, slots=True)
class FileReply:
    """What a page gets: a status of HTTP, the headers beside `FRESH`, and the content."""

    content: bytes
    media_type: str = "application/json"
    status: int = 200
    headers: Mapping[str, str] = field(default_factory=dict)


class RequestRefused(Exception):
    """A request that is answered with a status of HTTP, a sentence, and more about it."""

    def __init__(self, status: int, problem: str, **more: object) -> None:
        self.status, self.more = status, more
        super().__init__(problem)


def answer_json(data: object, status: int = 200) -> FileReply:
    """Answer with a value of the domain."""
    return FileReply(encode_json(data), status=status)


async def answer_safely(serve: Callable[[], Awaitable[FileReply]]) -> FileReply:
    """Return the reply of a function; its errors are answered as `{"error": sentence}`."""
    try:
        return await serve()
    except RequestRefused as error:
        return answer_json({"error": str(error), **error.more}, error.status)
    except Exception as error:
        status = 400 if isinstance(error, UnderstudyError) else 500
        return answer_json({"error": describe_error(error)}, status)
