from typing import Any, Literal

from numpy.typing import ArrayLike, NDArray

class KDTree:
    def __init__(self, X: ArrayLike) -> None: ...
    def query(self, X: ArrayLike, k: int = 1, *, return_distance: Literal[False]) -> NDArray[Any]: ...
