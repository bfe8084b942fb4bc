from typing import Any

from numpy.typing import NDArray
from sklearn.base import ClassifierMixin

class MLPClassifier(ClassifierMixin):
    coefs_: list[NDArray[Any]]
    intercepts_: list[NDArray[Any]]

    def __init__(self, hidden_layer_sizes: tuple[int, ...] = (100,), **params: Any) -> None: ...
