"""Maps: the occupancy grid, its readers and writers, and the built-in maps."""
