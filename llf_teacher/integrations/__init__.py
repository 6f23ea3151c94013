"""Frameworks that train and evaluate models: a module for each, which needs the extra of the same name."""
