"""Search for worlds in which a behavior fails: at random, then directed; failures are shrunk and kept."""
