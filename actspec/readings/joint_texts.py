"""Names of joints in a text: one a line, a list as any language writes it, a table, the heads of a recording, a log.

Each reader gives every list that may be meant. Where some are called lists of joints, no other one counts.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from actspec.diagnostics import shortened
from actspec.files import in_common

_NO_NAME = re.compile(r"[,;\s]+")
_COMMENT = re.compile(r"#(?![ \t]*[|,;]).*")
"""No `#` alone at the head of a column."""
_NUMBERED = re.compile(r"^[ \t]*(?:[-*][ \t]+)?(?:\d+[:.)][ \t]+)?")
"""Before a name in a list of lines: a dash, a number."""
_PRINTED = re.compile(r"\s*(?:\[[A-Z]+\]:?\s+)?(?:[A-Za-z][\w ]*[:=])?\s*\[([^\[\]]*)\]\s*")
"""A list without quotes, alone or behind words: `joints: [hip, knee]`."""
_NO_TEXT = "is no text"
_QUOTED = re.compile(r"(['\"])(.*)\1")
NAME_KEYS = ("name", "joint", "joint_name", "joint name", "dof_name", "dof name")
"""What the name of a joint is called in a table, or in a list of mappings."""
_NO_JOINT = ("", "t", "time", "__time", "timestamp", "index", "step")
"""Columns of a recording that are no joint's."""
_NUMBER = re.compile(r"[+-]?(?:\d+(?:\.\d*|,\d+)?|\.\d+)(?:[eE][+-]?\d+)?")
PATTERN = re.compile(r"[\\*+?|()^$\[\]{}]")
"""What no name of a joint has."""
_MEANT_AS_PATTERN = re.compile(r"[\\*+?|^$]|\w[\[({].+[\])}]|[\[({].+[\])}]\w")

_TOKEN = re.compile(
    r"""(?<!\w)'([^'\\\n]*)'|(?<!\w)"([^"\\\n]*)"|([\[({])|([\])}])|[,\s]+|\n|[^\s,'"\[\](){}]+|."""
)
_OF_JOINTS = re.compile(r"joint|dof", re.IGNORECASE)
_OF_OTHERS = re.compile(r"bod(?:y|ies)|link|sensor|geom|site|tendon|foot|feet", re.IGNORECASE)
_LONGEST_LABEL = 400
"""Characters before a list that say what it is of. Chosen: a line of Isaac Lab's log has up to 250."""
_COLLECTION = "Actuator collection"
"""How Isaac Lab begins what it logs of each group, with the group's joints and their places in the robot."""
_IDS = re.compile(r"\s*\[(?:tensor\()?\[?([\d,\s]+)\]")
_USD = "usd value"
"""Head of Isaac Lab's table of what its configuration changes: it has the joints of these figures alone."""

_WORDS = (
    "q|dq|qd|ddq|qdd|pos|position|vel|velocity|acc|tau|torque|effort|cmd|command|target|action|current|temp"
)
_SIGNAL_END = re.compile(rf"(?P<stem>.+)(?P<mark>[._/](?:{_WORDS}))")
"""A column of one joint's signal, `hip_pos`, `hip.torque`, `/joint_states/hip/position`."""
_SIGNAL_START = re.compile(
    rf"(?P<mark>(?:(?:dof|joint|motor|actuator|act|measured|meas|desired|des|ref)[._/])*(?:{_WORDS})"
    rf"(?:[._/](?:{_WORDS}|desired|des|ref|measured|meas))*[._/])(?P<stem>[A-Za-z].*)",
    re.IGNORECASE,
)
"""The same with the signal before the joint: `q_hip`, `dof_pos_hip`, `tau_des_hip`."""


class NoNamesError(ValueError):
    """A text that has no names of joints, or not only these.

    Attributes:
        help: What to write instead; None: the same as for all.
        line: From 1; 0 where no line is meant.
    """

    def __init__(self, message: str, help: str | None = None, line: int = 0) -> None:
        super().__init__(message)
        self.help = help
        self.line = line


@dataclass(frozen=True, slots=True)
class _Found:
    """A list that stands in a text; `of_joints`: whether it is called one of joints; None: it is called nothing."""

    names: tuple[str, ...]
    of_joints: bool | None


def lists_in(text: str) -> list[tuple[str, ...]]:
    """Every list of names that a text may mean, no name twice in one; at least one.

    Raises: NoNamesError: it has none, a pattern, a name twice, or several and nothing tells which.
    """
    text = _COMMENT.sub("", text)
    if "\0" in text:
        raise NoNamesError(_NO_TEXT)
    if found := _called(text):
        return found
    columns = _columns(text)
    if columns is None:
        return [distinct(text)]
    if any("" in names for names in columns):
        raise NoNamesError("a row of its table has no name", "write the joint's name, or take the row out")
    return [_checked([(n, 0) for n in names]) for names in columns]


def lists_in_notebook(data: bytes) -> list[tuple[str, ...]]:
    """The lists that a notebook has printed, else those of its code.

    Raises: NoNamesError: as `lists_in`, or it is no notebook.
    """
    try:
        cells = json.loads(data)["cells"]
        codes = ["".join(cell["source"]) for cell in cells]
        printed = ["\n".join(_outputs(cell)) for cell in cells]
    except (ValueError, LookupError, TypeError, AttributeError, RecursionError):
        raise NoNamesError("is no notebook") from None
    for texts in (printed, codes):
        if found := _called(_COMMENT.sub("", "\n".join(texts))):
            return found
    raise NoNamesError("no list of joint names is in it")


def _outputs(cell: Any) -> Iterator[str]:
    for output in cell.get("outputs", ()):
        for text in (output.get("text", ""), output.get("data", {}).get("text/plain", "")):
            yield "".join(text)


def distinct(text: str) -> tuple[str, ...]:
    """Names with commas, blanks or lines between them, in quotes or not, numbered or not.

    Raises: NoNamesError: one is a pattern or stands there twice, a number stands beside names, or there is none.
    """
    if "\0" in text or "\ufffd" in text:
        raise NoNamesError(_NO_TEXT)
    if printed := _PRINTED.fullmatch(text):
        text = "\n" * text.count("\n", 0, printed.start(1)) + printed[1]
    found = []
    for at, line in enumerate(text.splitlines(), 1):
        words = [word for word in _NO_NAME.split(_NUMBERED.sub("", line)) if word]
        named = [(_QUOTED.sub(r"\2", word), at) for word in words]
        _check_names(named)
        counts = [word for word in words if _NUMBER.fullmatch(word)]
        if counts and len(counts) < len(words):
            raise NoNamesError(f"{counts[0]} is a number beside names", line=at)
        found += named
    return _checked(found)


def _checked(words: Sequence[tuple[str, int]]) -> tuple[str, ...]:
    """Words, each with its line, that are names of joints."""
    _check_names(words)
    found = dict[str, None]()
    for word, line in words:
        if word in found:
            raise NoNamesError(f"{shortened(word, 80)} stands there twice", line=line)
        if word:
            found[word] = None
    if not found:
        raise NoNamesError("no name of a joint is in it")
    return tuple(found)


def _check_names(words: Sequence[tuple[str, int]]) -> None:
    for word, line in words:
        if word == "|":
            message = "it has a table, and no column headed `name` or `joint` with names alone, each once"
            raise NoNamesError(message, line=line)
        if PATTERN.search(word):
            shown = shortened(word, 80)
            meant = any(map(str.isalnum, shown)) and _MEANT_AS_PATTERN.search(shown) is not None
            what = "a pattern, and names are needed" if meant else "no name of a joint"
            raise NoNamesError(f"{shown} is {what}", line=line)


def _called(text: str) -> list[tuple[str, ...]]:
    """The lists in a text that are called lists of joints, else the only one that is called nothing.

    Raises: NoNamesError: of several that are called nothing.
    """
    found = [*_tabled(text), *_written(text)]
    of_joints = dict.fromkeys(one.names for one in found if one.of_joints)
    unnamed = dict.fromkeys(one.names for one in found if one.of_joints is None)
    if not of_joints and len(unnamed) > 1:
        raise NoNamesError(
            "which of its lists has the joints is not told", "write `joint_names: ` before that one"
        )
    return [*of_joints] or [*unnamed]


def _written(text: str) -> Iterator[_Found]:
    """Lists of names in quotes, in brackets of any kind: Python's, numpy's, of TOML, of C.

    One that is behind other words than of joints, such as `Body names:`, is none.

    Raises: NoNamesError: one that is called a list of joints has a name twice.
    """
    groups: list[tuple[tuple[str, ...], tuple[int, ...]]] = []
    for line, own, end in _in_brackets(text):
        # Other brackets before it are the head of a log's line.
        label = re.split(r"[\])}]", line)[-1]
        of_joints = _OF_JOINTS.search(label) is not None
        if any(not name or PATTERN.search(name) for name in own):
            continue
        if len(set(own)) < len(own):
            if of_joints:
                _checked([(name, text.count("\n", 0, end) + 1) for name in own])
        elif _COLLECTION in line:
            ids = _IDS.match(text, end)
            groups.append((own, tuple(map(int, re.findall("[0-9]{1,9}", ids[1]))) if ids else ()))
        elif of_joints or not _OF_OTHERS.search(label):
            yield _Found(own, of_joints or None)
    if groups:
        yield from (_Found(own, True) for own in _of_groups(groups))


def _in_brackets(text: str) -> Iterator[tuple[str, tuple[str, ...], int]]:
    """What stands before a list in its line, the list, and where it ends; lists within one list are one."""
    found: list[str] = []
    names: list[str] | None = None
    label, end = "", 0
    before = 0
    for token in _TOKEN.finditer(text):
        quoted = token[1] if token[1] is not None else token[2]
        if token[3]:
            behind = text[token.start() - 1] if token.start() else " "
            # `cfg["joint_names"]` and `print("hip")` are no lists.
            names = None if (behind.isalnum() or behind in "_])") and token[3] != "{" else []
            if found and (before > end or text[before : token.start()].strip() != ","):
                yield label, tuple(found), end
                found = []
            if not found:
                label = text[max(0, token.start() - _LONGEST_LABEL) : token.start()].rpartition("\n")[2]
        elif token[4]:
            before = token.end()
            if names:
                found, end = found + names, before
            names = None
        elif quoted is not None and names is not None:
            names.append(quoted)
        elif token[0].strip(", \t\r\n"):
            names = None
    if found:
        yield label, tuple(found), end


def _of_groups(groups: Sequence[tuple[tuple[str, ...], tuple[int, ...]]]) -> list[tuple[str, ...]]:
    """The joints of a robot's groups, by their places where each has one; of several robots, group by group."""
    names = [name for own, _ in groups for name in own]
    places = [place for _, own in groups for place in own]
    if len(set(names)) < len(names):
        return [own for own, _ in groups]
    if len(set(places)) == len(names) and all(len(own) == len(at) for own, at in groups):
        names = [name for _, name in sorted(zip(places, names, strict=True))]
    return [tuple(names)]


def _tabled(text: str) -> Iterator[_Found]:
    """Names of tables with lines between their columns, as Markdown has them and Isaac Lab prints them."""
    rows: list[list[str]] = []
    for line in (*map(str.strip, text.splitlines()), ""):
        if line.startswith("|") and any(map(str.isalnum, line)):
            rows.append([cell.strip(" \t`*'\"") for cell in line.strip("|").split("|")])
        elif not line.startswith(("|", "+")):
            yield from _of_table(rows)
            rows = []


def _of_table(rows: Sequence[Sequence[str]]) -> Iterator[_Found]:
    title = rows[0][0] if rows and len(rows[0]) == 1 else None
    head, *body = rows[title is not None :] or [()]
    heads = [cell.lower() for cell in head]
    own = [at for at, cell in enumerate(heads) if cell in NAME_KEYS]
    if len(own) != 1 or not body or any(len(row) != len(head) for row in body) or _USD in heads:
        return
    names = tuple(row[own[0]] for row in body)
    if len(set(names)) < len(names) or any(not name or PATTERN.search(name) for name in names):
        return
    if _OF_JOINTS.search(heads[own[0]]) or (title and _OF_JOINTS.search(title)):
        yield _Found(names, True)
    elif title is None:
        yield _Found(names, None)


def _columns(text: str) -> list[list[str]] | None:
    """The names of a table without lines, or lists of them; None of what is none.

    Its first line heads one column by `name` or the like, or columns of a recording, or all are numbers but one.

    Raises: NoNamesError: it has numbers, and several columns that may be the names.
    """
    lines = [line for line in text.splitlines() if line.strip(" \t,;")]
    for mark in (",", ";", "\t", None):
        rows = [[cell.strip().strip("\"'") for cell in line.split(mark)] for line in lines]
        if not rows or any(len(row) != len(rows[0]) for row in rows):
            continue
        heads = [head.lower() in NAME_KEYS for head in rows[0]]
        # A text of blanks and names has no heads, and one name alone is a name.
        if heads.count(True) == 1 and (len(rows) > 1 if len(heads) == 1 else mark is not None):
            return [[row[heads.index(True)] for row in rows[1:]]]
        if mark is not None and (heads_only := _heads(rows)):
            return heads_only
        columns = list(zip(*rows, strict=True))
        counts = [len(rows) > 1 and _are_numbers(column[1:]) for column in columns]
        if any(counts) and not all(counts):
            own = zip(columns, counts, strict=True)
            headed = any(count and not _are_numbers(column) for column, count in own)
            words = [
                column[headed:]
                for column, count in zip(columns, counts, strict=True)
                # Where one has another mark, commas are within numbers: `hip;24,5`.
                if not count and not any(re.search("[;\t]", cell) for cell in column)
            ]
            if not words:
                continue
            names = [column for column in words if len(set(column)) == len(column)]
            if len(names) != 1:
                raise NoNamesError(
                    "which of its columns has the names is not told", "head that column `name`"
                )
            return [list(names[0])]
    return None


def _are_numbers(column: Sequence[str]) -> bool:
    """Whether a column has numbers alone; a cell may be empty."""
    cells = [cell for cell in column if cell]
    return bool(cells) and all(map(_NUMBER.fullmatch, cells))


def _heads(rows: Sequence[Sequence[str]]) -> list[list[str]]:
    """The joints that a recording's columns are of, `hip.position [rad]`, `q_hip` or `hip`; none of other tables.

    Joints of which there are two signals or more are these; others' columns (`base_z`) may stand beside them.
    """
    first, *rest = rows
    numbers = all(_NUMBER.fullmatch(cell) for row in rest for cell in row)
    if not rest or not numbers or any(_NUMBER.fullmatch(head) for head in first):
        return []
    heads = [re.sub(r"\s*\[[^\[\]]*\]$", "", head) for head in first]
    heads = [head for head in heads if head.lower() not in _NO_JOINT]
    ends = [_SIGNAL_END.fullmatch(head) for head in heads]
    starts = [_SIGNAL_START.fullmatch(head) for head in heads]
    for found in (ends, starts):
        alike: dict[frozenset[str], set[str]] = {}
        signals: dict[str, dict[str, None]] = {}
        for match in found:
            if match:
                signals.setdefault(match["mark"], {})[match["stem"]] = None
        for mark, stems in signals.items():
            alike.setdefault(frozenset(stems), set()).add(mark)
        if lists := [
            [*signals[min(marks)]] for stems, marks in alike.items() if len(marks) > 1 and len(stems) > 1
        ]:
            return lists
    dotted = [end["stem"] for end in ends if end and end["mark"][0] == "."]
    begun = [start for start in starts if start]
    if dotted or (ends and all(ends)):
        # One that ends otherwise may be a joint's own name.
        names = dotted or [end["stem"] for end in ends if end]
    elif len(begun) > 1:
        several = len({start["mark"] for start in begun}) > 1
        names = [start["stem"] if several else start[0] for start in begun]
    else:
        names = heads
    names = list(dict.fromkeys(names))
    return [names] if len(names) > 1 else []


def without_beginning(names: Sequence[str]) -> tuple[list[str], str]:
    """Names of joints without what all share before them, a path or a signal, and what that is; ([], "") without any.

    `/World/dog/joints/fl_hip` is fl_hip, and `q_fl_hip` too; of paths that differ the ends are taken.
    """
    bare, cut = list(names), ""
    if all("/" in name for name in names):
        first, last = min(names), max(names)
        # The folders that all paths share, with the last `/`.
        shared = first[: first.rfind("/", 0, in_common(first, last)) + 1]
        if all(name.startswith("/") for name in names):
            bare = [name.rpartition("/")[2] for name in names]
            whole = all(name == shared + end for name, end in zip(names, bare, strict=True))
            cut = f"the path {shared}" if whole else "their paths"
        elif shared:
            bare, cut = [name[len(shared) :] for name in names], f"the path {shared}"
    found = [_SIGNAL_START.fullmatch(name) for name in bare] if len(bare) > 1 else []
    marks = {match["mark"] if match else "" for match in found}
    if len(marks) == 1 and "" not in marks:
        mark = marks.pop()
        bare, cut = [name[len(mark) :] for name in bare], f"{cut} and " * bool(cut) + f"the beginning {mark}"
    useful = cut and all(bare) and len(set(bare)) == len(bare)
    return (bare, cut) if useful else ([], "")
