"""Episodes: how they are played, and the record that all that leaves goes through."""
