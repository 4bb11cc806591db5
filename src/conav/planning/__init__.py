"""Motion planning for robots with tasks of their own."""
