"""Escaping of control characters, so that text of agents and models cannot control a terminal or reorder a page."""

import re

_UNSEEN = re.compile(  # control and format characters except tab and line feed, and lone surrogates
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u00ad\u061c\u180e\u200b-\u200f\u2028-\u202e\u2060-\u206f\ufeff\ufff9-\ufffb"
    "\ud800-\udfff\U000e0001-\U000e007f]"
)


def escape_control_chars(text: str) -> str:
    r"""The text with invisible characters as codes, such as `\u202e`."""
    return _UNSEEN.sub(lambda match: match[0].encode("unicode_escape").decode(), text)
