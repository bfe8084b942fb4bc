"""User interfaces: command line, browser studio, terminal trainer and notebooks."""
