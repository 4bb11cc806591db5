"""What a robot is: its body, motion, sensor and radio. Descriptions only."""
