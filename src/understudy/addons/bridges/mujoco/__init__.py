"""Worlds of scenarios in simulated physics (MuJoCo): wheels with inertia and slip, and cameras with rendered images."""
