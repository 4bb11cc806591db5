"""The reproduction of [Philip2014], claim by claim."""
