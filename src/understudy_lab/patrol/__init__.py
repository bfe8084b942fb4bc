"""The patrol experiment of the paper (section 5.1): four robots, an intruder, a boss, a home base."""
