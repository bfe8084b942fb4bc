from typing import Any, Literal

from sklearn.base import ClassifierMixin

class DecisionTreeClassifier(ClassifierMixin):
    def __init__(
        self,
        *,
        criterion: Literal["gini", "entropy", "log_loss"] = "gini",
        random_state: int | None = None,
        **params: Any,
    ) -> None: ...
    def get_depth(self) -> int: ...
    def get_n_leaves(self) -> int: ...
