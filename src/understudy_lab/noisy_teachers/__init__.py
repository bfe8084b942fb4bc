"""Teachers who slip and press late, corrected with unlearning and without."""
