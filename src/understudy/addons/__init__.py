"""What stands around the core: each package imports the core, and of the others at most `robots`."""
