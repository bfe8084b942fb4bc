from typing import Any, Literal

from numpy.typing import NDArray
from sklearn.base import ClassifierMixin

class Tree:
    value: NDArray[Any]

    def apply(self, X: NDArray[Any]) -> NDArray[Any]: ...

class DecisionTreeClassifier(ClassifierMixin):
    tree_: Tree

    def __init__(
        self,
        *,
        criterion: Literal["gini", "entropy", "log_loss"] = "gini",
        random_state: int | None = None,
        **params: Any,
    ) -> None: ...
    def get_depth(self) -> int: ...
    def get_n_leaves(self) -> int: ...
