"""Frozen values that define what robots are taught: features, behaviors, automata, lessons (paper section 3.1).

These values can be copied and pickled, for example to send them to other processes. Python cannot pickle the
`MappingProxyType` objects they contain, so importing this package registers a way to pickle them.
"""

import copyreg
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any


def freeze_mapping(items: Mapping[Any, Any]) -> MappingProxyType[Any, Any]:
    """Copy a mapping into a read-only `MappingProxyType`.

    Unpickling calls this function, so its name and place must not change.
    """
    return MappingProxyType(dict(items))


def _reduce_mapping(
    mapping: MappingProxyType[Any, Any],
) -> tuple[Callable[..., Any], tuple[dict[Any, Any]]]:
    return freeze_mapping, (dict(mapping),)


copyreg.pickle(MappingProxyType, _reduce_mapping)
