"""`actspec diff`: what changed in effective dynamics between two files or revisions."""

from __future__ import annotations

import argparse
import tempfile

from actspec.audit.difference import compare_files
from actspec.audit.revision import lay_out, names_revision
from actspec.cli.options import add_format, add_versions, configured_versions, describe
from actspec.diagnostics import EXIT_CLEAN, EXIT_FINDINGS
from actspec.report.difference import record, report_lines
from actspec.report.terminal import print_json, print_lines
from actspec.spec.variants import named, split

FORMAT = "actspec-diff/1"


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the command's arguments and what its help says."""
    describe(
        command,
        "Compare two robot files, or a file with an earlier revision of it, in what acts on each joint: "
        "gains, damping, friction, limits, armature, delays, steps, directions.",
        "actspec diff HEAD:robots/a1/a1.xml robots/a1/a1.xml",
        "0 no change in what both state; 1 changes, or nothing to compare; 2 could not run",
    )
    command.add_argument(
        "old",
        metavar="OLD",
        help="MJCF, URDF, cfg .py, deploy YAML or spec, or REVISION:FILE of git; SPEC#NAME is a "
        "variant of a spec",
    )
    command.add_argument("new", metavar="NEW", help="likewise")
    command.add_argument("--robot", metavar="NAME", help="only this robot of files that have several")
    command.add_argument(
        "--joints",
        metavar="FILE|LIST",
        help="names of the joints, where configurations have patterns and no robot file is at hand, as of `import`",
    )
    add_versions(command)
    add_format(command)


def run(arguments: argparse.Namespace) -> int:
    """Compare the two files."""
    versions = configured_versions(arguments.target)
    texts: dict[str, str] = {}
    with tempfile.TemporaryDirectory(prefix="actspec-") as folder:
        paths = []
        for side in (arguments.old, arguments.new):
            path = side
            file, variant = split(side)
            if names_revision(file):
                path = named(lay_out(file, tempfile.mkdtemp(dir=folder)).path, variant)
            texts[path] = side
            paths.append(path)
        found = compare_files(paths[0], paths[1], versions, arguments.robot, texts, arguments.joints)
    old, new = texts[paths[0]], texts[paths[1]]
    if arguments.output_format == "json":
        print_json({"format": FORMAT, "robots": [record(item, old, new) for item in found]})
    else:
        print_lines(report_lines(found, old, new))
    return EXIT_CLEAN if all(item.same for item in found) else EXIT_FINDINGS
