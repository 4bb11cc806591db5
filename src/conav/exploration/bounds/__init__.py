"""Certified bounds on the finishing time of an exploration."""
