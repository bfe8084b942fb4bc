"""A repertoire of behaviors, each taught from few examples and judged beside one written by hand (paper 4.1)."""
