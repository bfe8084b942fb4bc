"""The swarm experiment: three levels of coordinators over robots that pull boxes together."""
