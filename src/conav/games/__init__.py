"""Games in normal form: definitions, checks, and exact answers for small games."""
