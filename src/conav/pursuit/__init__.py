"""Clearing a floor so that nobody hidden on it can slip away."""
