"""How far every target of the robot library is from the law, in the simulators' own code: verify.md beside this.

    python benchmarks/verify.py            # write it
    python benchmarks/verify.py --check    # exit 1 where it is not what the engines say

All engines must be there (`actspec verify --setup`), and the models of mjlab's robots
(`pip install --no-deps mjlab`): without them nothing is written. Exit code 1 also where anything disagrees. Some
minutes; the same engines give the same page.
"""

from __future__ import annotations

import argparse
import math
import platform
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from actspec import api  # noqa: E402
from actspec.diagnostics import ActspecError, listed  # noqa: E402
from actspec.simulate.experiment import COURSES  # noqa: E402
from actspec.verify.agreement import Agreement, At, Row, Skip  # noqa: E402
from actspec.verify.environments import find_frameworks  # noqa: E402

PAGE = Path(__file__).with_suffix(".md")
COMMAND = "python benchmarks/verify.py"


@dataclass(frozen=True, slots=True)
class Verified:
    """One spec and what its targets do.

    Attributes:
        name: Stem of the spec.
        compilation: It, compiled.
        agreement: What was found.
    """

    name: str
    compilation: api.Compilation
    agreement: Agreement


def verified(paths: Iterable[Path]) -> tuple[list[Verified], list[str]]:
    """Every spec, and what stands in the way."""
    done, missing = [], []
    for path in paths:
        print(path.stem, file=sys.stderr, flush=True)
        try:
            compilation, agreement = api.verify(path)
        except ActspecError as err:
            missing.append(f"{path.stem}: {err.diagnostics[0]}")
            continue
        missing += [f"{path.stem}: {skip.reason}" for skip in agreement.skipped if skip.setup]
        done.append(Verified(path.stem, compilation, agreement))
    return done, missing


def page(done: Sequence[Verified]) -> str:
    """The text of the page."""
    rows = [row for one in done for row in one.agreement.rows]
    engines = sorted({row.engine for row in rows if row.engine is not None})
    torques = [row for row in rows if row.quantity.startswith("torque")]
    marked = [row for row in torques if row.approximations]
    beyond = [row for row in torques if not row.approximations]
    lines = [
        "# The robot library in every engine",
        "",
        f"Written by `{COMMAND}`; [docs/verify.md](../docs/verify.md) says what is compared and what is allowed.",
        "",
        f"Python {platform.python_version()}, {listed(engines)}.",
        "",
        f"{len(done)} specs, {_count(done)} targets, {len(rows)} comparisons: {_verdict(rows)}. Torques: "
        f"{len(beyond)} that hold the whole law are off by at most {_share(beyond)} of what is allowed, "
        f"{len(marked)} are marked `~`: a known approximation concerns them.",
        "",
        "## Torques",
        "",
        "The largest difference from the law over the grid of error, velocity and history, by group and target.",
        "",
        "| robot | group | joints | target | largest error | allowed | at | approximations |",
        "|---|---|---:|---|---:|---:|---|---|",
        *_table(done, ("torque", "torque.step", "torque.ramp")),
        "",
        "## Responses",
        "",
        "The one of each group and target that is nearest to what is allowed: step, saturated step, chirp, coast-down.",
        "",
        "| robot | group | joints | target | largest error | allowed | at | approximations |",
        "|---|---|---:|---|---:|---:|---|---|",
        *_table(done, COURSES),
        "",
        "## Fields",
        "",
        "Numbers of the files, read back and compared within 1e-6: agreed, of all.",
        "",
        *_fields(done),
        "",
        "## Not asked",
        "",
        *_skipped(done),
    ]
    faults = [(one, row) for one in done for row in one.agreement.faults]
    if faults:
        lines += ["", "## Disagreements", ""]
        lines += [f"- {one.name}, {row.target}, {row.joint}: {row.code} {row.message}" for one, row in faults]
    return "\n".join(lines) + "\n"


def _count(done: Iterable[Verified]) -> int:
    return sum(len(one.compilation.targets) for one in done)


def _verdict(rows: Sequence[Row]) -> str:
    wrong = sum(not row.ok for row in rows)
    return f"{wrong} disagree" if wrong else "all agree"


def _share(rows: Sequence[Row]) -> str:
    return f"{max((_of_allowed(row) for row in rows), default=0.0):.2g}"


def _of_allowed(row: Row) -> float:
    if row.max_error is None:
        return math.inf
    return row.max_error / row.tolerance if row.tolerance else math.inf * (row.max_error > 0.0)


def _table(done: Iterable[Verified], quantities: Sequence[str]) -> Iterator[str]:
    """One line for each robot, target and group: the worst of the quantities."""
    for one in done:
        for options in one.compilation.targets:
            mine = [
                row
                for row in one.agreement.rows
                if row.target == options.name and row.quantity in quantities and row.engine is not None
            ]
            for group in dict.fromkeys(row.group for row in mine):
                shared = [row for row in mine if row.group == group]
                worst = max(shared, key=lambda row: (not row.ok, _of_allowed(row)))
                joints = sum(row.joints for row in shared if row.quantity == worst.quantity)
                keys = dict.fromkeys(key for row in shared for key in row.approximations)
                names = listed([key.partition(".")[2] for key in keys], most=12)
                yield _line(
                    one.name,
                    group,
                    str(joints),
                    f"{options.name} {options.version}".rstrip(),
                    _amount(worst.max_error, worst.unit) + ("" if worst.ok else " **beyond**"),
                    _amount(worst.tolerance, worst.unit) + (" ~" if keys else ""),
                    f"{worst.joint}: {worst.quantity}{_at(worst.at)}",
                    names,
                )


def _amount(value: float | None, unit: str) -> str:
    if value is None:
        return "none"
    return "any" if math.isinf(value) else f"{value:.2g} {unit}"


def _at(at: At | None) -> str:
    if at is None:
        return ""
    if at.time is not None:
        return f", {at.time:.3g} s"
    error = f", error {at.error:.3g}" if at.error is not None else f", command {at.command:.3g}"
    return f"{error}, velocity {at.velocity:.3g}" + (f", step {at.step}" if at.step else "")


def _fields(done: Sequence[Verified]) -> Iterator[str]:
    names = list(dict.fromkeys(options.name for one in done for options in one.compilation.targets))
    yield _line("robot", *names)
    yield "|---|" + "---:|" * len(names)
    for one in done:
        there = {options.name for options in one.compilation.targets}
        cells = []
        for name in names:
            mine = [
                row
                for row in one.agreement.rows
                if row.target == name
                and not row.quantity.startswith("torque")
                and row.quantity not in COURSES
            ]
            right = sum(row.ok for row in mine)
            cells.append(
                "" if name not in there else str(right) if right == len(mine) else f"{right} of {len(mine)}"
            )
        yield _line(one.name, *cells)


def _skipped(done: Sequence[Verified]) -> Iterator[str]:
    found: dict[tuple[str, str], dict[str, None]] = {}
    for one in done:
        for skip in one.agreement.skipped:
            found.setdefault((_what(skip), skip.reason), {})[one.name] = None
    for (what, reason), robots in found.items():
        whose = "all" if len(robots) == len(done) else listed(list(robots), most=12)
        yield f"- {what} ({whose}): {reason}"


def _what(skip: Skip) -> str:
    return " ".join(part for part in (skip.target, skip.group, skip.what) if part)


def _line(*cells: str) -> str:
    return f"| {' | '.join(cell.replace('|', '/') for cell in cells)} |"


def main() -> int:
    """Write or check."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument(
        "--check", action="store_true", help="write nothing; exit 1 where the page would change"
    )
    parser.add_argument("spec", nargs="*", type=Path, help="print these alone, and write nothing")
    arguments = parser.parse_args()
    if find_frameworks() is None:
        print("skipped: the engines are not here: actspec verify --setup")
        return 0
    done, missing = verified(arguments.spec or sorted((ROOT / "robots").glob("*.yaml")))
    for what in missing:
        print(f"skipped: {what}")
    text = page(done)
    agreed = all(one.agreement.ok for one in done)
    if arguments.spec:
        print(text, end="")
    elif missing:
        return 0
    elif arguments.check:
        if PAGE.read_text(encoding="utf-8") != text:
            print(f"{PAGE.name} is not what the engines say: {COMMAND}")
            return 1
    else:
        PAGE.write_text(text, encoding="utf-8")
    return 0 if agreed else 1


if __name__ == "__main__":
    sys.exit(main())
