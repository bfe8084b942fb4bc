"""Export of taught behaviors to code and files that run without Understudy."""
