"""Where objects and robots stand when a world begins."""
