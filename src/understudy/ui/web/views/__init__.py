"""The data that the page displays."""
