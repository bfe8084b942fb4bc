"""Segmentation of recordings: which behavior explains each tick of a drive, and a lesson made of the answer."""
