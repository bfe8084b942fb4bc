"""User interfaces: command line, browser studio and terminal trainer."""
