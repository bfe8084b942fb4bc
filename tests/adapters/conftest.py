"""Import Box2D before any test: its extension warns while it loads, and crashes where warnings are errors."""

import warnings

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import Box2D  # noqa: F401
