"""Learning in the small: how little robots are taught with, beside lessons of a RoboCup team (paper section 5.1)."""
