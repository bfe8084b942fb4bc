"""Decide what may move a robot: speed limits, guard, watchdog, emergency stop, log of stops.

What stops a robot when, and within which time, is a table in `docs/robots.md` ("What moves it, and what stops it").
"""
