from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from pathlib import PurePath

from actspec.audit.finding import Fix, Safety, TextEdit
from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.diagnostics import Span
from actspec.readings.artifact import ActuatorGroup, FileKind, Framework
from actspec.readings.config import control_of
from actspec.readings.versions import is_native
from actspec.simulators import before, release
from actspec.simulators.isaaclab import OLD_NAMES_GONE

_NEW = {
    "effort_limit": "actuator_effort_limit",
    "velocity_limit": "actuator_velocity_limit",
    "effort_limit_sim": "joint_effort_limit",
    "velocity_limit_sim": "joint_velocity_limit",
}
"""Name in 2.x to the name in 3.0. Source: Isaac Lab 3.0, actuator_base_cfg.py."""

_OLD = {new: old for old, new in _NEW.items()}


class NamesByVersion(RuleOver[tuple[str, list[ActuatorGroup]]]):
    code = "VER103"
    name = "isaaclab-names-by-version"
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    fix = Safety.SAFE
    needs = "no Isaac Lab cfg with actuators among the files"

    def subjects(self, case: Case) -> Iterator[tuple[str, list[ActuatorGroup]]]:
        yield from _groups(case).items()

    def judge(self, case: Case, subject: tuple[str, list[ActuatorGroup]]) -> Iterator[Finding]:
        """Compare names with the version, or with each other."""
        path, groups = subject
        named = case.versions.isaaclab
        old = [(group, name) for group in groups for name in _NEW if name in group.settings]
        new = [(group, name) for group in groups for name in _OLD if name in group.settings]
        if named is not None:
            yield from self._against(case, old, new, named)
        elif old and new:
            yield self._mixed(path, old, new)

    def _against(
        self,
        case: Case,
        old: list[tuple[ActuatorGroup, str]],
        new: list[tuple[ActuatorGroup, str]],
        text: str,
    ) -> Iterator[Finding]:
        if not is_native(case.versions):
            left, other = _left(case, new)
            for group, name in new:
                plain = _is_plain(group, name) and not other
                yield Finding(
                    self.code,
                    f"Isaac Lab {text} has no {name}: the cfg raises TypeError when it is made",
                    group.settings[name].span,
                    help=f"2.x calls it {_OLD[name]}{left}",
                    related=other,
                    fix=renaming(case, group, name, _OLD[name]) if plain else None,
                    about=name,
                )
            return
        gone = not before(release(text), OLD_NAMES_GONE)
        left, other = _left(case, old)
        for group, name in old:
            plain = _is_plain(group, name)
            yield Finding(
                self.code,
                f"Isaac Lab {text} has no {name} any more"
                if gone
                else f"{name} is a deprecated name in Isaac Lab {text}, and gone in 4.0",
                group.settings[name].span,
                help=f"3.0 calls it {_new_name(group, name)}"
                + (left if plain else "; an implicit drive's own limits are left to you by --fix"),
                related=other,
                fix=renaming(case, group, name, _NEW[name]) if plain and not other else None,
                severity=Severity.ERROR if gone else Severity.WARNING,
                about=name,
            )

    def _mixed(
        self, path: str, old: list[tuple[ActuatorGroup, str]], new: list[tuple[ActuatorGroup, str]]
    ) -> Finding:
        (before, old_name), (after, new_name) = old[0], new[0]
        return Finding(
            self.code,
            f"{new_name} is a name of Isaac Lab 3.0 and {old_name} one of 2.x: 2.x does not read this file, and 4.0 "
            "neither",
            after.settings[new_name].span,
            help=f"name the limits as one version does: {old_name} is {_new_name(before, old_name)} in 3.0",
            related=(before.settings[old_name].span,),
            severity=Severity.WARNING,
            about=f"{new_name} {old_name}",
        )


def _groups(case: Case) -> dict[str, list[ActuatorGroup]]:
    """Groups of Isaac Lab's classes by file."""
    found: dict[str, list[ActuatorGroup]] = {}
    for _, artifact in case.of_kind(FileKind.CFG):
        config = artifact.config
        if config is not None and config.framework is Framework.ISAACLAB:
            known = [group for group in config.groups if control_of(config.framework, group.cls) != "other"]
            found.setdefault(artifact.path, []).extend(known)
    return {path: groups for path, groups in found.items() if groups}


def _new_name(group: ActuatorGroup, name: str) -> str:
    """An implicit drive's limits are the joint's, whatever 2.x called them."""
    if control_of(Framework.ISAACLAB, group.cls) == "implicit":
        return _NEW[name].replace("actuator_", "joint_")
    return _NEW[name]


def _is_plain(group: ActuatorGroup, name: str) -> bool:
    """Whether the field is the same one in both versions; what 2.x makes of an implicit drive's own limits is not."""
    own = name in ("effort_limit", "velocity_limit") or name.startswith("actuator_")
    return not own or control_of(Framework.ISAACLAB, group.cls) != "implicit"


def _left(case: Case, fields: list[tuple[ActuatorGroup, str]]) -> tuple[str, tuple[Span, ...]]:
    """Of a file's fields, where one is read or set by its name once it is made, which a fix would not rename with it.

    Returns: What the help adds, and the place; "" and none.
    """
    for group, name in fields:
        place = group.settings[name].span
        module = PurePath(place.path).with_suffix("")
        stem = (module.parent if module.name == "__init__" else module).name.encode()
        for path, (data, uses) in case.once(_uses).items():
            use = uses.get(name)
            # Another file is one of this configuration's where it speaks of its module.
            if use is not None and (use.line != place.line if path == place.path else stem in data):
                return f"; {path}:{use.line} has {name}, too: rename all together, as --fix does not", (use,)
    return "", ()


def _uses(case: Case) -> dict[str, tuple[bytes, dict[str, Span]]]:
    """The text of each Python file, and where it has a name first as an attribute, in quotes or in a copy's call."""
    found: dict[str, tuple[bytes, dict[str, Span]]] = {}
    for file in (file for reading in case.files if reading.readable for file in reading.files):
        if not file.path.endswith(".py") or file.path in found:
            continue
        uses: dict[str, Span] = {}
        if any(name.encode() in file.data for name in (*_NEW, *_OLD)):
            try:
                nodes = [*ast.walk(ast.parse(file.data))]
            except (SyntaxError, ValueError, RecursionError):
                nodes = []
            for name, line in ((name, line) for node in nodes for name, line in _named(node)):
                uses[name] = min(
                    uses.get(name, Span(file.path, line)), Span(file.path, line), key=lambda s: s.line or 0
                )
        found[file.path] = file.data, uses
    return found


def _named(node: ast.AST) -> Iterator[tuple[str, int]]:
    if isinstance(node, ast.Attribute):
        # An actuator's own `self.effort_limit` is no configuration's.
        if not (isinstance(node.value, ast.Name) and node.value.id == "self"):
            yield node.attr, node.lineno
    elif isinstance(node, ast.Constant) and isinstance(node.value, str):
        yield node.value, node.lineno
    elif isinstance(node, ast.Call) and _name(node.func) in ("replace", "dict"):
        yield from ((keyword.arg, keyword.lineno) for keyword in node.keywords if keyword.arg is not None)


def renaming(case: Case, group: ActuatorGroup, old: str, new: str) -> Fix | None:
    """Rename a field where it is a keyword of the group's own class.

    Args:
        case: The case.
        group: The group.
        old: Field as written.
        new: What it is to be called; not one that the group has already.

    Returns: None where the field is set in another way, or in a text that is no keyword's value (a constant).
    """
    span = group.settings[old].span
    data = next((f.data for reading in case.files for f in reading.files if f.path == span.path), None)
    if data is None or new in group.settings:
        return None
    try:
        text = data.decode("utf-8")
        calls = [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Call)]
    except (SyntaxError, ValueError, RecursionError):
        return None
    lines = data.splitlines(keepends=True)
    places = [
        keyword
        for call in calls
        if _name(call.func) == group.cls
        for keyword in call.keywords
        if keyword.arg == old and (span.line, span.column) in _starts(keyword, lines)
    ]
    if len(places) != 1 or any(line.endswith(b"\r") for line in lines):
        return None
    start = sum(map(len, lines[: places[0].lineno - 1])) + places[0].col_offset
    end = start + len(old.encode())
    if data[start:end] != old.encode():
        return None
    return Fix(f"Rename {old} to {new}", Safety.SAFE, (TextEdit(span.path, start, end, new.encode()),))


def _name(function: ast.expr) -> str:
    return function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")


def _starts(keyword: ast.keyword, lines: Sequence[bytes]) -> Iterator[tuple[int, int]]:
    """Where a keyword and its value begin, in characters from 1."""
    for node in (keyword, keyword.value):
        before = lines[node.lineno - 1][: node.col_offset]
        yield node.lineno, len(before.decode("utf-8", "replace")) + 1
