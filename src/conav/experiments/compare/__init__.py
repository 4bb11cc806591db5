"""`conav compare`: strategies side by side, over maps, teams, ranges, radios and seeds."""
