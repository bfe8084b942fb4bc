"""People who never taught a robot before, five minutes each (paper section 4.2), as a model with sources."""
