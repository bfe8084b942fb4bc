"""The terminal trainer: a person teaches a robot with the keyboard, over SSH too (paper section 3.2)."""
