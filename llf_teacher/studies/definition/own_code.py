"""Users' own code in words: how it differs from what a store's last run recorded, and what cannot be compared."""

from collections.abc import Iterable, Mapping

from llf_teacher.studies.definition.fingerprints import MAIN, differing, fingerprints
from teachers.words import listed


def since(code: Mapping[str, Mapping[str, str]]) -> list[str]:
    """How users' own code differs here from that of a store's last run, in words.

    Code that is not found here, and what a notebook or a script defined itself, is left out.

    Args:
        code: the entry `code` of the store's manifest.
    """
    now = fingerprints(name for name, before in code.items() if not any(map(_is_main, before)))
    found = {name: words for name, each in now.items() if (words := differing(each.modules, code[name]))}
    return [
        f"{listed(names, 'and')} {'has' if len(names) == 1 else 'have'} changed since this study was last run "
        f"({words}); its results are those of the code before."
        for words, names in alike(found).items()
    ]


def alike(found: Mapping[str, str]) -> dict[str, list[str]]:
    """The keys of each value."""
    names: dict[str, list[str]] = {}
    for name, words in found.items():
        names.setdefault(words, []).append(name)
    return names


def _is_main(module: str) -> bool:
    return module.partition(":")[0] == MAIN


def unseen(names: Iterable[str]) -> list[str]:
    """What is not compared of users' own code, in words."""
    found = {name: ", ".join(each.unseen) for name, each in fingerprints(names).items() if each.unseen}
    return [
        f"Of {listed(specs, 'and')}, a run does not compare {words}: if that has changed, give another --store."
        for words, specs in alike(found).items()
    ]
