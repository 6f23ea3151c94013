"""The theme of all pages: colours, style, and the display of an episode.

`style.css.j2` is the style; `episode.html.j2` has the macros that display turns, which `prepare_turns` prepares.
"""

import jinja2

from llf_teacher.theme.shades import FONTS, LENGTHS, SHADES
from llf_teacher.theme.turns import prepare_turns
from teachers.atoms import FeedbackType
from teachers.words import INSTRUCTIONS, KIND_MEANINGS, KIND_WORDS, VERDICTS, feedback_words, kind_word, type_words

__all__ = ["LENGTHS", "SHADES", "kind_mark", "pages", "prepare_turns", "properties", "sentence_style", "style"]


def pages(package: str, folder: str = "") -> jinja2.Environment:
    """The Jinja environment of a package's templates; it finds the theme's templates under `theme/`.

    Values are escaped.

    Args:
        package: the dotted name.
        folder: of the templates in the package.
    """
    ours = jinja2.PackageLoader(__name__, "")
    environment = jinja2.Environment(
        loader=jinja2.ChoiceLoader([jinja2.PackageLoader(package, folder), jinja2.PrefixLoader({"theme": ours})]),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {
        "feedback_words": feedback_words,
        "kind_word": kind_word,
        "number": _number,
        "percent": _percent,
    }
    environment.globals |= {
        "fonts": FONTS,
        "instructions": INSTRUCTIONS,
        "kind_meanings": KIND_MEANINGS,
        "kind_words": KIND_WORDS,
        "lengths": LENGTHS,
        "shades": SHADES,
        "type_words": type_words,
        "verdicts": VERDICTS,
    }
    return environment


def style() -> str:
    """The style of all pages."""
    return pages(__name__).get_template("style.css.j2").render()


def sentence_style() -> str:
    """The style of sentences with their kinds and verdicts, where the custom properties of `properties` are set."""
    return pages(__name__).get_template("sentence.css.j2").render()


def properties(dark: bool) -> dict[str, str]:
    """The custom properties of a light or a dark page, without their leading dashes: colours, sizes, spaces, fonts."""
    colours = {name: shade.dark if dark else shade.light for name, shade in SHADES.items()}
    return colours | {name: f"{length}rem" for name, length in LENGTHS.items()} | FONTS


def kind_mark(kind: FeedbackType | None) -> str:
    """The mark of a kind, as HTML."""
    macro = pages(__name__).get_template("episode.html.j2").module.kind_mark  # type: ignore[attr-defined]  # a macro of it
    return str(macro(kind, True)).strip()


def _number(value: float, digits: int = 1) -> str:
    """A number with a typographic minus sign, and no sign at zero."""
    text = f"{value:.{digits}f}"
    return text.removeprefix("-") if float(text) == 0 else text.replace("-", "\N{MINUS SIGN}")


def _percent(share: float) -> str:
    return f"{100 * share:.0f}"
