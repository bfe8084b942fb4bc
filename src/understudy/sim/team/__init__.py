"""The teams of a scenario: their libraries, squads, and the assignment of robots to squads."""
