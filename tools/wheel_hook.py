"""Hatchling's hook for wheels: make one for this platform that carries compiled kernels, if a folder of them is named.

UNDERSTUDY_SHIPPED_KERNELS names the folder, which `tools/compile_shipped.py` fills.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

SETTING = "UNDERSTUDY_SHIPPED_KERNELS"


class ShippedKernelsHook(BuildHookInterface):  # type: ignore[type-arg]
    """Adds the compiled kernels to the wheel, and names its platform."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Change what the wheel is built of."""
        folder = os.environ.get(SETTING)
        if folder:
            build_data["pure_python"] = False
            build_data["infer_tag"] = True
            build_data["force_include"][str(Path(folder).resolve())] = "understudy/compiled"
