"""Output of commands with `--json`: one JSON object."""

from __future__ import annotations

import sys
from typing import Any

from understudy.storage.json_text import format_json


def print_json(result: Any) -> None:
    """Print one result as a JSON object on stdout; absent values are null.

    `result` is plain data or an instance whose fields are printed in order. Raises TypeError unless it encodes to an
    object: objects can gain keys later without breaking programs that read them.
    """
    text = format_json(result)
    if not text.startswith(b"{"):
        raise TypeError(f"a command prints one object, and this is a {type(result).__name__}")
    if sys.stdout is not None:  # it is none where a program was started without
        sys.stdout.flush()
        sys.stdout.buffer.write(text)  # UTF-8, whatever letters the terminal has
        sys.stdout.buffer.flush()
