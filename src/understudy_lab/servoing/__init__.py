"""The experiment on visual servoing with and without states, compared with a hand-written robot (section 4.2)."""
