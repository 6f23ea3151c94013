"""Episodes: playing them, and the record from which stores and exports are written."""
