"""`actspec audit` against MuJoCo alone, which only parses and compiles the same models.

The peer does the least that anybody must: one process a core, each model parsed, its meshes replaced by
the same tiny stand-ins, compiled. No mesh file is read by either. All commands are fresh processes, in
turn, so that whatever else the machine does falls on all alike; printed are medians, quartiles and the
ratios with their budgets.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from startup import ROOT, actspec, machine, seconds, table

CORPUS = Path(os.environ.get("ACTSPEC_CORPUS", ROOT.parent / "shared" / "corpus"))
MANY = 200
"""Models in the folder."""

PEER = """
import os, sys
from multiprocessing import get_context

TETRAHEDRON = b"v 0 0 0\\nv 10 0 0\\nv 0 10 0\\nv 0 0 10\\nf 1 3 2\\nf 1 2 4\\nf 1 4 3\\nf 2 3 4\\n"

def quiet(text):
    pass

def compile(path):
    import mujoco
    mujoco.set_mju_user_warning(quiet)
    with open(path, encoding="utf-8") as stream:
        spec = mujoco.MjSpec.from_string(stream.read())
    assets = {}
    for mesh in spec.meshes:
        if mesh.file:
            mesh.name = mesh.name or os.path.splitext(os.path.basename(mesh.file))[0]
            mesh.file += ".obj"
            assets[os.path.basename(mesh.file).lower()] = TETRAHEDRON
    spec.assets = assets
    return spec.compile().nv

paths = sys.argv[1:]
if len(paths) == 1:
    compile(paths[0])
else:
    cores = min(len(os.sched_getaffinity(0)), len(paths))
    with get_context("fork").Pool(cores) as pool:
        sum(pool.imap_unordered(compile, paths))
"""


@dataclass(frozen=True)
class Case:
    """The audit of some files and the peer's work on them.

    Attributes:
        name: For the table.
        paths: The models.
        budget: Most that the ratio of the medians may be.
    """

    name: str
    paths: list[str]
    budget: float


def models() -> list[Path]:
    """MJCFs in one file each that MuJoCo compiles, the largest first."""
    from actspec.diagnostics import RobotError
    from actspec.robot.mjspec import compile_spec, open_spec
    from actspec.robot.view import ModelFormat
    from actspec.robot.xml import open_document

    found = []
    for path in sorted((*CORPUS.rglob("*.xml"), *(ROOT / "robots").rglob("*.xml"))):
        try:
            document = open_document(str(path))
            # The peer knows stand-ins for meshes only.
            textured = any(element.get("file") for element in document.walk("texture", "hfield"))
            if document.root.tag != "mujoco" or len(document.files) > 1 or textured:
                continue
            model = compile_spec(open_spec(document.files, format=ModelFormat.MJCF))
        except RobotError:
            continue
        if model.nu:
            found.append(path)
    return sorted(found, key=lambda path: -path.stat().st_size)


def cases(folder: Path) -> list[Case]:
    """What is measured; copies of the models, without their meshes, go below `folder`."""
    known = models()
    if not known:
        raise SystemExit("there is no model to audit")
    paths = []
    for index in range(MANY):
        source = known[index % len(known)]
        target = folder / f"{index:03d}_{source.name}"
        shutil.copyfile(source, target)
        paths.append(str(target))
    g1 = [path for path in paths if path.endswith("_g1_29dof.xml")]
    return [
        Case(f"one model ({Path((g1 or paths)[0]).name[4:]})", (g1 or paths)[:1], 1.5),
        Case(f"{MANY} models ({len(known)} different)", paths, 1.2),
    ]


def measure(runs: int) -> dict[str, Any]:
    """Run everything in turn, after one round that warms the caches.

    Returns: Facts of the machine and, for each case, the times [s] and their ratio.
    """
    import statistics

    environment = {**os.environ, "NO_COLOR": "1"}
    with tempfile.TemporaryDirectory() as folder:
        todo = cases(Path(folder))
        times: dict[str, list[float]] = {}
        load = os.getloadavg()[0] if hasattr(os, "getloadavg") else None
        for run in range(runs + 1):
            for case in todo:
                for key, command in (
                    ("baseline", [sys.executable, "-c", PEER, *case.paths]),
                    ("own", [*actspec(), "audit", "--fail-on", "never", *case.paths]),
                ):
                    taken = seconds(command, environment)
                    if run:
                        times.setdefault(f"{case.name} {key}", []).append(taken)
    rows = []
    for case in todo:
        own, baseline = times[f"{case.name} own"], times[f"{case.name} baseline"]
        ratio = statistics.median(own) / statistics.median(baseline)
        rows.append(
            {
                "name": f"audit {case.name}",
                "baseline_code": f"MuJoCo alone, {case.name}",
                "seconds": own,
                "baseline_seconds": baseline,
                "ratio": ratio,
                "budget": case.budget,
                "ok": ratio <= case.budget,
            }
        )
    return {"format": "actspec-benchmark-audit/1", "machine": machine(load), "runs": runs, "cases": rows}


def main() -> int:
    """Measure and print; exit 1 when a ratio is over its budget."""
    parser = argparse.ArgumentParser(description="Measure the audit against MuJoCo's own parse and compile.")
    parser.add_argument("--runs", type=int, default=15, help="runs of each command (default: 15)")
    parser.add_argument("--json", action="store_true", help="print every time as JSON")
    arguments = parser.parse_args()
    if arguments.runs < 2:
        parser.error("--runs must be at least 2")
    result = measure(arguments.runs)
    print(json.dumps(result, indent=2) if arguments.json else table(result))
    return 0 if all(row["ok"] for row in result["cases"]) else 1


if __name__ == "__main__":
    raise SystemExit(main())
