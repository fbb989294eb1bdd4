"""Start-up: actspec's commands against the bare imports that they cannot do without.

Runs each command as a fresh process, all of them in turn, so that whatever else the machine does falls on
all alike; prints medians, quartiles and the ratios with their budgets (DESIGN section 10).
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
SPEC = ROOT / "robots" / "a1.yaml"
CALL = "from actspec.__main__ import entry; entry()"


@dataclass(frozen=True)
class Case:
    """A command and the bare imports that it is measured against.

    Attributes:
        name: For the table.
        command: What is measured.
        baseline: Python that imports what the command needs at least.
        budget: Most that the ratio of the medians may be.
    """

    name: str
    command: list[str]
    baseline: str
    budget: float


def actspec() -> list[str]:
    """The installed command; where there is none, what it would do."""
    script = shutil.which("actspec", path=str(Path(sys.executable).parent))
    return [script] if script else [sys.executable, "-c", CALL]


def cases(folder: str) -> list[Case]:
    """What is measured; compiled files go below `folder`."""
    spec, tool = str(SPEC), actspec()
    return [
        Case("validate", [*tool, "validate", spec], "import yaml; from pydantic import BaseModel", 2.5),
        Case("compile", [*tool, "compile", spec, "-o", folder], "import mujoco, pydantic", 2.0),
    ]


def seconds(command: list[str], environment: dict[str, str]) -> float:
    """Processor time of one fresh process [s]: unlike wall time it does not grow with what else the machine does.

    Raises:
        RuntimeError: it failed.
    """
    start = _spent()
    done = subprocess.run(command, env=environment, cwd=ROOT, capture_output=True, text=True, check=False)
    taken = _spent() - start
    if done.returncode:
        raise RuntimeError(f"{' '.join(command[1:4])} exited {done.returncode}:\n{done.stderr}")
    return taken


def _spent() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def measure(runs: int) -> dict[str, Any]:
    """Run everything in turn, after one round that warms the caches.

    Returns: Facts of the machine and, for each case, the times [s] and their ratio.
    """
    environment = {**os.environ, "NO_COLOR": "1"}
    with tempfile.TemporaryDirectory() as folder:
        todo = cases(folder)
        times: dict[str, list[float]] = {}
        load = os.getloadavg()[0] if hasattr(os, "getloadavg") else None
        for run in range(runs + 1):
            for case in todo:
                for key, command in (
                    (f"{case.name} baseline", [sys.executable, "-c", case.baseline]),
                    (case.name, case.command),
                ):
                    taken = seconds(command, environment)
                    if run:
                        times.setdefault(key, []).append(taken)
        rows = [_row(case, times[case.name], times[f"{case.name} baseline"]) for case in todo]
    return {"format": "actspec-benchmark-startup/1", "machine": machine(load), "runs": runs, "cases": rows}


def _row(case: Case, own: list[float], baseline: list[float]) -> dict[str, Any]:
    ratio = statistics.median(own) / statistics.median(baseline)
    return {
        "name": case.name,
        "baseline_code": case.baseline,
        "seconds": own,
        "baseline_seconds": baseline,
        "ratio": ratio,
        "budget": case.budget,
        "ok": ratio <= case.budget,
    }


def machine(load: float | None) -> dict[str, Any]:
    """What the figures depend on; nothing that names the machine.

    Args:
        load: Load average of the last minute, before the measurement.
    """
    packages = ("mujoco", "numpy", "pydantic", "pyyaml")
    return {
        "cores": os.cpu_count(),
        "system": platform.system(),
        "architecture": platform.machine(),
        "python": platform.python_version(),
        "packages": {name: version(name) for name in packages},
        "load": load,
    }


def table(result: dict[str, Any]) -> str:
    """The result as Markdown."""
    facts = result["machine"]
    load = "unknown" if facts["load"] is None else f"{facts['load']:.1f}"
    lines = [
        f"{facts['cores']} cores, {facts['system']} {facts['architecture']}, Python {facts['python']}, "
        + ", ".join(f"{name} {number}" for name, number in facts["packages"].items())
        + f"; load {load}; {result['runs']} alternating runs",
        "",
        "| | median [ms] | quartiles [ms] | ratio | budget |",
        "|---|---:|---:|---:|---:|",
    ]
    for row in result["cases"]:
        verdict = f"**{row['ratio']:.2f}**" if row["ok"] else f"**{row['ratio']:.2f}, over**"
        lines.append(f"| `{row['baseline_code']}` | {_figures(row['baseline_seconds'])} | 1 | |")
        lines.append(
            f"| `actspec {row['name']}` | {_figures(row['seconds'])} | {verdict} | {row['budget']:g} |"
        )
    return "\n".join(lines)


def _figures(times: list[float]) -> str:
    low, middle, high = statistics.quantiles(times, n=4)
    return f"{middle * 1e3:.0f} | {low * 1e3:.0f} to {high * 1e3:.0f}"


def main() -> int:
    """Measure and print; exit 1 when a ratio is over its budget."""
    parser = argparse.ArgumentParser(description="Measure actspec's start-up against bare imports.")
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
