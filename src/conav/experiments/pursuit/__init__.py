"""Studies of clearing floors: what messages, pursuit graphs and orders cost."""
