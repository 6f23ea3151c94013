"""The rows of docs/known-results.md, a module each, with `ROW`."""
