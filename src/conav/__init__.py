"""Multi-robot coordination in unknown 2-D environments: explore, plan, pursue."""
