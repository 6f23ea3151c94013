"""Reads a sentence as an action: a word of the world or a value, among words that only choose it."""

import json
import re
from collections.abc import Iterable, Iterator
from functools import cache
from itertools import islice
from typing import Any

from gymnasium import spaces

from pz_envs.text.answer_place import NOUNS, PLAIN, brackets, masked, sentences, words
from pz_envs.text.json_values import finite_value, lenient_value
from worlds.world import World

__all__ = [
    "LONGEST",
    "TwoActions",
    "exact_action",
    "in_brackets",
    "in_json",
    "is_stated",
    "names_any",
    "on_first_line",
    "only_named",
    "read_sentence",
    "taken_back",
    "text_in",
    "the_one",
    "unfit",
    "warns",
]

LONGEST = 1000
"""Greatest length of an answer in a world whose actions are not texts."""
_TOOL = ("arguments", "parameters", "args", "function", "function_call", "tool_call", "tool_calls")
_AROUND = " \t\r\n*_`\"'\u201c\u201d\u2018\u2019\u00ab\u00bb"
_ENDS = f"{_AROUND}.,;:!"
_BRACKETS = {"[": "]", "(": ")", "{": "}", "<": ">"}
_BULLET = re.compile(r"(?:[>#*\u2022-]+|[-=]>|\u2192)[ \t]+|[0-9]{1,2}[.)][ \t]+(?=[A-Za-z*`\"])")
_DUTY = re.compile(  # "you go north" may tell a story, and "I have 3" count
    r"\b(?:you (?=(?:should|must|need to)\b)|(?:have |need |decided )+(?=to\b))", re.IGNORECASE
)
_PURPOSE = re.compile(r"to (?!the\b)\w+ [^,]*,", re.IGNORECASE)  # as in `to move south, you go east`
_WHEN = re.compile(r"\bfor (?:my|your|the|this) (?:next )?(?:turn|time|step|round)\b,?", re.IGNORECASE)
_BEHIND = words(
    """the my now next then first please again here from instead answer choice this is it turn time final best better
    too good right correct direction way action move"""
)
"""Words behind an action that leave it as it is."""
_WORD = re.compile(r"[^\s,;:(]+")
_NEXT = re.compile(r"[\s*_`]*([A-Za-z]+)")
_OWN_CLAUSE = re.compile(r",\s+(?:\w+\s+)?(?=(?:i|we|let)\b)", re.IGNORECASE)
_CONDITION = re.compile(
    r"\W*(?:if|when|unless|had|were|whether|until|before|once|provided|in case|as soon as|suppose)\b", re.IGNORECASE
)
_CAUSE = re.compile(
    r"\W{0,3}(?:because|since|as|for|so|which|that|where|in order|to(?! [\[(0-9]|.*\bwas\b))\b", re.IGNORECASE
)
_BUT_NOT = re.compile(r"\W{0,3}(?:(?:and |but )?not\b(?!\W*$)|instead of\b|rather than\b)", re.IGNORECASE)
_DENIAL = re.compile(
    r"\b(?:not|never|no|cannot|avoid|except|than|instead|but|without|refuse|skip|doubt|suppose|last|was|blamed)\b"
    r"|n['\u2019]t\b",
    re.IGNORECASE,
)
_BACK = re.compile(
    r"""
    (?:^|[.!?;(\n\u2013\u2014-]) \s{0,3} (?:hmm[,.]?\ )?
    (?:no(?=[,.!;)]|\ wait|$)|nope|wait|hold\ on|actually|correction|oops|scratch\ that|never\ ?mind
      |on\ (?:second\ thought|reflection)|or(?!\ so\b)|i\ meant?|sorry|cancel|disregard|edit(?=:)
      |(?:just\ )?(?:kidding|joking)
      |alternatively|changed\ my\ mind|forget\ (?:that|it)|let\ me\ reconsider|i\ withdraw
      |false|not(?=\s*[.!])|then\ again|however|i\ refuse|this\ is\ a\ lie
      |i\ will\ not\ (?:take|do|follow)\ (?:it|that|this)) \b
    | ,\ ? (?:no(?=[,;)])|wait\b)
    | \b(?:that|this|it)(?:\ is|['\u2019]s|\ was|\ seems|\ looks)
      \ (?:wrong|incorrect|a\ mistake|not\ (?:right|correct|my)\b)
    """,
    re.IGNORECASE | re.VERBOSE,
)
_OTHERWISE = re.compile(r"\W*(?:but|or(?! so)|if|unless|when|do not|don't)\b", re.IGNORECASE)
_REMARK = re.compile(r"\s*(?:[,;:(\u2013\u2014]|[-=] )")
_CHANGED = words(
    """cm mm km inch inches feet degrees radians percent centimetres centimeters reverse reversed opposite swapped
    inverted negated flipped wrong incorrect rejected forbidden not"""
)
"""Words of a short remark that make an action another."""
_VERBS = r"""(?:go|head|move|walk|proceed|continue|take|choose|pick|select|pull|play|propose|recommend|try|use
    |follow|enter|make|give|send|say|apply|test|look(?=\ at\b)|turn(?=\ to\b)|watch(?=\ _))"""
_NOUNS = "(?:way|move|choice|answer|action|option|direction|decision|response|arm|number|step|point|command|thing|one)"
_FILLED = r"""(?:\W{0,3}\b(?:to|the|in|on|through|via|towards?|with|for|at|an?|of|way|door|arm|number|choice|action
    |command|label(?:ed|led)|move|point)\b)*\W{1,3}"""
_TO_DO = re.compile(
    rf"""(?:\A\W*|[,:;]\W*|\b(?:i|you|we|so|and|now|then|next|please|let's|let\ (?:me|us)|i'll|i'd|we'll
        |(?:you|need|have|going|want|like|best|better|is|and|decided?|plan|intend|time)\ to|will|should|must
        |understood)\W+)
        (?:now\W+|next\W+)? {_VERBS} {_FILLED} _
    | (?:\A\W*|[,:;!]\W*|\b(?:i'm|am|are|is)\ |\A(?:start|begin|continue)\ by\ )(?:now\ )?
        (?:go|head|mov|walk|tak|choos|pull|propos|apply|us)ing {_FILLED} _
        (?:\ (?:now|next))? \W* (?:\Z|[,(]|\(|to\b)
    | \b{_NOUNS}\b (?:\ (?:now|here|next|to\ \w+|for\ (?:me|you|your\ next\ turn)
        |(?:that\ )?(?:i|you|we)\ should\ {_VERBS}(?:\ for)?
        |from\ (?:here|this\ \w+)))* \ (?:is|(?:will|should|must)\ be)\b:? (?:\ to\ {_VERBS})? (?:\ (?:now|indeed))?
        {_FILLED} _
    | \bso\ that\ (?:i|you|we)\ (?:arrive|end)\ at\ _
    | _\W{{0,3}}\ is\ (?:what|where|the|my|your)\ (?:(?:right|correct|best|next|only|final)\ )* (?:you|i|{_NOUNS})\b""",
    re.IGNORECASE | re.VERBOSE,
)
"""Words that say that the action behind or before them is to be done."""
_NOT_TO_DO = re.compile(
    r"""\b(?:not|never|no|none|nothing|nobody|nowhere|cannot|neither|nor|without|except|than|instead|but|only|against|away
      |avoid\w*|leav(?:e|ing)\ (?:the\ |arm\ )?_
      |drop|exclude|reject|abandon|stop|refuse|decline|ignore|skip|disagree|hardly|doubt
      |lie|false|untrue|joking|kidding|opposite|reverse
      |or|either|if|unless|whether|when|while|until|after(?:wards)?|before|although|though|however
      |maybe|perhaps|might|could|may|once|later|soon|someday|eventually|tomorrow|sometimes|often|given|provided
      |suppose|imagine|assume|in\ case
      |last|previous|earlier|was|were|had|has|have\ (?!to\b)|did|been|went|came|took|said|told|led|made|got|gave|paid
      |saw|knew|thought|chose|meant|felt|kept|lost|hit|cost|hurt|put\ me
      |double|twice|negative|sum|one\ day|in\ \w+\ turns|episode|friend|player|heard|unclear|unsure|way\ back
      |how|why|such\ as|example|valid|typical|format|they|he|she|someone|another|others?
      |there(?!\W*\Z)|leads?|lies|seems?|looks|look\ (?:like|as)|wrong|bad|worse|worst
      |mistake|incorrect|pointless|useless|waste|average
      |times|less|more|least|most|half|between|too|any\w*|every\w*|each|both|all
      |(?:from|by|turn|worth|next\ to|of\ arms?\ to\ \w+\ is)(?:\ the)?\ _|turn\ [0-9]+|[cmk]?m)\b
    |(?:^\W*|\b(?:i|you|we|it|teacher|that|which|who|already|just)\ )(?!need|proceed|based)[a-z]{2,}ed\b
    |_\ of\b|\bteacher(?:\ \w+)?:|n['\u2019]t\b|\?|\.\.\.|[%=<>+*/\u2208]|\s-\s""",
    re.IGNORECASE | re.VERBOSE,
)
"""Words that deny, doubt, ask, compare, or tell of the past, of later times or of others."""
_AT_LAST = re.compile(rf"\b(?:should|must|will|{_NOUNS}\ is)\ [^_:]{{0,80}}:\W*_\W*\Z", re.IGNORECASE)
"""As in `you should push forwards: [1, 0]`."""
_STATED = re.compile(
    r"""\W*(?:(?:so|then),?\ )? (?:the|my|your)\ (?:(?:right|correct|best|next|final)\ )*
    (?:action|answer|choice|move|command|decision|response|arm|point)\ (?:for\ (?:my|your|this|the)\ (?:next\ )?turn\ )?
    (?:(?:that\ )?(?:i|you|we)\ should\ (?:take|choose|make|give)\ )? (?:is|(?:should|will|must)\ be)\b""",
    re.IGNORECASE | re.VERBOSE,
)
_ASKED = re.compile(r"\W*(?:(?:should|shall|do|does|is|are|can|could|would|may|must) (?:i|we|it|the)\b)", re.IGNORECASE)
_PLACED = re.compile(r"\W*the (?:hand|gripper|object|goal|target|car|spot) is at\b", re.IGNORECASE)
_SOUGHT = re.compile(r"\s+for\b", re.IGNORECASE)
_REASON = re.compile(r"\W{0,3}(?:because|since|as (?:it|this|that|i|you))\b", re.IGNORECASE)
_DIGIT = re.compile(r"\b[0-9]")
_TITLE = re.compile(r"[\"\u201c]([^\"\u201c\u201d]{1,60})[\"\u201d]")
_PICKED = re.compile(
    r"""\b(?:(?:watch|recommend|suggest|try|choose|pick|take)(?:ing)?\s(?:\w+\s)?
        |(?:answer|choice)\ is(?:\ indeed)?:?\s)\Z""",
    re.IGNORECASE | re.VERBOSE,
)
_BEFORE_NUMBER = words("number option is be")
_SYMBOLS = re.compile(r"[()\[\]'\"?\\{}|/%!$+*^]+")
_NUMBER = r"[-+]?(?:[0-9]{1,40}(?:\.[0-9]{0,40})?|\.[0-9]{1,40})(?:[eE][-+]?[0-9]{1,5})?"
_PART = re.compile(
    rf"(?<![\w.+-])(?:[\"']?([A-Za-z]\w{{0,20}})[\"']?[ \t]*[:=][ \t]*)?[\"']?({_NUMBER})[\"']?(?![\w.%])"
)
_QUANTITY = re.compile(rf"\b(?:(?:from|to|by|is|of|instead)\s+)+{_NUMBER}(?![\w%]|\.\d)")
"""A number that is no action where actions are lists of numbers, as in `from 3.5 to 1`."""
_AFTER = re.compile(r"(?<=_)(?:\W*[,;]|\W+(?:and|next|now)\b)")
"""Where what is said of a list of numbers ends."""
_ITEM = r"^[ \t]*(?:[-*\u2022]|[0-9][.)])[ \t]+"
_ITEMS = re.compile(
    rf"(\A|:[*`]*)\s*"
    rf"((?:{_ITEM}[*`\"]*[A-Za-z]\w{{0,20}}[*`\"]*[ \t]*[:=][*`]*[ \t]*{_NUMBER}[*`,;.]*[ \t]*$\n?){{2,8}})",
    re.MULTILINE,
)
"""Numbers with names, one a line, at the beginning or behind a colon."""
_BETWEEN = re.compile(r"(?:[\s,;&]|\band\s+(?=\S))+")
_SIGN = re.compile(r"-\s+[\"']?\.?[0-9]")
_WORDS = 12  # greatest number of words before an action, and in it
_SCANNED = 60  # words of a refused text
_SHORT = 200  # characters of a sentence that is read by what it names alone, and of a remark that is read again
_PARTS = 8  # parts of a remark that may name an action
_NESTED = 40  # greatest depth of lists and objects within each other
_DEPTH = 8  # greatest depth of texts within texts


class TwoActions(Exception):  # noqa: N818 (it is no error of the program)
    """An answer names different actions; the message lists them."""


def the_one(actions: Iterable[Any]) -> Any:
    """The action that all readings but None agree on; None: there is none.

    Raises:
        TwoActions: the readings differ.
    """
    found = [action for action in actions if action is not None]
    for other in found[1:]:
        if other != found[0]:
            raise TwoActions(f"it names different actions, {found[0]!s:.40} and {other!s:.40}")
    return found[0] if found else None


# Places in a text.


def on_first_line(text: str, world: World[Any], depth: int = 0) -> tuple[Any, str]:
    """The action that a text begins with, and the rest of the text; None: it begins with none.

    The action is the first paragraph, JSON, or the first sentence that is one on the first line. A line that announces
    with a colon goes on.
    """
    paragraph, _, rest = text.strip().partition("\n\n")
    if (action := exact_action(paragraph, world, depth)) is not None:
        return action, rest
    if (found := in_json(text, world, depth))[0] is not None or text.lstrip().startswith("{"):
        return found
    for sentence, until in sentences(text):
        if (action := read_sentence(sentence, world, depth)) is not None:
            return action, text[until:]
        if "\n" in text[until : until + 2] and not sentence.endswith(":"):
            break
    return None, ""


def in_json(text: str, world: World[Any], depth: int = 0) -> tuple[Any, str]:
    """The action of the JSON objects in a text, of lists where actions are texts, and the rest; None: they have none.

    Raises:
        TwoActions: they have different ones.
    """
    kinds = dict | list if isinstance(world.action_space, spaces.Text) else dict
    found, rest, line, at = [], "", "", 0
    for begin, end in brackets(text):
        value = lenient_value(text[begin:end]) if text[begin] in "[{" else None
        if isinstance(value, kinds) and not _denies(text[at:begin]):
            found.append(from_json(value, world, depth))
            rest = text[end:]
            line = rest.partition("\n")[0] if isinstance(value, list) else ""
        at = end
    action = the_one(found)
    return (action if action is None or _fits(line, action, world) else None), rest


def _denies(text: str) -> bool:
    """Whether the words before an action deny it; of an announcement that ends with a colon, its first four do."""
    clause = re.split(r"[.!?;\n]", masked(text))[-1].rstrip("*_`$\\( ")
    return bool(_ASKED.match(clause)) or bool(
        _DENIAL.search(" ".join(clause.split()[:4]) if clause.endswith(":") else clause)
    )


def taken_back(text: str) -> bool:
    """Whether the text behind an action takes it back."""
    return bool(_BACK.search(text))


def names_any(text: str, world: World[Any]) -> bool:
    """Whether some words of a text, in a row, are an action; the first `_SCANNED` words are read."""
    return any(True for form in (text, _SYMBOLS.sub(" ", text)) for _ in _named(form, world))


# Sentences.


def is_stated(sentence: str) -> bool:
    """Whether a sentence says which action, answer, choice or the like there is."""
    return bool(_STATED.match(sentence))


def read_sentence(text: str, world: World[Any], depth: int = 0) -> Any:
    """The action that a sentence or its clause of an own choice, as in `..., so I go north`, names; None: none.

    Raises:
        TwoActions: a remark behind the action names another one.
    """
    text = _DUTY.sub("I ", _WHEN.sub("", _bare(text)))
    if _ASKED.match(text) or _PLACED.match(text):
        return None
    clauses = () if _CONDITION.match(text) else islice(_OWN_CLAUSE.finditer(text), _PARTS)
    begins = [clause.end() for clause in clauses]
    if not _PURPOSE.match(text):
        begins.insert(0, 0)
    return next((found for begin in begins if (found := _chosen(text[begin:], world, depth)) is not None), None)


def _chosen(text: str, world: World[Any], depth: int = _DEPTH) -> Any:
    """The action of a clause in which plain words stand before it, and a remark may stand behind it."""
    found = list(islice(_WORD.finditer(masked(text)), 3 * _WORDS))
    for at, word in enumerate(found[:_WORDS]):
        for last in reversed(found[at : at + _WORDS]):
            if (action := exact_action(text[word.start() : last.end()], world, depth)) is not None:
                if (
                    text[word.start() : last.end()].isalpha()
                    and _SOUGHT.match(text, last.end())
                    and not world.action_words
                ):
                    return None  # as in `look for a mug`
                return action if _fits(text[last.end() :], action, world) else None
        said = text[word.start() : word.end()].strip(f"{_AROUND}.").replace("\u2019", "'").lower()
        if said == "first" and text[word.end() :].lstrip()[:1].isdigit():  # as in `the first 4`, a count
            return None
        if said and said not in _own(PLAIN, world):
            return None
    return None


def only_named(text: str, world: World[Any]) -> Any:
    """The only action that a short sentence names, if it is to be done and no word says otherwise; None: there is none.

    A number is an action behind a word of the world or a name of an answer; a word is one in quotes, if actions are
    texts. A list of numbers is to be done also in any sentence that begins with "your action is" or the like.
    """
    text = text[bullet.end() :] if (bullet := _BULLET.match(text)) else text
    found = [] if len(text) > _SHORT or "\n" in text or _ASKED.match(text) else [*_named(text, world)]
    if not found or any(action != found[0][0] for action, _, _ in found):
        return None
    action, begin, end = found[0]
    said, last = text[begin:end].strip(_ENDS).lower(), found[-1][2]
    before, picked = text[:begin].lower().split()[-1:], world.text_items and _PICKED.search(text[:begin])
    quoted = text[begin] in _AROUND
    if (said.isalpha() and not world.action_words and not quoted) or (
        said.isdigit() and not _BEFORE_NUMBER.union(NOUNS, world.action_fillers, world.answer_names).issuperset(before)
    ):
        return None
    rest = text[:last] if _REASON.match(text, last) else text
    for _, begin, end in reversed(found):
        rest = f"{rest[:begin]}_{rest[end:]}"
    for name in world.answer_names:
        rest = re.sub(rf"(?i)\b{name}\b", "action", rest)
    numbers = isinstance(world.action_space, spaces.Box)
    stated = numbers and is_stated(text)
    if numbers:
        rest = _QUANTITY.sub("", rest)
    if stated:
        rest = _AFTER.split(rest, maxsplit=1)[0]
    if _NOT_TO_DO.search(rest) or (not world.action_words and not quoted and _DIGIT.search(rest)):
        return None
    chosen = stated or picked or _TO_DO.search(rest) or (not world.action_words and _AT_LAST.search(rest))
    return action if chosen else None


def warns(sentence: str, chosen: Iterable[Any], world: World[Any]) -> bool:
    """Whether a sentence names actions, none of them to be done, and none that is chosen elsewhere."""
    named = [action for action, _, _ in _named(sentence, world)]
    return bool(named) and only_named(sentence, world) is None and not any(action in named for action in chosen)


def _named(text: str, world: World[Any]) -> Iterator[tuple[Any, int, int]]:
    """Each action that words in a row are, the most words first, with its beginning and end."""
    found = [*islice(_WORD.finditer(masked(text)), _SCANNED)]
    at = 0
    while at < len(found):
        for last in reversed(range(at, min(at + _WORDS // 2, len(found)))):
            begin, end = found[at].start(), found[last].end()
            action = exact_action(text[begin:end], world)
            if action is None and world.text_items and not world.verbatim and _PICKED.search(text[:begin]):
                title = _TITLE.fullmatch(text[begin:end].strip(".,;!"))
                action = _word(json.dumps([title[1]]), world) if title else None  # one of a list
            if action is not None:
                yield action, begin, end
                at = last
                break
        at += 1


def _own(plain: frozenset[str], world: World[Any]) -> frozenset[str]:
    """Plain words and those of a world, without those of its actions."""
    return plain.union(world.action_fillers, world.answer_names).difference(*map(str.split, world.action_words))


def _fits(remark: str, action: Any, world: World[Any]) -> bool:
    """Whether the words behind an action leave it as it is: plain words, then a cause, "not ..." or a free remark.

    Raises:
        TwoActions: they name another action.
    """
    if _BUT_NOT.match(remark):
        return True
    while (word := _NEXT.match(remark)) and word[1].lower() in _own(_BEHIND, world):
        remark = remark[word.end() :]
    if cause := _CAUSE.match(remark):  # to worlds with words, as in `north to south`, it may be a way
        why = remark[cause.end() :][:_SHORT]
        return not world.action_words or _chosen(why, world) in (None, action)
    bare = remark.strip(f"{_ENDS}()=\u2013\u2014-")
    if not bare or (remark[0] in ",(" and _BUT_NOT.match(remark)):
        return True
    said = re.findall(r"[a-z0-9_]+|%", remark.lower())
    if not _REMARK.match(remark) or _BACK.search(remark) or _OTHERWISE.match(remark) or said == ["%"]:
        return False
    if len(said) <= 4 and _CHANGED.intersection(said):
        return False
    listed = tuple(word.replace("_", "") for word in said if word.replace("_", "") in world.action_parts)
    if listed != world.action_parts and sorted(listed) == sorted(world.action_parts):
        return False
    again = _chosen(bare[:_SHORT], world)  # which comes back here for each listed action
    parts = re.split(r"[,;()]|\b(?:and|or|then)\b", remark)[:_PARTS]
    parts = parts if len(parts) > 1 else []  # or a text would be read twice at each of its actions
    the_one([action, again, *(_chosen(part, world) for part in parts)])
    computed = remark.lstrip()[0] in "-=" and not bare.startswith(("a ", "an ", "the "))  # as in `x - gradient`
    return again is not None or not computed


def in_brackets(text: str, world: World[Any]) -> str:
    """The text with a list of an action's parts, a line for each, in brackets on the line that announces it.

    So `I propose:`, `- x1: 1` and `- x2: 2` are `I propose: [1, 2]`.
    """

    def bracketed(found: re.Match[str]) -> str:
        parts = [(name.lower(), digits) for name, digits in _PART.findall(re.sub(f"(?m){_ITEM}|[*`]", "", found[2]))]
        if sorted(name for name, _ in parts) != sorted(world.action_parts):
            return found[0]
        return f"{found[1]} [{', '.join(dict(parts)[name] for name in world.action_parts)}]\n"

    return _ITEMS.sub(bracketed, text) if world.action_parts else text


# Actions without other words.


def _bare(text: str) -> str:
    """A text without a bullet, and marks around it."""
    text = text.strip(_AROUND)
    text = text.strip("$") if text[:1] == text[-1:] == "$" else text
    bullet = _BULLET.match(text)
    return (text[bullet.end() :] if bullet else text).strip(_AROUND).rstrip(".,;!").strip(_AROUND)


def exact_action(text: str, world: World[Any], depth: int = 0) -> Any:
    """The action of a text that is one and nothing else, but for marks around it; None: it is no action."""
    longest = max(LONGEST, getattr(world.action_space, "max_length", 0))
    form = text
    listed = text.lstrip()[:1] == "-" or not isinstance(world.action_space, spaces.Box)  # else a dash is a sign
    for _ in range(4 if len(text) <= 2 * longest else 0):
        if 0 < len(form) <= longest:
            for read in (_word, _numbers):
                if (action := read(form, world)) is not None:
                    return action
            value = lenient_value(form) if form[:1] in ("{", "[", "(", '"') else None
            if (action := from_json(value, world, depth)) is not None:
                return action
        if not listed and _SIGN.match(form.strip(_AROUND)):
            break
        inner = _bare(form)
        if inner == form and _BRACKETS.get(form[:1]) == form[-1:]:
            inner = form[1:-1].strip()
        if inner == form:
            break
        form = inner
    return None


def _legal(action: Any, world: World[Any]) -> Any:
    try:
        return world.legal(action)
    except (ValueError, TypeError, OverflowError, RecursionError):
        return None


def _word(form: str, world: World[Any]) -> Any:
    """The action for one of the world's words, or for a number if actions are numbers; else None."""
    try:
        action = world.read(form)
        if action is None and isinstance(world.action_space, spaces.Discrete) and form.isascii():
            action = finite_value(form[1:] if form[:1] == "#" and form[1:2].isdigit() else form)
            action = action if type(action) is int else None
    except (ValueError, TypeError, OverflowError, RecursionError):
        return None
    return None if action is None else _legal(action, world)


def _numbers(form: str, world: World[Any]) -> Any:
    """The action of a list of numbers, as in `1, 2`, `x1 = 1, x2 = 2` or `[x1, x2] = [1, 2]`; else None."""
    space, names = world.action_space, world.action_parts
    if not isinstance(space, spaces.Box) or len(space.shape) > 1 or len(form) > LONGEST:
        return None
    form = _heading(names).sub("", form.replace("\u2212", "-"), count=1)
    if sum(map(form.count, "([{")) != sum(map(form.count, ")]}")):
        return None
    if _BETWEEN.sub("", _PART.sub("0", form.strip("()[]{} \t\r\n"))).strip("0"):
        return None
    parts = [(name.lower(), _number(digits)) for name, digits in _PART.findall(form)]
    if any(name for name, _ in parts):
        if sorted(name for name, _ in parts) != sorted(names):
            return None
        parts.sort(key=lambda part: names.index(part[0]))
    numbers = [number for _, number in parts]
    return _legal(numbers if space.shape else numbers[0] if len(numbers) == 1 else None, world)


@cache
def _heading(names: tuple[str, ...]) -> re.Pattern[str]:
    spelled = (re.sub(r"([a-z])([0-9])", r"\1_?\2", name) for name in names)
    return re.compile(r"\A[\[(]\s*" + r"\s*,\s*".join(spelled) + r"\s*[\])]\s*[:=]", re.IGNORECASE)


def _number(digits: str) -> int | float:
    return int(digits) if digits.lstrip("+-").isdigit() else float(digits)


# JSON.


def from_json(value: Any, world: World[Any], depth: int = 0) -> Any:
    """The action of a JSON value; None: it is no action, or nested too deeply.

    Raises:
        TwoActions: it has different ones.
    """
    if value is None or depth > _DEPTH:
        return None
    if isinstance(value, str):
        return on_first_line(value, world, depth + 1)[0]
    if isinstance(value, dict):
        if inner := _inner(value, world.answer_names):
            return the_one(from_json(each, world, depth + 1) for each in inner)
        lower = {key.lower(): each for key, each in value.items()}
        if world.action_parts and lower.keys() >= set(world.action_parts):
            value = [lower[name] for name in world.action_parts]
    if unfit(value):
        return None
    text = json.dumps(value)
    action = _word(text, world) if isinstance(world.action_space, spaces.Text) else _legal(value, world)
    if action is None and isinstance(value, dict) and world.text_items:  # one of a list
        return _word(json.dumps([value]), world)
    if action is None and isinstance(value, list):  # numbers as texts, or an action in a list
        action = _numbers(text, world)
        return from_json(value[0], world, depth + 1) if action is None and len(value) == 1 else action
    return action


def _inner(value: dict[str, Any], names: Iterable[str]) -> list[Any]:
    """The values of an object's keys that hold an answer, else of those of a tool's call."""
    lower = {key.lower(): each for key, each in value.items()}
    own = [lower[key] for key in (*NOUNS, "final_answer", *names) if key in lower]
    return own or [lower[key] for key in _TOOL if key in lower]


def text_in(value: Any, names: Iterable[str]) -> str | None:
    """The text in a JSON value: a string, a list of lines, or an object with one of these names; None without a text.

    Raises:
        TwoActions: it has different texts.
    """
    if isinstance(value, list) and value and all(isinstance(line, str) for line in value):
        return "\n".join(value)
    if isinstance(value, dict):
        text: str | None = the_one(text_in(each, names) for each in _inner(value, names))
        return text
    return value if isinstance(value, str) else None


def unfit(value: Any, depth: int = 0) -> bool:
    """Whether a JSON value is or has a truth value, or is nested too deeply for an action."""
    parts = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return depth > _NESTED or isinstance(value, bool) or any(unfit(part, depth + 1) for part in parts)
