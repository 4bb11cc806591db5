"""What robots say to each other, and how many bytes that takes."""
