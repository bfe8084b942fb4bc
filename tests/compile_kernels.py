"""Compile the kernels that most tests use, before several test processes each do it."""

from __future__ import annotations

import tests.conftest  # noqa: F401 - chooses the parts of kernels
from tests.kernel_modes import cases

FIRST = ("arena", "squads", "pulses 0", "tree 0", "inverse")


def main() -> None:
    """Compile by running one case of each kind."""
    for name, work in cases():
        if name in FIRST:
            work()


if __name__ == "__main__":
    main()
