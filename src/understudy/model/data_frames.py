"""Data frames of Polars, pandas and pyarrow, made and read through narwhals, which is imported when it is needed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from math import isnan
from types import ModuleType
from typing import Any, TypeAlias

from understudy.errors import DefinitionError, SettingError, join_names
from understudy.extras import format_install_command, import_narwhals

BACKENDS = ("polars", "pandas", "pyarrow")
"""The packages whose frames can be made, in the order in which an installed one is chosen."""
Cell: TypeAlias = float | int | str | bool | None
"""A value in a frame; None if it is absent."""
WHAT = "data frame"


def choose_backend(backend: str | None) -> str:
    """Return the package that makes a frame: the named one, or the first of Polars, pandas and pyarrow installed."""
    if backend is None:
        package = next((each for each in BACKENDS if find_spec(each) is not None), None)
        if package is None:
            problem = "is made by Polars, pandas or pyarrow, and none of them is installed"
            remedy = f"pip install polars, and {format_install_command('frames')}"
            raise SettingError(where="frames", setting="a data frame", problem=problem, remedy=remedy)
        return package
    if backend not in BACKENDS:
        remedy = f"give {join_names(BACKENDS, word='or')}"
        raise SettingError(
            where="frames", setting=f"backend {backend!r}", problem="is unknown", remedy=remedy
        )
    if find_spec(backend) is None:
        problem, remedy = "is not installed", f"pip install {backend}"
        raise SettingError(where="frames", setting=f"backend {backend!r}", problem=problem, remedy=remedy)
    return backend


def make_frame(
    columns: Mapping[str, Sequence[Cell]], types: Mapping[str, type], *, backend: str | None = None
) -> Any:
    """Make a data frame.

    Parameters
    ----------
    columns
        The cells of each column, None where absent. Only columns of numbers and texts can have absent cells in all
        packages; whole numbers with absent cells become floats in pandas, which has no absent whole number.
    types
        The type of each column's cells: float, int, str or bool.
    backend
        The package that makes it: "polars", "pandas" or "pyarrow". None: the first of them that is installed.

    Returns
    -------
    DataFrame or Table
        A frame of that package.

    Raises
    ------
    ExtraMissing
        If narwhals is not installed.
    SettingError
        If the package is not installed, or is another one.
    """
    narwhals = import_narwhals()
    backend = choose_backend(backend)
    schema = {
        title: _choose_type(narwhals, types[title], cells, backend=backend)
        for title, cells in columns.items()
    }
    data = {title: list(cells) for title, cells in columns.items()}
    return narwhals.from_dict(data, schema=schema, backend=backend).to_native()


def _choose_type(narwhals: ModuleType, kind: type, cells: Sequence[Cell], *, backend: str) -> Any:
    if kind is int and backend == "pandas" and any(cell is None for cell in cells):
        kind = float
    return {
        float: narwhals.Float64,
        int: narwhals.Int64,
        str: narwhals.String,
        bool: narwhals.Boolean,
    }[kind]


def read_frame(frame: object) -> dict[str, list[Any]]:
    """Read the columns of a frame of any package that narwhals knows; absent cells are None.

    DefinitionError is raised if it is no such frame, or has two columns of one name.
    """
    narwhals = import_narwhals()
    try:
        eager = narwhals.from_native(frame, eager_only=True)
        columns = {str(title): eager[title].to_list() for title in eager.columns}
    except TypeError:
        problem, remedy = f"it is a {type(frame).__name__}", "give a data frame of Polars, pandas or pyarrow"
        if type(frame).__name__ == "LazyFrame":
            remedy = "call its method collect() first"
        raise DefinitionError(what=WHAT, problem=problem, remedy=remedy) from None
    except narwhals.exceptions.DuplicateError as error:
        title = str(error).partition("- ")[2].rpartition(" ")[0].rpartition(" ")[0]
        problem, remedy = f"there are two of the name {title}", "rename or remove one of the two"
        raise DefinitionError(what=f"{WHAT}, its columns", problem=problem, remedy=remedy) from None
    return {title: [None if _is_absent(cell) else cell for cell in cells] for title, cells in columns.items()}


def _is_absent(cell: object) -> bool:
    """Return whether a cell is absent, as pandas spells it: None, NaN, NaT or NA."""
    if isinstance(cell, float):
        return isnan(cell)
    return cell is None or type(cell).__name__ in ("NAType", "NaTType")
