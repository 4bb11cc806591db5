"""Still and moving pictures of runs and maps, drawn from their data alone."""
