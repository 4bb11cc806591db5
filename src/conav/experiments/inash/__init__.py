"""The reproduction of iNash-trajectory's paper [Zhu2014]."""
