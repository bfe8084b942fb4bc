"""Training: sessions in which a person or a program demonstrates, and the lessons that result (paper section 3.2)."""
