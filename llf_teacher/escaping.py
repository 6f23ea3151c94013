"""Escaping of what agents and models say: it controls no terminal, reorders no page and runs in no spreadsheet."""

import re

_UNSEEN = re.compile(  # control and format characters except tab and line feed, and lone surrogates
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u00ad\u061c\u180e\u200b-\u200f\u2028-\u202e\u2060-\u206f\ufeff\ufff9-\ufffb"
    "\ud800-\udfff\U000e0001-\U000e007f]"
)
_WIDE = "\uff1d", "\uff0b", "\uff0d", "\uff20"  # the full-width signs that some spreadsheets take for = + - @
_RUN = ("=", "+", "-", "@", *_WIDE, "\t", "\r", "\n", "'")  # beginnings of what a spreadsheet runs, and our own mark


def escape_control_chars(text: str) -> str:
    r"""The text with invisible characters as codes, such as `\u202e`."""
    return _UNSEEN.sub(lambda match: match[0].encode("unicode_escape").decode(), text)


def cell_of(value: object) -> object:
    """A value as a cell of CSV: a text that a spreadsheet could run has an apostrophe in front; see `text_of_cell`."""
    return f"'{value}" if isinstance(value, str) and value.startswith(_RUN) else value


def text_of_cell(cell: str) -> str:
    """The text of a cell that `cell_of` wrote."""
    return cell.removeprefix("'")
