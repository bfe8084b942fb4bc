"""Visual servoing with and without memory, beside a robot written by hand (paper section 4.2)."""
