"""Scripted teachers: press as a person would, through the session's public interface alone."""
