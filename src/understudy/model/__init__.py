"""The model: frozen values, and the documents that hold them (paper section 3.1).

Values can be copied and sent to other processes whole. Python pickles no frozen mappings, which they hold, so that it
is told here how.
"""

import copyreg
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any


def freeze_mapping(items: Mapping[Any, Any]) -> MappingProxyType[Any, Any]:
    """Make a frozen mapping of another: what unpickles one."""
    return MappingProxyType(dict(items))


def _reduce_mapping(
    mapping: MappingProxyType[Any, Any],
) -> tuple[Callable[..., Any], tuple[dict[Any, Any]]]:
    return freeze_mapping, (dict(mapping),)


copyreg.pickle(MappingProxyType, _reduce_mapping)
