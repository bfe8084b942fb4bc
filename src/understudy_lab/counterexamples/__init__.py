"""The experiment with failing worlds as lessons, compared with lessons at random places."""
