"""Pages of the documents made from the code, as Markdown: one for each family, and a gallery of personalities."""

from llf_teacher.tools.pages.families import family_page, write_film
from llf_teacher.tools.pages.gallery import LESSONS, gallery, gallery_entry, write_lesson

__all__ = ["LESSONS", "family_page", "gallery", "gallery_entry", "write_film", "write_lesson"]
