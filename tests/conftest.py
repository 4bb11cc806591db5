"""What all tests share."""

from hypothesis import settings

# Kernels are compiled in their first call, and machines are busy: no example has a deadline.
settings.register_profile("conav", deadline=None)
settings.load_profile("conav")
