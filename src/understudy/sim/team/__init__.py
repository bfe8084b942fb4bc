"""Teams of a scenario: their libraries, roles and squads."""
