"""Real robots as bodies, with the reading and channel names and units that libraries are taught with."""
