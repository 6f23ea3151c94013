"""Reproductions of known results, for `llf reproduce`: one module per result in `rows`, found by its name."""
