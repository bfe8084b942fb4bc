"""The transfer experiment: behaviors taught in the 2-D world, run in simulated physics with rendered cameras."""
