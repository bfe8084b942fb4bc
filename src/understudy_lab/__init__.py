"""Published experiments: one folder each, with its code and its results."""
