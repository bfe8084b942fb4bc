"""Import Box2D before any test: its extension warns while it loads, and crashes where warnings are errors."""

import warnings
from importlib import import_module

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import_module("Box2D")
