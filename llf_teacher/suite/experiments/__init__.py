"""The experiments of the suite, one module each."""
