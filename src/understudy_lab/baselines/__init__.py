"""Other learners on the same demonstrations: what a few decisions, or a few seconds, are worth to each."""
