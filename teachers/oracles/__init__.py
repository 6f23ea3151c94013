"""The oracles and their claims: one module or package per family, named like the world."""
