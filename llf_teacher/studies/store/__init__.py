"""The store of a study's episodes: one SQLite file, its lock, and merging."""

from llf_teacher.studies.store.database import Store, StoreError

__all__ = ["Store", "StoreError"]
