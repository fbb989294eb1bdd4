"""`actspec audit` against MuJoCo alone, which only parses and compiles the same models.

The peer does the least that anybody must: one process a core, each model parsed, its meshes replaced by
the same tiny stand-ins, compiled. No mesh file is read by either. All commands are fresh processes, in
turn, so that whatever else the machine does falls on all alike; printed are medians, quartiles and the
ratios with their budgets.

No model is measured twice: copies would be cheaper to compare than real files, or, in one folder, dearer.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import shutil
import sys
import tempfile
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from startup import ROOT, actspec, machine, seconds, table

CORPUS = os.environ.get("ACTSPEC_CORPUS", str(ROOT.parent / "shared" / "corpus"))
"""Folders with robot files, separated as in PATH."""
MANY = 200
"""Models at most."""
LEAST_JOINTS = 4
"""Hinges and slides that a model without actuators has at least: robots for a configuration, no doors."""

PEER = """
import os, sys
from multiprocessing import get_context

TETRAHEDRON = b"v 0 0 0\\nv 10 0 0\\nv 0 10 0\\nv 0 0 10\\nf 1 3 2\\nf 1 2 4\\nf 1 4 3\\nf 2 3 4\\n"
PIXEL = bytes.fromhex(
    "89504e470d0a1a0a0000000d4948445200000001000000010802000000907753de0000000c"
    "49444154789c63f8ffff3f0005fe02fe0def46b80000000049454e44ae426082"
)

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
    for texture in spec.textures:
        if texture.file:
            texture.content_type = "image/png"
            assets[os.path.basename(texture.file).lower()] = PIXEL
    spec.assets = assets
    return spec.compile().nu

paths = sys.argv[1:]
if len(paths) == 1:
    compile(paths[0])
elif paths:
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
    """MJCFs in one file each that the peer compiles, each content once, in the order of their paths."""
    import mujoco

    peer: dict[str, Any] = {}
    exec(PEER.partition("paths =")[0], peer)
    found: dict[str, Path] = {}
    folders = [Path(folder) for folder in CORPUS.split(os.pathsep)]
    for path in (path for folder in (*folders, ROOT / "robots") for path in sorted(folder.rglob("*.xml"))):
        data = path.read_bytes()
        digest = hashlib.sha256(data).hexdigest()
        if digest in found or b"<mujoco" not in data or b"<include" in data:
            continue
        try:
            joints = mujoco.MjSpec.from_string(data.decode()).joints
            kinds = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)
            if peer["compile"](path) or sum(joint.type in kinds for joint in joints) >= LEAST_JOINTS:
                found[digest] = path
        except ValueError:
            continue
    return list(found.values())[:MANY]


def cases(folder: Path) -> list[Case]:
    """What is measured; the models, without their meshes, go below `folder`."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        known = models()
    if not known:
        raise SystemExit("there is no model to audit")
    paths = []
    for index, source in enumerate(known):
        target = folder / f"{index:03d}_{source.name}"
        shutil.copyfile(source, target)
        paths.append(str(target))
    g1 = [path for path in paths if path.endswith("_g1_29dof.xml")]
    return [
        Case(f"one model ({Path((g1 or paths)[0]).name[4:]})", (g1 or paths)[:1], 1.5),
        Case(f"{len(paths)} models", paths, 1.5),
    ]


def taken(command: list[str], environment: dict[str, str], processor: bool) -> float:
    """Time of one fresh process and its own [s].

    Args:
        command: What is run.
        environment: Its variables.
        processor: Processor time of all in place of wall time.
    """
    if not processor:
        return seconds(command, environment)
    import resource

    # To the microsecond, where `os.times` counts in hundredths of a second.
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds(command, environment)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def measure(runs: int, processor: bool) -> dict[str, Any]:
    """Run everything in turn, after one round that warms the caches.

    Args:
        runs: Of each command.
        processor: As in `taken`.

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
                    used = taken(command, environment, processor)
                    if run:
                        times.setdefault(f"{case.name} {key}", []).append(used)
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
    parser.add_argument(
        "--processor",
        action="store_true",
        help="processor time of all processes: for a machine with other work",
    )
    parser.add_argument("--json", action="store_true", help="print every time as JSON")
    arguments = parser.parse_args()
    if arguments.runs < 2:
        parser.error("--runs must be at least 2")
    result = measure(arguments.runs, arguments.processor)
    print(json.dumps(result, indent=2) if arguments.json else table(result))
    return 0 if all(row["ok"] for row in result["cases"]) else 1


if __name__ == "__main__":
    raise SystemExit(main())
