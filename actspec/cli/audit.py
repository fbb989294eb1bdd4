"""`actspec audit`: report where robot files disagree with each other and with physics."""

from __future__ import annotations

import argparse
import os
from collections.abc import Mapping

from actspec.audit.exclude import Exclude
from actspec.audit.read import pending_files
from actspec.audit.settings_file import excluded
from actspec.cli.options import FAIL_ON, add_force, add_versions, describe
from actspec.placing import finish
from actspec.readings.named import PendingFiles, expand
from actspec.report import FORMATS

CONFIDENCES = ("low", "medium", "high")
SEVERITIES = ("error", "warning", "info")


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the command's arguments and what its help says."""
    describe(
        command,
        "Read MJCF, URDF, Isaac Lab, mjlab and legged_gym configurations, deploy YAML and specs, running none of them, "
        "and report where they disagree with each other and with physics.",
        "actspec audit robot.xml robot_cfg.py --ledger",
        "0 nothing at or above --fail-on (default: error); 1 findings there; 2 a name stands for no file, the spec "
        "cannot be read, a folder has nothing to audit, or actspec could not run; with --output-format sarif 0 in "
        "place of 1",
    )
    command.add_argument(
        "file", nargs="+", metavar="FILE", help="MJCF, URDF, cfg .py, deploy YAML or actspec spec"
    )
    command.add_argument(
        "--skip-other",
        action="store_true",
        help="skip files that have nothing to audit, as in a folder: for hooks",
    )
    command.add_argument(
        "--exclude",
        metavar="GLOBS",
        action="append",
        type=_codes,
        help="pass over these files and folders of folders, beside `exclude` of the settings",
    )
    command.add_argument(
        "--force-exclude",
        action="store_true",
        help="pass over excluded files that are named too: for hooks",
    )
    command.add_argument(
        "--as-named",
        action="store_true",
        help="judge the files of a folder as if each was named: for a folder that is your own",
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
    add_versions(rules)
    rules.add_argument(
        "--config", metavar="FILE", help="settings (default: the nearest actspec.toml, pyproject.toml)"
    )
    output = command.add_argument_group("output")
    output.add_argument("--output-format", choices=FORMATS, default=FORMATS[0], help=f"default: {FORMATS[0]}")
    output.add_argument("-o", "--output", metavar="FILE", help="write the report to FILE")
    add_force(output)
    shown = output.add_mutually_exclusive_group()
    shown.add_argument(
        "--min-severity",
        choices=SEVERITIES,
        help="least severity shown (default: warning; info in json, sarif and html)",
    )
    shown.add_argument(
        "--notes",
        dest="min_severity",
        action="store_const",
        const="info",
        help="show notes too: the same as --min-severity info",
    )
    output.add_argument("--ledger", action="store_true", help="print what acts on each joint")
    output.add_argument("--statistics", action="store_true", help="print counts by rule in place of findings")
    exits = command.add_argument_group("exit code")
    exits.add_argument(
        "--fail-on",
        choices=FAIL_ON,
        help="least severity that gives exit code 1 (default: error)",
    )
    exits.add_argument(
        "--exit-zero",
        action="store_true",
        help="the same as --fail-on never; a name that stands for no file stays 2",
    )
    fixes = command.add_argument_group("fixes")
    fixes.add_argument(
        "--fix", action="store_true", help="apply the fixes that do not change what is computed"
    )
    fixes.add_argument(
        "--unsafe-fixes",
        action="store_true",
        help="apply also those that change how the robot behaves: read the diff",
    )
    fixes.add_argument("--diff", action="store_true", help="write no fix; show them, exit 1 if there are any")
    known = command.add_argument_group("known findings")
    known.add_argument("--baseline", metavar="FILE", help="leave out the findings in FILE")
    known.add_argument(
        "--no-baseline", action="store_true", help="show the findings in the baseline of the settings too"
    )
    known.add_argument(
        "--write-baseline",
        metavar="FILE",
        help="write the findings to FILE, keep those it has of other files, and exit 0",
    )
    command.add_argument(
        "--jobs", metavar="N", type=_jobs, help="processes that read files (default: one a core)"
    )


def run(arguments: argparse.Namespace) -> int:
    """Audit the files."""
    if (arguments.fix or arguments.unsafe_fixes) and not arguments.diff:
        # What a killed run has left would be read as it is, and where nothing is left to fix, stay.
        finish(file.path for file in expand(arguments.file))
    with _begin(arguments) as pending:
        # Rules and reports are imported while the readers import MuJoCo.
        from actspec.cli.audit_run import report_on

        return report_on(arguments, pending, lambda changed: _begin(arguments, changed))


def _begin(arguments: argparse.Namespace, changed: Mapping[str, bytes] | None = None) -> PendingFiles:
    """Begin to read the files, each once, the spec too; some as they would be after `changed`."""
    paths = tuple(dict.fromkeys([*arguments.file, *([arguments.spec] if arguments.spec else [])]))
    # Without threads of numpy's linear algebra this process can be forked; it needs none.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    globs, folder, force = excluded(arguments.config)
    exclude = Exclude(
        (
            *((glob, folder) for glob in globs),
            *((glob, ".") for group in arguments.exclude or () for glob in group),
        ),
        force or arguments.force_exclude,
        arguments.spec,
    )
    return pending_files(
        paths, skip_other=arguments.skip_other, jobs=arguments.jobs, exclude=exclude, changed=changed
    )


def _codes(text: str) -> list[str]:
    return [code.strip() for code in text.split(",") if code.strip()]


def _jobs(text: str) -> int:
    if not text.isdecimal() or not 1 <= int(text) <= 1024:
        raise argparse.ArgumentTypeError(f"must be a number from 1, got {text!r}")
    return int(text)
