"""Properties of behaviors: what must never happen, or must happen in time, in the worlds of a scenario."""
