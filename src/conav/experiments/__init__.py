"""Studies: sweeps, comparisons and reproductions of published results."""
