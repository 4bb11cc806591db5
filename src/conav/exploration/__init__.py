"""Exploration: what a mind sees, the strategies, their catalogue, metrics and the verifier."""
