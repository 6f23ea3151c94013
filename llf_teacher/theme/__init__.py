"""The theme of all pages: colours, style, and the display of an episode.

`style.css.j2` is the style; `episode.html.j2` has the macros that display turns, which `prepare_turns` prepares.
"""

import jinja2

from llf_teacher.theme.shades import SHADES
from llf_teacher.theme.turns import KIND_NAMES, MARKS, prepare_turns

__all__ = ["KIND_NAMES", "MARKS", "SHADES", "pages", "prepare_turns", "style"]


def pages(package: str, folder: str = "") -> jinja2.Environment:
    """The Jinja environment of a package's templates, which also finds those of the theme under `theme/`.

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
    environment.filters |= {"number": _number, "percent": _percent}
    environment.globals |= {"kind_names": KIND_NAMES, "marks": MARKS, "shades": SHADES}
    return environment


def style() -> str:
    """The style of all pages."""
    return pages(__name__).get_template("style.css.j2").render()


def _number(value: float, digits: int = 1) -> str:
    """A number with a typographic minus sign, and no sign at zero."""
    text = f"{value:.{digits}f}"
    return text.removeprefix("-") if float(text) == 0 else text.replace("-", "\N{MINUS SIGN}")


def _percent(share: float) -> str:
    return f"{100 * share:.0f}"
