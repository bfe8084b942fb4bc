"""Scripted demonstrators: they press as a person would, through the session's public interface alone."""
