"""What matters: foraging taught again and again with one thing different each time."""
