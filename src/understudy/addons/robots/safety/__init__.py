"""Protection against unwanted movement: speed limits, guard, watchdog, emergency stop, log of stops.

A table in `docs/robots.md` ("What moves it, and what stops it") lists what stops a robot when, and how soon.
"""
