"""Checks that any strategy must pass; shipped so that users can run them on theirs."""
