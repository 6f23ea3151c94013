"""Pages of the documents that are made of the code, as Markdown: one a family, and a gallery of personalities."""

from llf_teacher.tools.pages.families import family_page, write_film
from llf_teacher.tools.pages.gallery import gallery, gallery_entry

__all__ = ["family_page", "gallery", "gallery_entry", "write_film"]
