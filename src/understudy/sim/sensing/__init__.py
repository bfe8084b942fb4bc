"""The sensors of scenarios: their readings, and plans of the measurements that give them."""
