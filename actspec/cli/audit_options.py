"""The options of `actspec audit`. Every command builds this grammar, so it imports nothing of the audit."""

from __future__ import annotations

import argparse

FORMATS = ("full", "concise", "json", "sarif", "github", "junit", "markdown", "html")
"""As `actspec.report.FORMATS`."""
CONFIDENCES = ("low", "medium", "high")
FAIL_ON = ("error", "warning", "info", "never")


def add_audit_options(command: argparse.ArgumentParser) -> None:
    """The options of `actspec audit`."""
    command.add_argument(
        "file", nargs="+", metavar="FILE", help="MJCF, URDF, cfg .py, deploy YAML or actspec spec"
    )
    command.add_argument(
        "--skip-other",
        action="store_true",
        help="pass over files that have nothing to audit, as in a folder: for hooks",
    )
    command.add_argument("--spec", metavar="FILE", help="the spec that the other files are held to")
    rules = command.add_argument_group("rules")
    rules.add_argument(
        "--select",
        metavar="CODES",
        action="append",
        type=_codes,
        help="only these rules: code, family or name",
    )
    rules.add_argument("--ignore", metavar="CODES", action="append", type=_codes, help="not these rules")
    rules.add_argument(
        "--min-confidence", choices=CONFIDENCES, help="least confidence reported (default: low)"
    )
    rules.add_argument(
        "-t",
        "--target",
        action="append",
        default=[],
        metavar="NAME==VERSION",
        help="what the files are meant for: mujoco, isaaclab, isaac_sim, mjlab with a version, or backend==newton; "
        "may be repeated",
    )
    rules.add_argument(
        "--config", metavar="FILE", help="settings (default: the nearest actspec.toml, pyproject.toml)"
    )
    output = command.add_argument_group("output")
    output.add_argument("--output-format", choices=FORMATS, default=FORMATS[0], help=f"default: {FORMATS[0]}")
    output.add_argument("-o", "--output", metavar="FILE", help="write the report to FILE")
    output.add_argument("--ledger", action="store_true", help="print what acts on each joint")
    output.add_argument("--statistics", action="store_true", help="print counts by rule in place of findings")
    exits = command.add_argument_group("exit code")
    exits.add_argument(
        "--fail-on",
        choices=FAIL_ON,
        help="least severity that gives exit code 1 (default: error)",
    )
    exits.add_argument("--exit-zero", action="store_true", help="the same as --fail-on never")
    fixes = command.add_argument_group("fixes")
    fixes.add_argument(
        "--fix", action="store_true", help="put right what can be without changing what is computed"
    )
    fixes.add_argument(
        "--unsafe-fixes",
        action="store_true",
        help="fix also what makes the robot behave otherwise: read the diff",
    )
    fixes.add_argument("--diff", action="store_true", help="write no fix; show them, exit 1 if there are any")
    known = command.add_argument_group("known findings")
    known.add_argument("--baseline", metavar="FILE", help="leave out the findings in FILE")
    known.add_argument("--write-baseline", metavar="FILE", help="write the findings to FILE, and exit 0")
    command.add_argument(
        "--jobs", metavar="N", type=_jobs, help="processes that read files (default: one a core)"
    )


def _codes(text: str) -> list[str]:
    return [code.strip() for code in text.split(",") if code.strip()]


def _jobs(text: str) -> int:
    if not text.isdecimal() or not 1 <= int(text) <= 1024:
        raise argparse.ArgumentTypeError(f"must be a number from 1, got {text!r}")
    return int(text)
