"""The experiment that measures how much unlearning bad examples improves learning on public data sets."""
