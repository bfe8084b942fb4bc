"""The experiment on the size of lessons, compared with those of a RoboCup team (paper section 5.1)."""
