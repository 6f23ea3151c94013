"""The rows of docs/known-results.md: one module per row, with `ROW`."""
