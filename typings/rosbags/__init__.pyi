"""What Understudy uses of rosbags, which need not be installed where this is checked."""

from typing import Any

def __getattr__(name: str) -> Any: ...
