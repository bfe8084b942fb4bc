"""Other packages' environments as bodies, and scenarios as other packages' environments."""
