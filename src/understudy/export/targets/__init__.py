"""The targets of exports, one module each."""
