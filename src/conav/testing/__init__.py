"""Checks that any strategy must pass; shipped so that users can run them on theirs."""

from conav.testing.strategy import check_strategy

__all__ = ["check_strategy"]
