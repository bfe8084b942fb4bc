"""Scripted teachers that press buttons as a person would, through the session's public interface only."""
