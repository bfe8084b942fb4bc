"""Worlds of scenarios in simulated physics (MuJoCo): wheels with inertia and slip, cameras that see rendered pixels."""
