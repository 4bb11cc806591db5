"""Built-in maps: places made by code at any size from any seed, one function and one file each.

A map is equal bit by bit on every machine: its function decides with integers, + - * / and
square roots only, and draws from the generator it is given with `integers` and `permutation`.
"""
