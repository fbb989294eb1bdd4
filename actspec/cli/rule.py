"""`actspec rule`: explain rules of the audit."""

from __future__ import annotations

import argparse
import os
import re
import sys
from collections.abc import Iterator

from actspec.audit.ignores import REMARKS
from actspec.audit.pages import INDEX, index, page, record
from actspec.audit.rule import Rule
from actspec.audit.rules import all_rules
from actspec.audit.selection import DIAGNOSTICS, selected, strength
from actspec.audit.settings import check_selectors
from actspec.cli.options import add_force, add_format, describe
from actspec.diagnostics import EXIT_CLEAN, AuditError, Collector, one_line
from actspec.output import write_files
from actspec.report.terminal import print_json
from actspec.spec.plausible import CHECKS, Check
from actspec.study import findings as diagnosis
from actspec.study.symptoms import symptoms_for


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the command's arguments and what its help says."""
    describe(
        command,
        "Print the pages of rules: what a rule does, why it matters, an example, what to write instead.",
        "actspec rule DMP101",
        "0 printed; 2 there is no such rule",
    )
    command.add_argument("rule", nargs="*", metavar="CODE", help="code, family or name")
    command.add_argument("--all", action="store_true", help="every rule")
    command.add_argument(
        "--symptom", metavar="WORD", help="what a symptom usually is, and which rule or command tells"
    )
    command.add_argument("--docs", metavar="DIR", help="write the pages of all rules to DIR")
    add_force(command)
    add_format(command)


def run(arguments: argparse.Namespace) -> int:
    """Print the pages of rules, or write them to a folder."""
    if arguments.symptom is not None:
        return _symptoms(arguments.symptom)
    rules = all_rules()
    arguments.rule = [_code(selector) for selector in arguments.rule]
    checks = () if arguments.all else _checks(arguments.rule)
    if arguments.docs is not None:
        _write(arguments.docs, rules, arguments.force)
        return EXIT_CLEAN
    if not arguments.all:
        rules = _chosen(arguments.rule, rules, checks)
    if arguments.output_format == "json":
        print_json({"format": "actspec-rules/1", "rules": [record(rule) for rule in rules]})
    else:
        said = {} if arguments.all else {**REMARKS, **DIAGNOSTICS}
        texts = [
            f"{code} {name}\n\nThis is no rule: it is reported about "
            + (
                "remarks such as `actspec: ignore[LIM101]` in audited files"
                if code in REMARKS
                else "files as a whole"
            )
            + ". docs/audit.md says when.\n"
            for code, name in said.items()
            if any(strength(selector, code, name) > 1 for selector in arguments.rule)
        ]
        texts += [
            f"{selector}\n\nThis is no rule: {told}\n"
            for selector in arguments.rule
            if (told := _elsewhere(selector)) is not None
        ]
        texts += [
            f"# {check.code} {check.name}\n\n{check.judges}\n\n{check.because}\n\n"
            + (
                f"`{command}` reports it (docs/{command}.md).\n"
                if (command := {"DGN": "diagnose", "CMP": "compare"}.get(check.code[:3]))
                else "`validate`, `show` and `compile` report it (docs/checks.md). `sure: true` beside a value keeps "
                f"it,\n`accept: {{spec.{check.code}: reason}}` all that the check reports.\n"
            )
            for check in checks
        ]
        sys.stdout.write("\n".join([*texts, *(page(rule) for rule in rules)]))
    return EXIT_CLEAN


_OF_SPECS = "it is reported about a spec, or what is compiled of it. docs/checks.md says when."

ELSEWHERE = {
    "ROBOT": "it is reported about robot files. docs/checks.md says when.",
    "SYS": "`sysid` reports it. docs/sysid.md says when, and what helps.",
    "LOG": "it is reported about logs. docs/sysid.md says when, and what helps.",
    "DRF": "`import` reports it. docs/import.md says when.",
    "VFY": "`verify` reports it. docs/verify.md says when.",
    "LRN": "`net` and `delta` report it. docs/networks.md and docs/delta-action.md say when.",
    "LCK": "`lock` reports it. docs/cli.md says when.",
    **dict.fromkeys(("SPEC", "BIND", "RES", "MJC", "ISL", "MJL", "DEP", "URD", "NWT"), _OF_SPECS),
    **dict.fromkeys(("RND", "RTP", "NET0", "DMP0", "FRC0", "CLI", "OUT"), _OF_SPECS),
}
"""Letters of codes that a page of the docs has a table of, to what is said of them."""


def _pages() -> Iterator[tuple[str, ...]]:
    """Code and names of all that has words of its own here."""
    yield from ((rule.code, *rule.names()) for rule in all_rules())
    yield from ((check.code, check.name) for check in _every_check())
    yield from REMARKS.items()
    yield from DIAGNOSTICS.items()


def _elsewhere(selector: str) -> str | None:
    """What is said of a code that has no page of its own; None: it has one, or there is none."""
    if any(strength(selector, *names) > 1 for names in _pages()):
        return None
    letters = selector.rstrip("0123456789")
    if len(selector) - len(letters) not in (0, 3):
        return None
    # Of a family that rules have too the first digit tells.
    return ELSEWHERE.get(letters) or ELSEWHERE.get(selector[: len(letters) + 1])


def _code(selector: str) -> str:
    """A code as it is written, whatever its letters' case; names stay."""
    return selector.upper() if re.fullmatch(r"[A-Za-z]+[0-9]*", selector) else selector


def _symptoms(word: str) -> int:
    """Print the symptoms that a word belongs to."""
    found = symptoms_for(word)
    if not found:
        help = "docs/troubleshooting.md has all; such as: shake, sluggish, order, network"
        raise AuditError.of(
            "AUD010", f"no symptom has '{one_line(word)}' in it", where="--symptom", help=help
        )
    for number, symptom in enumerate(found):
        print("\n" * bool(number) + symptom.name)
        for cause in symptom.causes:
            print(f"  {cause.what}: {', '.join([*cause.codes, *filter(None, [cause.command])])}")
    return EXIT_CLEAN


def _every_check() -> tuple[Check, ...]:
    return (*CHECKS, *diagnosis.CHECKS, *diagnosis.COMPARED)


def _checks(selectors: list[str]) -> tuple[Check, ...]:
    """The checks of a spec's numbers, and of a diagnosis, that selectors name."""
    return tuple(
        check
        for check in _every_check()
        if any(strength(selector, check.code, check.name) > 1 for selector in selectors)
    )


def _chosen(
    selectors: list[str], rules: tuple[type[Rule], ...], checks: tuple[Check, ...]
) -> tuple[type[Rule], ...]:
    """The rules that selectors name; one that names a check need not name a rule."""
    out = Collector()
    if not selectors:
        out.error("AUD010", "names no rule", where="CODE", help="actspec rule LIM101, or --all")
    others = [
        selector
        for selector in selectors
        if _elsewhere(selector) is None and not any(strength(selector, c.code, c.name) > 1 for c in checks)
    ]
    for selector in others:
        # Not a rule of a like code: what another command says has none.
        family = next((letters for letters in ELSEWHERE if selector.startswith(letters)), None)
        letters = selector.rstrip("0123456789")
        if family is not None and not any(strength(letters, *names) > 1 for names in _pages()):
            message = f"no rule has the code, the beginning of a code or the name {one_line(selector)!r}"
            out.error("AUD003", message, where="CODE", help=f"{family} and a number: {ELSEWHERE[family]}")
            others = [other for other in others if other != selector]
    check_selectors(others, rules, "CODE", None, out)
    out.raise_if_failed(AuditError)
    return selected(rules, selectors, ())


def _write(folder: str, rules: tuple[type[Rule], ...], force: bool) -> None:
    """One file a rule, and the index."""
    texts = {f"{rule.code.lower()}.md": page(rule) for rule in rules} | {INDEX: index(rules)}
    files = [(os.path.join(folder, name), text.encode("utf-8")) for name, text in texts.items()]
    write_files(files, force=force)
