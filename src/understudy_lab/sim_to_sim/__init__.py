"""What was taught in the 2-D world, run in simulated physics by what rendered cameras see."""
