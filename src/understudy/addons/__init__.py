"""Add-ons around the core: each package imports the core, and of the other add-ons at most `robots`."""
