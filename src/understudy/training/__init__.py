"""Training: sessions in which a robot is shown what to do, and the demonstrators who show it (paper section
3.2).
"""
