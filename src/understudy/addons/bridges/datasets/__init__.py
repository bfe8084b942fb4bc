"""Episodes as data sets in the forms of other programs."""
