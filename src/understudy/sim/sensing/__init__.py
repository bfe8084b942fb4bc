"""Which readings the sensors of a scenario give."""
