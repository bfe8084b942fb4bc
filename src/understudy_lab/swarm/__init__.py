"""The experiment with a swarm: three levels of coordinators over robots that pull boxes together."""
