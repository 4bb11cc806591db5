"""The eight directions on a grid, in one order everywhere: E, N, W, S, NE, NW, SW, SE.

Direction k steps by (`DROW[k]`, `DCOL[k]`); rows grow to the north. Bit k of a byte of moves says
that the move in direction k is possible. Directions 0 to 3 are the four straight ones; turning
left by a quarter is +1 modulo 4 among them.
"""

from math import sqrt

DROW = (0, 1, 0, -1, 1, 1, -1, -1)
DCOL = (1, 0, -1, 0, 1, -1, -1, 1)
OPPOSITE = (2, 3, 0, 1, 6, 7, 4, 5)
NAMES = ("E", "N", "W", "S", "NE", "NW", "SW", "SE")
STAY = -1
SQRT2 = sqrt(2.0)
STRAIGHT = 0b0000_1111
ALL = 0b1111_1111
