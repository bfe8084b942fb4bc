"""What the studio does with each message of the page."""
