from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence

from actspec.audit.finding import Fix, Safety, TextEdit
from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
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
            for group, name in new:
                yield Finding(
                    self.code,
                    f"Isaac Lab {text} has no {name}: the cfg raises TypeError when it is made",
                    group.settings[name].span,
                    help=f"2.x calls it {_OLD[name]}",
                    fix=renaming(case, group, name, _OLD[name]) if _is_plain(group, name) else None,
                    about=name,
                )
            return
        gone = not before(release(text), OLD_NAMES_GONE)
        for group, name in old:
            yield Finding(
                self.code,
                f"Isaac Lab {text} has no {name} any more"
                if gone
                else f"{name} is a deprecated name in Isaac Lab {text}, and gone in 4.0",
                group.settings[name].span,
                help=f"3.0 calls it {_new_name(group, name)}"
                + (
                    ""
                    if _is_plain(group, name)
                    else "; an implicit drive's own limits are left to you by --fix"
                ),
                fix=renaming(case, group, name, _NEW[name]) if _is_plain(group, name) else None,
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
