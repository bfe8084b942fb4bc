"""The ablation experiment: foraging taught repeatedly with one thing changed each time."""
