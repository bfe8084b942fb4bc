"""The handlers of the page's messages."""
