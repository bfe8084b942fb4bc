"""What may move a robot: speed limits, guard, watchdog, emergency stop."""
