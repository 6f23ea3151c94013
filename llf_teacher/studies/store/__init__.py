"""Where the episodes of a study are kept: one SQLite file, with its lock, merging, and migration of older files."""

from llf_teacher.studies.store.database import Store, StoreError

__all__ = ["Store", "StoreError"]
