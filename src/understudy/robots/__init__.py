"""Real robots as bodies: what they sense and obey in the names and units that libraries are taught with."""
