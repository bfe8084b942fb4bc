"""What `understudy demo` shows: a module each."""
