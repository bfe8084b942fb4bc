"""The studio: training a robot in the browser, live - the server behind the page."""
