"""The experiment with a suite of behaviors, each taught from few examples and compared with a hand-written one."""
