"""Foraging, taught: the four automata of the paper's section 4.1, by a scripted teacher, judged on unseen worlds."""
