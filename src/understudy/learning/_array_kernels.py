"""Examples as kernels see them: arrays, the groups of examples, and the forms of features."""

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

LINE, CIRCLE, LABELS = 0, 1, 2
DEFAULT, SHOWN, WATCHED = 0, 1, 2
NOTHING = -1
