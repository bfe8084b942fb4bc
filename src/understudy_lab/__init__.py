"""Published experiments: one folder each, with what it runs and what it found."""
