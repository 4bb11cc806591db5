"""Plane geometry on grids: sight, distances, shortest paths. Functions of arrays, no nouns."""
