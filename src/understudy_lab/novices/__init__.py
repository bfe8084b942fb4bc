"""The experiment with a model of people who teach a robot for the first time, for five minutes (section 4.2)."""
