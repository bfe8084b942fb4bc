"""Numba kernels of the 2-D simulator: arrays and numbers in and out."""
