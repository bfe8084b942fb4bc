"""Import Box2D before any test."""

import tests.adapters.box2d  # noqa: F401
