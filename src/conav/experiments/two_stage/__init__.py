"""The reproduction of the two-stage strategy's paper [Dai2018]."""
