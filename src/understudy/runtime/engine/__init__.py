"""Run many agents at once with compiled transition tables."""
