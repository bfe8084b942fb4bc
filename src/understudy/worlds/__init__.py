"""Worlds: simulated bodies, many worlds side by side as rows. The catalog lists those that ship."""
