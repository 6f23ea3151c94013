"""One oracle a family, in a module of the world's name, together with the claims it makes."""
