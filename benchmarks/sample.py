"""What the audit says of folders that strangers published, for people to judge: benchmarks/judging.md.

    python benchmarks/sample.py FOLDER [--seen FOLDER]... [--jobs 2] [-o findings.txt] [--counts counts.tsv]
        [--add-judged]

Every folder in FOLDER is one package or repository, audited as a user would name it. Printed is each error and warning
whose file is in none of the folders that were seen before, byte by byte, nor in an earlier package of the sample, nor
in judged.txt: beside this program, the digests of files whose findings were judged, to which --add-judged adds those of
this sample. The counts have a line a package: its name, new files, errors and warnings.

A sample is blind where the packages were chosen, and the rules committed, before one of their files was read.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from actspec.audit.engine import audit  # noqa: E402
from actspec.audit.settings import Settings  # noqa: E402
from actspec.diagnostics import Severity  # noqa: E402
from actspec.report.findings import for_people  # noqa: E402

JUDGED = ROOT / "benchmarks" / "judged.txt"
ENDINGS = (".xml", ".urdf", ".mjcf", ".py", ".yaml", ".yml")


@dataclass(frozen=True, slots=True)
class Package:
    """What the audit says of one package.

    Attributes:
        name: Of its folder.
        files: Digests of what was audited.
        findings: Digest of the file and text of each error and warning, as a reader sees it.
        fault: Why it could not be audited; "" otherwise.
    """

    name: str
    files: frozenset[str]
    findings: tuple[tuple[str, str], ...]
    fault: str = ""


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seen", action="append", default=[], type=Path)
    parser.add_argument("--jobs", default=os.cpu_count(), type=int)
    parser.add_argument("-o", "--output", type=Path)
    parser.add_argument("--counts", type=Path)
    parser.add_argument("--add-judged", action="store_true")
    arguments = parser.parse_args()
    seen = {digest for folder in arguments.seen for digest in _digests(folder.resolve())}
    judged = set(JUDGED.read_text(encoding="utf-8").split())
    names = sorted(path.name for path in arguments.folder.iterdir() if path.is_dir())
    output, counts = (path and path.resolve() for path in (arguments.output, arguments.counts))
    # A file is named from the sample's folder, whoever reads the list.
    os.chdir(arguments.folder)
    with ProcessPoolExecutor(arguments.jobs) as pool:
        packages = list(pool.map(_audited, names))
    lines: list[str] = []
    rows: list[str] = []
    added: set[str] = set()
    for package in packages:
        told = {
            text: digest for digest, text in package.findings if digest not in seen and digest not in judged
        }
        new = package.files - seen
        seen |= new
        lines += told
        added |= set(told.values())
        rows.append(f"{package.name}\t{len(new)}\t{len(told)}\t{package.fault}")
    _write(output, "\n\n".join(lines))
    if counts is not None:
        _write(counts, "\n".join(rows))
    if arguments.add_judged:
        _write(JUDGED, "\n".join(sorted(judged | added)))
    files = sum(int(row.split("\t")[1]) for row in rows)
    print(f"{len(lines)} errors and warnings in {files} new files of {len(rows)} packages", file=sys.stderr)
    return 0


def _audited(name: str) -> Package:
    try:
        report = audit([name], Settings())
    except Exception as err:  # A package that breaks the audit is a line of the counts, and a fault to mend.
        return Package(name, frozenset(), (), f"{type(err).__name__}: {err}")
    files = frozenset(_digest(file.path) for file in report.case.files if not file.names_nothing)
    findings = tuple(
        (
            _digest(first.finding.span.path),
            f"{first.finding.span}: {first.finding.code} [{first.severity.value}] {text}",
        )
        for first, text in ((group.first, group.headline()) for group in for_people(report.findings))
        if first.severity is not Severity.INFO
    )
    return Package(name, files, findings)


def _digests(folder: Path) -> Iterator[str]:
    for inside, _, names in os.walk(folder):
        for name in names:
            if name.endswith(ENDINGS):
                yield _digest(os.path.join(inside, name))


def _digest(path: str) -> str:
    try:
        return hashlib.sha256(Path(path).read_bytes()).hexdigest()[:32]
    except OSError:
        return path


def _write(path: Path | None, text: str) -> None:
    if path is None:
        print(text)
    else:
        path.write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
