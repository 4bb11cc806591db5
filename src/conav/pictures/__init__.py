"""Still and moving pictures of maps and runs. Nothing here is needed to make a run."""
