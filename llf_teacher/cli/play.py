"""`llf play`: play the student or the teacher in the terminal, or watch a student with its teacher."""

import math
import os
import re
import secrets
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.text import Text

from llf_teacher import cli
from llf_teacher.cli import complete_id, complete_student, complete_teacher, help_shows, read_options, search_here
from llf_teacher.escaping import escape_control_chars
from llf_teacher.models.asked import lines_of
from llf_teacher.models.replies import LENGTH
from llf_teacher.speakers.speaker import EMPTY, FAULTS
from llf_teacher.theme.turns import prepare_turns
from pz_envs.seats import STUDENT, TEACHER
from teachers.atoms import KINDS, ParseFailure
from teachers.feedback import number_of, parse_kinds
from teachers.spec import unknown
from teachers.terminal import Waiting
from teachers.words import KIND_MEANINGS, KIND_WORDS, VERDICTS, VerdictWord, coded_words, kind_word, verdict_of

if TYPE_CHECKING:
    from collections.abc import Iterable

    from llf_teacher.episodes.live import LiveLesson
    from llf_teacher.episodes.record import TurnRow
    from teachers.atoms import Claim
    from teachers.session import Session
    from teachers.teacher_turn import TeacherTurn

UNDO, HELP, QUIT = "undo", ("?", "help"), ("q", "quit", "exit")
"""The words that a person types to take a turn back, to read the rules again, and to leave.

A colon before the word makes it a command where it may also be an action, and in any line of a text of several lines.
"""
_CERTAIN = ":"
_COMMANDS = f"Type {UNDO} to take a turn back, {HELP[0]} for the rules, {QUIT[0]} or Ctrl-D to leave."
_STYLES = {
    "here": "bold blue",
    "goal": "bold yellow",
    "good": "green",
    "bad": "red",
    "muted": "dim",
    "action": "bold",
    "r": "bold magenta",
    "hp": "bold green",
    "hn": "bold red",
    "fp": "bold blue",
    "fn": "bold yellow",
}
"""The style of each role of text and each kind of feedback in a terminal with colours."""


def add_to(app: typer.Typer) -> None:
    """Add the command."""
    app.command("play")(play)


@help_shows("seat", "teacher", "student", "seed", "prompts")
def play(
    id: Annotated[str, typer.Argument(help="Environment, as `llf list` shows it.", autocompletion=complete_id)],
    seat: Annotated[
        str | None, typer.Option(help="Your seat: student, the default without --student, or teacher.")
    ] = None,
    teacher: Annotated[
        str,
        typer.Option(
            help="Teacher, such as 'mistake(eps=0.3)' or module:Class; in the teacher's seat, the one that offers you "
            "claims. To watch, also llm_teacher(...) or module:factory.",
            autocompletion=complete_teacher,
        ),
    ] = "oracle",
    student: Annotated[
        str | None,
        typer.Option(
            help="Student that you teach, by default obedient; without --seat, the one that you watch.",
            autocompletion=complete_student,
        ),
    ] = None,
    instruction_type: cli.InstructionType = "b",
    feedback_type: cli.FeedbackType = "a",
    budget: Annotated[int | None, typer.Option(help="Most claims that you can make as the teacher.")] = None,
    seed: Annotated[int | None, typer.Option(min=0, help="Seed of the episode.")] = None,
    max_turns: cli.MaxTurns = None,
    option: cli.WorldOptions = None,
    bits: Annotated[
        int,
        typer.Option(
            min=0, metavar="WORLDS", help="In the teacher's seat, show how much each claim says, by so many worlds."
        ),
    ] = 0,
    own_words: Annotated[
        bool,
        typer.Option("--own-words", help="In the teacher's seat, say sentences of your own; each is read and checked."),
    ] = False,
    prompts: Annotated[
        bool,
        typer.Option("--prompts", help="Show what each model was asked: all messages as sent, and the answer's form."),
    ] = False,
    _advanced: cli.Advanced = False,
) -> None:
    """Play the student: read the feedback and type actions. Or play the teacher: choose the feedback, or word it.

    With `--student` and without `--seat`, watch: turn by turn the student's answer, the action that was read in it, the
    teacher's words, and whether each sentence is true.

    `undo` takes a turn back, `?` or `help` shows the rules. `q`, `quit`, `exit` or Ctrl-D leaves; where `q` may be an
    answer, type `:q`. A text that is not an action, or not an action that the world lists, costs no turn. An empty line
    ends a text of several lines and is ignored elsewhere. At the end you see which sentences were false. Set NO_COLOR
    to switch colours off.
    """
    if seat is None:
        seat = "student" if student is None else "none"
    elif seat == "student" and student is not None:
        raise ValueError(f"with --seat student you are the student, got --student {student!r}; leave out one of them")
    elif seat not in ("student", "teacher"):
        raise ValueError(f"seat {seat!r} is unknown; allowed: student, teacher")
    if seat == "none" and (bits or own_words or budget is not None):
        raise ValueError(
            "--bits, --own-words and --budget are for your own seat; use --seat teacher, or leave them out"
        )
    if bits and seat == "student":
        raise ValueError("a student cannot see how much claims say; use --seat teacher, or leave out --bits")
    if own_words and (bits or seat == "student"):
        why = (
            "a student says nothing; use --seat teacher" if seat == "student" else "--bits is of claims to choose from"
        )
        raise ValueError(f"{why}, or leave out --own-words")
    if prompts and seat == "student":
        raise ValueError(
            "--prompts shows what models are asked, and in the student's seat you learn from a personality; give "
            "--student, or leave out --prompts"
        )
    console = Console(emoji=False, highlight=False)
    seed = secrets.randbelow(2**31) if seed is None else seed
    if seat == "none":
        given = {"instruction_type": instruction_type, "feedback_type": feedback_type, "max_turns": max_turns}
        _watch(console, id, student or "", teacher, seed, given | read_options(option), prompts)
        return
    lesson = None
    try:
        with Waiting(f"Preparing {id}"):
            lesson = _lesson(
                id,
                seat,
                student or "obedient",
                seed,
                bits,
                read_options(option),
                teacher=teacher,
                instruction_type=instruction_type,
                feedback_type=feedback_type,
                max_turns=max_turns,
                budget=budget if seat == "teacher" else None,
                speech="kinds" if seat == "teacher" and not own_words else "message",
            )
        if seat == "student":
            _learn(console, lesson)
        else:
            if lesson.unmeasured:
                raise ValueError(lesson.unmeasured)
            _teach(console, lesson, prompts)
    except (EOFError, KeyboardInterrupt):
        _say_left(console, *((lesson.rows, lesson.family.name) if lesson else ((), "")))


def _lesson(
    id: str, seat: str, student: str, seed: int, worlds: int, options: dict[str, Any], **settings: Any
) -> "LiveLesson":
    """A lesson with a person in a seat."""
    from llf_teacher.episodes.live import LiveLesson
    from llf_teacher.registry import entry
    from llf_teacher.speakers.parsing import with_teacher
    from llf_teacher.students.parsing import parse_student
    from pz_envs.settings import Settings

    search_here()
    found = entry(id)
    teaches = seat == "teacher"
    player = parse_student(student) if teaches else None
    lesson = Settings(
        text=player is None or player.text,
        until_success=teaches,
        render_mode="ansi",
        privileged_info=teaches,
        options={**found.options, **(found.family.posterior_needs if worlds else {}), **options},
        **settings,
    )
    lesson = with_teacher(lesson, policies=False)
    return LiveLesson(found, lesson, seed, frozenset((TEACHER if teaches else STUDENT,)), player, worlds)


def _watch(
    console: Console,
    id: str,
    student: str,
    teacher: str,
    seed: int,
    settings: dict[str, Any],
    prompts: bool,
) -> None:
    """An episode of a student and its teacher, shown turn by turn; `settings` are those of `make`."""
    from llf_teacher.episodes.loop import play_turns
    from llf_teacher.episodes.recorder import Recorder
    from llf_teacher.gym import StudentEnv
    from llf_teacher.models import LLMError
    from llf_teacher.speakers.parsing import NOBODY, PHRASES, parse_teacher, speaks_freely
    from llf_teacher.speakers.speaker import Speaker
    from llf_teacher.students.parsing import parse_student

    search_here()
    player, taught = parse_student(student), parse_teacher(teacher)
    player.check(os.environ)
    if isinstance(taught, Speaker):
        taught.check(os.environ)
    with Waiting(f"Preparing {id}"):
        env = StudentEnv(id, **settings, teacher=taught, text=player.text)
        policy = player.seat(env.family, env.session.world)
        recorder = Recorder(env.family.name, env.student_view, env.teacher)
        recorder.read(env.family, PHRASES if speaks_freely(taught) else NOBODY)
    _put(console, Text(f"Seed {seed}. Student: {player}. Teacher: {taught}. Ctrl-C leaves.", "dim"))
    form = None
    try:
        turns = play_turns(env, policy, seed)
        while True:
            with Waiting("Waiting for student and teacher"):
                turn = next(turns, None)
            if turn is None:
                break
            row = recorder.note(**(policy.record() if turn.moment.turn else {}))
            if form is None and (form := getattr(policy, "form", None)):
                _put(console, Text(f"The student's model is asked for answers as {form}.", "dim"))
            _show_turn(console, row, env.family.name, prompts)
    except LLMError as error:
        raise ValueError(f"{error}") from None
    except KeyboardInterrupt:
        _say_left(console, recorder.rows, env.family.name)
        return
    finally:
        env.close()
    if prompts:
        _say_unasked(console, recorder.rows)
    last, found = recorder.rows[-1], recorder.episode(policy.reads)
    _say_result(console, last.turn, last.success, found.total_reward)
    _say_false(console, recorder.rows, env.family.name)
    if found.truncated:
        _put(console, Text(f"{found.truncated} of {found.answers} answers were cut at max_tokens."))
    if found.teacher_answers:
        counts = [getattr(found, f"teacher_{fault}") for fault in FAULTS]
        bad = "; ".join(f"{count} {words}" for words, count in zip(FAULTS.values(), counts, strict=True) if count)
        made = f"; {_claims(found.unbuilt)} could not be made" if found.unbuilt else ""
        seconds = (found.teacher_seconds or 0.0) / found.teacher_answers
        said = f"The teacher's model gave {found.teacher_answers} answers: {bad or 'none with a fault'}{made}"
        _put(console, Text(f"{said}; {seconds:.1f} s each."))


def _claims(count: int) -> str:
    return "1 claim" if count == 1 else f"{count} claims"


def _show_prompt(console: Console, asked: dict[str, Any] | None, seat: str) -> None:
    """What the model of a seat was asked, if it was asked."""
    if asked is not None:
        console.print(Text(f"the {seat}'s model was asked:", "cyan"))
        for role, text in lines_of(asked):
            console.print(Text(f"  {role}:", "cyan"))
            _put_beside(console, Text("    "), Text(escape_control_chars(text.strip())))


def _say_unasked(console: Console, rows: "Iterable[TurnRow]") -> None:
    """A message if there was no prompt to show."""
    if not any(row.asked or row.teacher_asked for row in rows):
        _put(console, Text("Neither student nor teacher asked a model, so there are no prompts."))


def _show_turn(console: Console, row: "TurnRow", family: str, prompts: bool) -> None:
    """A turn: the answer, the action that was read in it, the world, the teacher's sentences and their verdicts."""
    turn = prepare_turns([row._asdict()], family)[0]
    if row.turn:
        console.print(Text(f"Turn {row.turn}", "bold"))
        if prompts:
            _show_prompt(console, row.asked, "student")
        if row.thought:
            _put_beside(console, Text("thinks: ", "dim"), Text(escape_control_chars(row.thought), "dim"))
        if row.answer is not None:
            cut = " (cut at max_tokens)" if row.finish == LENGTH else ""
            _put_beside(console, Text(f"answers{cut}: ", "bold"), Text(escape_control_chars(row.answer or "(nothing)")))
        taken = Text("none: the answer is no action", "red")
        if row.parse_failure is None:
            taken = Text(escape_control_chars(f"{turn['did']}"), "bold")
        _put_beside(console, Text("action: ", "bold"), taken)
        console.print(f"reward: {row.reward:.4g}")
    _put_beside(console, Text("sees: ", "dim"), Text(escape_control_chars(row.observation), "dim"))
    if prompts:
        _show_prompt(console, row.teacher_asked, "teacher")
    said = _sentences(turn)
    if not said and (words := row.instruction if not row.turn else row.feedback):
        said = [(None, words, None)]
    for kind, text, verdict in said:
        word = "unchecked" if verdict is None else f"{verdict}"
        style = "" if verdict is None or verdict.holds is None else "green" if verdict.holds else "red"
        lead = Text(f"teacher, {kind_word(kind, not row.turn)} ", _STYLES.get(kind or "", "bold"))
        _put_beside(console, lead.append(f"[{word}]: ", style), Text(escape_control_chars(text)))
    if not said:
        console.print(Text("teacher: (says nothing)", "dim"))
    faults = [FAULTS[fault] for fault in (row.reply or {}).get("faults", ())]
    faults += [f"{_claims(row.unbuilt)} could not be made"] if row.unbuilt else []
    faults += [f"{_claims(row.withheld)} withheld, since false"] if row.withheld else []
    if row.reply and faults:
        lead = Text(f"teacher's model ({', '.join(faults)}): ", "red")
        _put_beside(console, lead, Text(escape_control_chars(row.reply["answer"] or "(nothing)"), "dim"))
    for why in [*_unread(row), *(row.problems or ())]:
        _put_beside(console, Text("  not made: ", "red"), Text(escape_control_chars(why)))
    console.print()


def _unread(row: "TurnRow") -> "Iterable[str]":
    """What is wrong with an answer of the teacher's model in words, which were not asked for."""
    from pz_envs.text.json_values import find_message

    reply = row.reply or {}
    if {*reply.get("faults", ())} == {EMPTY} and reply["answer"] and find_message(reply["answer"]) is None:
        yield 'an answer must be a JSON object, as in {"claims": [...]}; got words'


def _sentences(turn: dict[str, Any]) -> list[tuple[Any, str, VerdictWord | None]]:
    """The kind, the text and the verdict of each sentence of a turn, prepared for display; None: not checked."""
    said: list[tuple[Any, str, VerdictWord | None]]
    said = [(each["kind"], each["text"], verdict_of(each["label"], each.get("elsewhere"))) for each in turn["atoms"]]
    return said + [(each["kind"], each["text"], VERDICTS.get(each["label"])) for each in turn["own"]]


def _say_false(console: Console, rows: "Iterable[TurnRow]", family: str) -> None:
    """How many sentences of the episode were false, and which."""
    turns = prepare_turns([row._asdict() for row in rows], family)
    said = [(turn["turn"], *each) for turn in turns for each in _sentences(turn)]
    checked = [each for each in said if each[-1] is not None and each[-1].holds is not None]
    false = [(turn, kind, text) for turn, kind, text, verdict in checked if verdict is not None and not verdict.holds]
    rest = len(said) - len(checked)
    others = f" Not checked: {rest}; words that are not read, and hedges, are neither true nor false." if rest else ""
    verb = "was" if len(false) < 2 else "were"
    found = f"{len(false) or 'None'} of the {len(checked)} checked sentences {verb} false."
    console.print(f"{found if checked else 'No sentence was checked.'}{others}")
    for turn, kind, text in false:
        lead = Text(f"  turn {turn}, {kind_word(kind, not turn)}: ", "red")
        _put_beside(console, lead, Text(escape_control_chars(text)))


def _say_left(console: Console, rows: "Iterable[TurnRow]", family: str) -> None:
    console.print()
    if rows:
        _say_false(console, rows, family)
    console.print("You left the episode.")


def _learn(console: Console, lesson: "LiveLesson") -> None:
    """An episode in the student's seat."""
    session = lesson.session
    several_lines = session.world.several_lines
    hint = " (an empty line ends it)" if several_lines else ""
    _greet(console, lesson)
    while True:
        _show(console, lesson)
        _say(console, lesson)
        if lesson.over:
            break
        action = None
        while action is None:
            action = _answer(console, lesson, f"Turn {session.moment.turn + 1}{hint}> ")
        if action == UNDO:
            _take_back(console, lesson, STUDENT)
        else:
            lesson.move(STUDENT, action)
    _sum_up(console, lesson, 0.0)


def _answer(console: Console, lesson: "LiveLesson", prompt: str) -> str | None:
    """A person's answer: an action or `UNDO`; None for anything else, after a message."""
    session = lesson.session
    several_lines = session.world.several_lines
    text = _ask(console, prompt, several_lines)
    command, certain = _command(text)
    if command in ("", UNDO):
        return command or None
    if command in HELP:
        _explain(console, session)
        return None
    why = _refusal(session, text)
    if command in QUIT and (certain or why or several_lines):
        raise EOFError
    if why:
        _put(console, Text(escape_control_chars(f"No turn is lost: {why}.")))
        return None
    return text


def _command(text: str) -> tuple[str, bool]:
    """A text in the form of a command, and whether a colon marks it as a command."""
    words = text.strip().lower()
    named = words.removeprefix(_CERTAIN)
    certain = named != words and named in (UNDO, *HELP, *QUIT)
    return (named, True) if certain else (words, False)


def _refusal(session: "Session", text: str) -> str:
    """Why a text is not an action that can be taken now; empty if it is."""
    read = session.read(text)
    if isinstance(read, ParseFailure):
        return f"{read.why}. Expected: {read.expected}"
    possible = session.info.get(session.world.actions_key, ())
    return unknown("action", read, possible) if possible and read not in possible else ""


def _explain(console: Console, session: "Session") -> None:
    """The rules, the kinds of feedback, and what else can be typed."""
    _put(console, Text(escape_control_chars(session.instruction), "bold"))
    for kind in KINDS:
        _put_beside(console, Text(f"{kind:2} ", _STYLES[kind]), Text(KIND_MEANINGS[kind]))
    console.print()
    also = f" Where {QUIT[0]} may be an answer, {_CERTAIN}{QUIT[0]} leaves."
    _put(console, Text(_COMMANDS + also, "dim"))


def _teach(console: Console, lesson: "LiveLesson", prompts: bool) -> None:
    """An episode in the teacher's seat, which shows the truth and, if measured, the information of each claim."""
    session, turn = lesson.session, lesson.teacher_view.teacher_turn
    _greet(console, lesson)
    _put(console, Text(escape_control_chars(session.instruction), "bold"))
    while not lesson.over:
        if prompts and lesson.rows:
            _show_prompt(console, lesson.prompt(), "student")
        _show(console, lesson)
        ask = _choose if lesson.settings.speech == "kinds" else _word
        said = ask(console, lesson, partial(_explain, console, session))
        if said is None:
            _take_back(console, lesson, TEACHER)
            continue
        lesson.move(TEACHER, said if said != "" or lesson.rows else None)
        heard = session.feedback if lesson.settings.speech == "kinds" else lesson.rows[-1].instruction or ""
        _put(console, Text(escape_control_chars(heard), "green"))
        _understood(console, lesson)
    if prompts:
        _say_unasked(console, lesson.rows)
    _sum_up(console, lesson, turn.budget.cost * turn.budget.spent)


def _greet(console: Console, lesson: "LiveLesson") -> None:
    _put(console, Text(f"Seed {lesson.seed}. {_COMMANDS}", "dim"))


def _put(console: Console, text: Text) -> None:
    """Text and an empty line."""
    console.print(text)
    console.print()


def _put_beside(console: Console, lead: Text, text: Text) -> None:
    """Text with every line indented by the width of `lead`."""
    lines = text.wrap(console, max(console.width - len(lead), 1))
    console.print(lead + Text(f"\n{' ' * len(lead)}").join(lines), soft_wrap=True)


def _show(console: Console, lesson: "LiveLesson") -> None:
    """The turn, what the student did, and the world."""
    status, did, *world = lesson.view.pieces()
    shown = Text("").join((_styled([status, did]), _fitted(_styled(world[:-1]), console.width), _styled(world[-1:])))
    shown.rstrip()
    _put(console, shown)


def _styled(pieces: "Iterable[tuple[str, str]]") -> Text:
    return Text.assemble(*((escape_control_chars(piece), _STYLES.get(role, "")) for piece, role in pieces))


def _fitted(drawn: Text, width: int) -> Text:
    """A map, or, if it is wider than the terminal, its part around the student, with a note."""
    lines = drawn.split("\n", allow_blank=True)
    here = next((span for span in drawn.spans if span.style == _STYLES["here"]), None)
    widest = max(map(len, lines))
    if here is None or widest <= width:
        return drawn
    middle = (here.start + here.end) // 2 - drawn.plain.rfind("\n", 0, here.start) - 1
    left = min(max(middle - width // 2, 0), widest - width)
    part = f"A part of the map, which is {widest} columns wide.\n"
    return Text("\n").join([*(_cut(line, left, left + width) for line in lines[:-1]), lines[-1]]).append(part, "dim")


def _cut(line: Text, left: int, right: int) -> Text:
    """Part of a line; an ellipsis stands for each word at an edge."""
    kept = line[left:right]
    for word in re.finditer(r"\S+", line.plain):
        begin, end = max(word.start(), left), min(word.end(), right)
        if begin < end and (begin, end) != word.span():
            kept = kept[: begin - left] + Text("…".center(end - begin)) + kept[end - left :]
    return kept


def _say(console: Console, lesson: "LiveLesson") -> None:
    """The teacher's sentences, each with its kind."""
    for sentence in lesson.view.require_renderer().sentences:
        style = _STYLES.get(sentence.kind or "", "bold")
        word = f"{KIND_WORDS[sentence.kind]}: " if sentence.kind else ""
        text = Text(escape_control_chars(sentence.text), "" if word else "bold")
        _put_beside(console, Text(word, style), text)
    console.print()


def _take_back(console: Console, lesson: "LiveLesson", seat: str) -> None:
    if lesson.moves:
        lesson.undo(seat)
        _put(console, Text("The last turn is taken back."))
    else:
        _put(console, Text("There is no turn to take back."))


def _sum_up(console: Console, lesson: "LiveLesson", costs: float) -> None:
    moment = lesson.session.moment
    _say_result(console, moment.turn, moment.success, math.fsum(row.reward for row in lesson.rows) - costs)
    _say_false(console, lesson.rows, lesson.family.name)


def _say_result(console: Console, turns: int, success: bool, total: float) -> None:
    solved = "solved" if success else "not solved"
    console.print(f"Over after {turns} turns: {solved}, total reward {total:.4g}.")


def _word(console: Console, lesson: "LiveLesson", explain: Callable[[], None]) -> str | None:
    """A person's own words; None: undo."""
    from teachers.teacher_turn import LONGEST

    _put(console, Text(escape_control_chars(f"{lesson.settings.teacher} would say: {lesson.suggestion()}"), "dim"))
    prompt = "What do you say? (empty: nothing)> "
    if not lesson.rows:
        prompt = "Your first words are the instruction, not checked. What do you say? (empty: the text above)> "
    while True:
        text = console.input(prompt)
        command, _ = _command(text)
        if command == UNDO:
            return None
        if command in QUIT:
            raise EOFError
        if command in HELP:
            explain()
        elif len(text) > LONGEST:
            _put(console, Text(f"Nothing is said: at most {LONGEST} characters are allowed, got {len(text)}."))
        else:
            return text


def _understood(console: Console, lesson: "LiveLesson") -> None:
    """The claims that were read in a person's last words, and whether they hold."""
    from llf_teacher.theme.turns import read_sentence
    from teachers.words import VERDICTS

    for reading in lesson.rows[-1].readings or ():
        each = read_sentence(reading, lesson.rows[-1].turn, lesson.family.name)
        verdict = VERDICTS.get(each["label"], "unchecked")
        _put_beside(console, Text(f"  {verdict}: "), Text(escape_control_chars(f"{each['text']} {each['code']}")))
        _put_beside(console, Text("    "), Text(f"{escape_control_chars(each['note'])}\n", "dim"))


def _choose(console: Console, lesson: "LiveLesson", explain: Callable[[], None]) -> int | None:
    """The subset of kinds that a person types, asked until it is valid; empty once the budget is spent; None: undo."""
    turn = lesson.teacher_view.teacher_turn
    budget = turn.budget
    claims = [claim for claim in lesson.claims() if claim.kind is not None] if budget.left else []
    bits = lesson.weigh(claims)
    for i, claim in enumerate(claims):
        kind = f"{claim.kind}"
        lead = Text("  ").append(f"{kind:2} {KIND_WORDS[claim.kind]}: ", _STYLES[kind])
        said = Text(escape_control_chars(_worded(claim, turn)))
        if bits:
            said.append(f"  {bits[i].described}", "dim")
        _put_beside(console, lead, said)
    left = "" if budget.limit is None else f"; {budget.left} of {budget.limit} left"
    prompt = f"Say which kinds, such as praise+advice or hp+fp? (a: all, empty: none{left})> "
    if not budget.left:
        prompt = f"Your budget of {budget.limit} is spent, so that you can say nothing more. Enter to go on> "
    while True:
        text = console.input(prompt)
        command, _ = _command(text)
        if command == UNDO:
            return None
        if command in QUIT:
            raise EOFError
        if command in HELP:
            explain()
            continue
        if not budget.left:
            return 0
        words = text.lower().replace("+", " ").replace(",", " ").split()
        try:
            kinds = parse_kinds("a" if words in (["a"], ["all"]) else words)
        except ValueError:
            console.print(f"Type some of {coded_words(KINDS)}, a for all of them, or nothing; {HELP[0]} explains them.")
            continue
        return number_of(kinds)


def _worded(claim: "Claim[Any]", turn: "TeacherTurn") -> str:
    """A claim in its first wording; when it is said, the wording is drawn."""
    import numpy as np

    from teachers.phrasebook import Draws

    return turn.teacher.voice.say((claim,), turn.moment.turn, Draws(np.random.default_rng(0)), 0)


def _ask(console: Console, prompt: str, several_lines: bool) -> str:
    lines = [console.input(prompt)]
    if _command(lines[0])[0] in (UNDO, *HELP, *QUIT):
        return lines[0]
    while several_lines and lines[-1].strip():
        lines.append(input())
        if _command(lines[-1])[1]:
            return lines[-1]
    return "\n".join(lines)
