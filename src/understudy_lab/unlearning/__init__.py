"""What unlearning bad examples is worth, on data sets that everybody has."""
