"""The 2-D simulator: many worlds of robots side by side, made from scenarios, some of which are built in."""
