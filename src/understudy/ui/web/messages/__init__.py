"""The messages between the page and the studio server."""
