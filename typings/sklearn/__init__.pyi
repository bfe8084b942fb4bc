"""What Understudy uses of scikit-learn (untyped); add what is needed, nothing more."""
