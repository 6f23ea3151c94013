"""Known results of the field, reproduced: a module a result in `rows`, found by its name, for `llf reproduce`."""
