"""Bridges to worlds, physics and data sets of other programs."""
