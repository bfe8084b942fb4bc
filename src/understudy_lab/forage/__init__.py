"""The foraging experiment: the four automata of the paper's section 4.1, taught by a scripted teacher."""
