"""Settings of the audit: `[tool.actspec.audit]` of a pyproject.toml, or `[audit]` of an actspec.toml."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

from actspec.audit.finding import Confidence
from actspec.audit.ignores import REMARKS
from actspec.audit.places import Places, shown, toml_places
from actspec.audit.rule import Rule
from actspec.audit.selection import ALL, guess, is_diagnostic, strength
from actspec.audit.settings_file import OWN_FILE, SHARED_FILE, find_settings, passed_over
from actspec.diagnostics import (
    AuditError,
    Collector,
    Diagnostic,
    Path,
    Severity,
    Span,
    listed,
    nearest,
    shortened,
)
from actspec.readings.artifact import NOT_TAKEN
from actspec.readings.versions import Versions
from actspec.simulators import release, text_of

BACKENDS = ("physx", "ovphysx", "newton")
"""Source: `Versions.backend`."""

NEVER = "never"
"""`fail-on` for findings that never fail the run."""

_VERSION = re.compile(r"\d{1,6}(\.\d{1,6}){0,3}")

_MOST = 1e300
"""Whole numbers beyond are no floats."""

_T = TypeVar("_T")


@dataclass(frozen=True, slots=True)
class Settings:
    """What the audit is to do.

    Attributes:
        select: Selectors of rules to run.
        ignore: Selectors of rules not to run.
        per_file_ignores: Globs below `folder`, each with selectors of rules whose findings in such files are set
            aside.
        severity: Selectors with the severity that their rules' findings get.
        fail_on: Least severity that makes the run fail; None: none does.
        min_confidence: Least confidence that is reported.
        min_severity: Least severity that reports show; None: that of the format.
        options: Rule code to its options.
        versions: What the files are meant for.
        baseline: File with known findings; None: there is none.
        exclude: Globs below `folder` of files and folders that are passed over; see `actspec.audit.exclude`.
        force_exclude: Whether those that are named are passed over too.
        as_named: Whether the files of a folder are judged as if each was named.
        folder: Folder that globs are relative to.
        passed_over: A settings file beside theirs that is not read; None: there is none.
        exclude_at: Glob of `exclude` to where it is written.
        ignores_at: The same of `per_file_ignores`.
    """

    select: tuple[str, ...] = (ALL,)
    ignore: tuple[str, ...] = ()
    per_file_ignores: tuple[tuple[str, tuple[str, ...]], ...] = ()
    severity: Mapping[str, Severity] = field(default_factory=dict)
    fail_on: Severity | None = Severity.ERROR
    min_confidence: Confidence = Confidence.LOW
    min_severity: Severity | None = None
    options: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    versions: Versions = field(default_factory=Versions)
    baseline: str | None = None
    exclude: tuple[str, ...] = ()
    force_exclude: bool = False
    as_named: bool = False
    folder: str = "."
    passed_over: str | None = None
    exclude_at: Mapping[str, Span] = field(default_factory=dict, compare=False)
    ignores_at: Mapping[str, Span] = field(default_factory=dict, compare=False)


def load_settings(rules: Sequence[type[Rule]], config: str | None = None, start: str = ".") -> Settings:
    """Settings from a file.

    Args:
        rules: All rules, for selectors and options.
        config: The file; default: the nearest one, from `start` upwards. In one folder actspec.toml goes before
            pyproject.toml, and a pyproject.toml without `[tool.actspec]` is passed over.
        start: Folder to begin in.

    Raises: AuditError: with everything that is wrong with the file.
    """
    collector = Collector()
    found = find_settings(config, start, collector)
    collector.raise_if_failed(AuditError)
    if found is None:
        return Settings()
    path, data, text = found
    reader = _Reader(path, text, rules, collector)
    settings = reader.document(data)
    collector.raise_if_failed(AuditError)
    return settings if config is not None else replace(settings, passed_over=passed_over(path))


def check_selectors(
    selectors: Sequence[str], rules: Sequence[type[Rule]], where: str, span: Span | None, out: Collector
) -> None:
    """Report selectors that name no rule."""
    for selector in selectors:
        known = ((rule.code, *rule.names()) for rule in rules)
        told = is_diagnostic(selector)
        if not told and not any(strength(selector, *names) for names in (*known, *REMARKS.items())):
            near = guess(selector, rules)
            families = sorted({rule.code.rstrip("0123456789") for rule in rules})
            out.error(
                "AUD003",
                f"no rule has the code, the beginning of a code or the name '{shortened(selector)}'",
                where=where,
                span=span,
                help=f"did you mean '{near}'?"
                if near
                else f"families: {', '.join(families)}; or a code, or ALL",
            )


def read_versions(
    data: Mapping[str, str], where: str, place: Callable[[str], Span] | None, out: Collector
) -> Versions:
    """Versions by the names of `Versions`' fields.

    Args:
        data: Name to version.
        where: What holds them, for people.
        place: Of each in a file; None: they are options.
        out: Gets what is wrong.
    """
    known = tuple(Versions.__dataclass_fields__)
    wrong, unknown = ("AUD010", "AUD010") if place is None else ("AUD004", "AUD002")
    taken: dict[str, str] = {}
    for written, text in data.items():
        name = written.replace("-", "_")
        named = f"{where}.{shortened(written)}" if place is not None else where
        span = None if place is None else place(written)
        if name not in known:
            near = nearest(name, known)
            out.error(
                unknown,
                f"'{shortened(written)}' is not a simulator or backend that files can be for",
                where=named,
                span=span,
                help=f"did you mean '{near}'?" if near else f"one of {', '.join(known)}",
            )
        elif name == "backend" and text not in BACKENDS:
            message = f"must be one of {', '.join(BACKENDS)}, got '{shortened(text)}'"
            out.error(wrong, message, where=named, span=span)
        elif name != "backend" and not _VERSION.fullmatch(text):
            message = f"must be a version such as 2.3, got '{shortened(text)}'"
            out.error(wrong, message, where=named, span=span)
        else:
            taken[name] = text
    return Versions(**taken)


def named_versions(targets: Sequence[str], out: Collector) -> Versions:
    """The versions that a user names.

    Args:
        targets: `NAME==VERSION`.
        out: Gets what is wrong with them.
    """
    given: dict[str, str] = {}
    for target in targets:
        name, equals, version = target.partition("==")
        if not equals:
            help = "for example isaaclab==2.3"
            out.error("AUD010", f"must be NAME==VERSION, got {target!r}", where="--target", help=help)
        elif given.setdefault(name, version) != version:
            out.error("AUD010", f"two versions of {name}: {given[name]} and {version}", where="--target")
    return read_versions(given, "--target", None, out)


def not_read(settings: Settings) -> Iterator[Diagnostic]:
    """A warning for settings beside those that count."""
    if settings.passed_over is not None:
        message = f"its [tool.actspec] is not read: {OWN_FILE} beside it goes before it"
        help = "keep one of the two"
        yield Diagnostic("AUD019", Severity.WARNING, message, span=Span(settings.passed_over), help=help)


def beyond_known(versions: Versions) -> Iterator[Diagnostic]:
    """A warning for each release that is newer than those that actspec knows: it is taken for the last of them."""
    from actspec.simulators import isaaclab, mjlab, mujoco

    for name, title, releases in (
        ("mujoco", "MuJoCo", mujoco.RELEASES),
        ("isaaclab", "Isaac Lab", isaaclab.RELEASES),
        ("mjlab", "mjlab", mjlab.RELEASES),
    ):
        named, last = getattr(versions, name), tuple(releases)[-1]
        if named is not None and release(named)[:2] > last:
            message = f"actspec knows {title} up to {text_of(last)}, and takes {named} for that"
            help = "name the version that the files are for, or update actspec"
            yield Diagnostic("AUD018", Severity.WARNING, message, f"{name}=={named}", None, help)


class _Reader:
    """Settings out of parsed TOML; every error goes to the collector, with the place of its key."""

    def __init__(self, path: str, text: str, rules: Sequence[type[Rule]], out: Collector) -> None:
        self.path = path
        self.text = text
        self.rules = rules
        self.out = out
        self.folder = os.path.dirname(path) or "."
        self.places: Places | None = None

    def document(self, data: dict[str, Any]) -> Settings:
        """From the whole file."""
        way: Path = ()
        if os.path.basename(self.path) == SHARED_FILE:
            tool = self._table(data.get("tool", {}), ("tool",))
            way = ("tool", "actspec")
            own = self._table(tool.get("actspec", {}), way)
        else:
            own = data
        self._known(own, ("audit",), way)
        way = (*way, "audit")
        return self._audit(self._table(own.get("audit", {}), way), way)

    def _audit(self, data: dict[str, Any], way: Path) -> Settings:
        readers: dict[str, tuple[str, Callable[[Any, Path], Any]]] = {
            "select": ("select", self._selectors),
            "ignore": ("ignore", self._selectors),
            "per-file-ignores": ("per_file_ignores", self._per_file),
            "severity": ("severity", self._severities),
            "fail-on": ("fail_on", self._fail_on),
            "min-confidence": (
                "min_confidence",
                lambda value, way: self._one_of(value, way, {c.value: c for c in Confidence}),
            ),
            "min-severity": (
                "min_severity",
                lambda value, way: self._one_of(value, way, {s.value: s for s in Severity}),
            ),
            "rules": ("options", self._options),
            "versions": ("versions", self._versions),
            "baseline": ("baseline", self._baseline),
            "exclude": ("exclude", self._texts),
            "force-exclude": ("force_exclude", self._yes_or_no),
            "as-named": ("as_named", self._yes_or_no),
        }
        self._known(data, tuple(readers), way)
        taken: dict[str, Any] = {}
        for key, value in data.items():
            if key in readers:
                name, read = readers[key]
                taken[name] = read(value, (*way, key))
        if self.out.failed:
            return Settings()
        for name, key, globs in (
            ("exclude_at", "exclude", enumerate(taken.get("exclude", ()))),
            (
                "ignores_at",
                "per-file-ignores",
                ((glob, glob) for glob, _ in taken.get("per_file_ignores", ())),
            ),
        ):
            taken[name] = {glob: self._span((*way, key, item)) for item, glob in globs}
        return Settings(folder=self.folder, **taken)

    def _span(self, way: Path) -> Span:
        """Where a key or an item is written, or the nearest that it is in."""
        if self.places is None:
            self.places = toml_places(self.text)
        for length in range(len(way), 0, -1):
            if way[:length] in self.places:
                return Span(self.path, *self.places[way[:length]])
        return Span(self.path)

    def _error(self, code: str, message: str, way: Path, help: str | None = None) -> None:
        self.out.error(code, message, where=shown(way), span=self._span(way), help=help)

    def _known(self, data: dict[str, Any], known: Sequence[str], way: Path) -> None:
        for key in data:
            if key not in known:
                near = nearest(key.lower().replace("_", "-"), known)
                choice = (
                    f"the settings stand below [{shown((*way, 'audit'))}]"
                    if "audit" in known
                    else f"known keys: {listed(known, len(known))}"
                )
                help = f"did you mean '{near}'?" if near else choice
                self._error("AUD002", "unknown key", (*way, key), help)

    def _table(self, value: Any, way: Path) -> dict[str, Any]:
        if isinstance(value, dict):
            return value
        self._error("AUD004", f"must be a table, got {_got(value)}", way)
        return {}

    def _selectors(self, value: Any, way: Path) -> tuple[str, ...]:
        if not isinstance(value, list) or not all(isinstance(item, str) for item in value):
            self._error("AUD004", f"must be a list of codes or names, got {_got(value)}", way)
            return ()
        for index, item in enumerate(value):
            check_selectors([item], self.rules, shown(way), self._span((*way, index)), self.out)
        return tuple(value)

    def _texts(self, value: Any, way: Path) -> tuple[str, ...]:
        if isinstance(value, list) and all(isinstance(item, str) for item in value):
            return tuple(value)
        self._error("AUD004", f"must be a list of globs, got {_got(value)}", way)
        return ()

    def _yes_or_no(self, value: Any, way: Path) -> bool:
        if not isinstance(value, bool):
            self._error("AUD004", f"must be true or false, got {_got(value)}", way)
        return value is True

    def _per_file(self, value: Any, way: Path) -> tuple[tuple[str, tuple[str, ...]], ...]:
        table = self._table(value, way)
        return tuple((glob, self._selectors(item, (*way, glob))) for glob, item in table.items())

    def _one_of(self, value: Any, way: Path, known: Mapping[str, _T]) -> _T | None:
        if isinstance(value, str) and value in known:
            return known[value]
        near = nearest(value, tuple(known)) if isinstance(value, str) else None
        message = f"must be one of {', '.join(known)}, got {_got(value)}"
        self._error("AUD004", message, way, f"did you mean '{near}'?" if near else None)
        return None

    def _severities(self, value: Any, way: Path) -> dict[str, Severity]:
        found = {}
        for selector, item in self._table(value, way).items():
            check_selectors([selector], self.rules, shown(way), self._span((*way, selector)), self.out)
            said = is_diagnostic(selector) or any(strength(selector, *names) for names in REMARKS.items())
            if said and not any(strength(selector, rule.code, *rule.names()) for rule in self.rules):
                message = f"'{selector}' is no rule: what is said beside findings has its own severity"
                refused = (
                    "a model that you name and MuJoCo refuses is AUD020" if selector == "AUD013" else None
                )
                if selector in NOT_TAKEN:
                    refused = "of a file that you name it is AUD022"
                self._error("AUD004", message, (*way, selector), refused)
            severity = self._one_of(item, (*way, selector), {s.value: s for s in Severity})
            if severity is not None:
                found[selector] = severity
        return found

    def _fail_on(self, value: Any, way: Path) -> Severity | None:
        known: dict[str, Severity | None] = {s.value: s for s in Severity}
        return self._one_of(value, way, {**known, NEVER: None})

    def _options(self, value: Any, way: Path) -> dict[str, dict[str, float]]:
        codes = {name: rule for rule in self.rules for name in (rule.code, *rule.names())}
        found: dict[str, dict[str, float]] = {}
        for key, options in self._table(value, way).items():
            here = (*way, key)
            rule = codes.get(key)
            if rule is None:
                near = guess(key, self.rules)
                help = near and f"did you mean '{near}'?"
                self._error("AUD003", "no rule has this code or name", here, help)
                continue
            table = self._table(options, here)
            if not rule.options and table:
                self._error("AUD002", f"{rule.code} has no options", here)
                continue
            self._known(table, tuple(rule.options), here)
            for name, number in table.items():
                if isinstance(number, bool) or not isinstance(number, (int, float)) or number != number:
                    self._error("AUD004", f"must be a number, got {_got(number)}", (*here, name))
                elif not -_MOST < number < _MOST:
                    self._error("AUD004", f"must be a finite number, got {_got(number)}", (*here, name))
                elif name in rule.options:
                    found.setdefault(rule.code, {})[name] = float(number)
        return found

    def _versions(self, value: Any, way: Path) -> Versions:
        texts: dict[str, str] = {}
        for key, text in self._table(value, way).items():
            if isinstance(text, str):
                texts[key] = text
            else:
                # 3.10 as a number is 3.1.
                self._error("AUD004", f"must be text, got {_got(text)}", (*way, key), 'write "2.3"')
        return read_versions(texts, shown(way), lambda key: self._span((*way, key)), self.out)

    def _baseline(self, value: Any, way: Path) -> str | None:
        if isinstance(value, str) and value and "\0" not in value:
            return os.path.normpath(os.path.join(self.folder, value))
        self._error("AUD004", f"must be a path, got {_got(value)}", way)
        return None


def _got(value: Any) -> str:
    """A value of a settings file for a message."""
    if isinstance(value, dict):
        return "a table"
    return shortened(repr(value))
