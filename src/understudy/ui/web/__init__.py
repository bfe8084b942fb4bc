"""The studio: live training of a robot in the browser, from the server's side."""
