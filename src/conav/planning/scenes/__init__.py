"""Scenes that are made on the spot: one kind a file."""
