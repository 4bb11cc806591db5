"""Tasks of robots as formulas of finite linear temporal logic, and their automata."""
