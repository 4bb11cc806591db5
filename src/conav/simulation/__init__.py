"""The simulator: state, one engine, the radio network, traffic, and the loop of an exploration."""
