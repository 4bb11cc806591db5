"""Floor plans made by code: families from the literature on search and pursuit, and random ones.

All corners are exact in binary, and the same arguments give the same corners on every machine.
"""
