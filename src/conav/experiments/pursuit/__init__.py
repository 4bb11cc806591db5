"""Studies of pursuit."""
