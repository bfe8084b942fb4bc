"""The trainer: teaching a robot as a person does it, in real time, for whatever shows it and takes the keys."""
