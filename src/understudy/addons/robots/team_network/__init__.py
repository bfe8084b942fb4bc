"""Members and coordinators of a team of real robots, each in a process of its own."""
