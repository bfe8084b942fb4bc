"""Kernels: how they are declared, run as plain Python, compiled, kept in files, and switched while they run."""
