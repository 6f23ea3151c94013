"""The qualities of the mirror, one module each."""
