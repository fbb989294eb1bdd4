"""What the checks of numbers report of published robots, and the extremes that their bounds stand beside.

    python benchmarks/plausible.py FOLDER... [--extremes]

Every MJCF and URDF below the folders is imported by `actspec import`, and every spec (`.yaml`) taken as it is; all are
resolved, and what `actspec.spec.plausible` reports is printed. Exit code 1: something was reported.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import math
import sys
import tempfile
from collections import Counter, defaultdict
from collections.abc import Iterator
from pathlib import Path

from actspec import api
from actspec.cli.main import main as actspec
from actspec.diagnostics import ActspecError
from actspec.ir import ActuatorSet, JointActuator, JointKind, Origin, Quantity
from actspec.spec.plausible import BY_CODE
from actspec.spec.plausible.armatures import SMALL_LINK
from actspec.spec.plausible.servos import STIFF_LINK

ENDINGS = (".xml", ".urdf", ".yaml")


def files(folders: list[Path]) -> Iterator[Path]:
    """Every file that may be a robot or a spec, each content once."""
    seen = set()
    for folder in folders:
        for path in [folder] if folder.is_file() else sorted(folder.rglob("*")):
            if path.suffix not in ENDINGS or not path.is_file():
                continue
            data = path.read_bytes()
            if data not in seen and (path.suffix != ".yaml" or b"\nactspec:" in data):
                seen.add(data)
                yield path


def spec_of(path: Path, folder: Path) -> Path | None:
    """The spec of a file: itself, or its import; None where it is no robot."""
    if path.suffix == ".yaml":
        return path
    spec = folder / f"{len(list(folder.iterdir()))}.yaml"
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        return spec if actspec(["import", str(path), "-o", str(spec)]) == 0 else None


def known(quantity: Quantity | None) -> float | None:
    """A number that a spec or a file states."""
    return None if quantity is None or quantity.origin is Origin.DEFAULT else quantity.value


def figures(joint: JointActuator) -> Iterator[tuple[str, float]]:
    """What the bounds are about, of one hinge."""
    limit, kp, kd = known(joint.effort_limit), known(joint.kp), known(joint.kd)
    coulomb, armature = known(joint.friction_coulomb), known(joint.armature)
    viscous, scale = known(joint.friction_viscous) or 0.0, known(joint.action_scale)
    speed = known(joint.no_load_speed if joint.curve is None else joint.curve.no_load_speed)
    held, pose = joint.inertia_held, joint.default_position
    if coulomb and limit:
        yield "dry friction / limit", coulomb / limit
    if viscous and limit and speed:
        yield "viscous friction x no-load speed / limit", viscous * speed / limit
    if armature and limit:
        yield "limit / armature [rad/s^2]", limit / armature
    if armature and held is not None and held.high - armature >= SMALL_LINK:
        yield "armature / links", armature / (held.high - armature)
    if kp and kd:
        yield "kd / kp [s]", kd / kp
    if kp and limit:
        yield "limit / kp [rad]", limit / kp
    if kp and held is not None and held.reference > 0.0:
        frequency = math.sqrt(kp / held.reference)
        yield "natural frequency [rad/s]", frequency
        if held.reference >= STIFF_LINK:
            yield f"natural frequency from {STIFF_LINK:g} kg*m^2 on [rad/s]", frequency
            if limit and limit / kp > 10.0:
                yield "natural frequency, limit / kp above 10 rad [rad/s]", frequency
            if limit and limit / kp < 0.06:
                yield "natural frequency, limit / kp below 0.06 rad [rad/s]", frequency
        if kd:
            yield "damping ratio", (kd + viscous) / (2.0 * math.sqrt(kp * held.reference))
    if pose.origin is Origin.AUTHORED and pose.value is not None and joint.position_range is not None:
        yield (
            "pose beyond the range [rad]",
            max(joint.position_range[0] - pose.value, pose.value - joint.position_range[1]),
        )
    if scale and joint.position_range is not None:
        yield "action scale / range", scale / (joint.position_range[1] - joint.position_range[0])
    if scale and kp and limit:
        yield "kp x action scale / limit", kp * scale / limit


def main() -> int:
    """Import, resolve, print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", nargs="+", type=Path)
    parser.add_argument("--extremes", action="store_true", help="least and largest of each figure")
    arguments = parser.parse_args()
    counts: Counter[str] = Counter()
    extremes: dict[str, list[tuple[float, str]]] = defaultdict(list)
    for path in files(arguments.folder):
        with tempfile.TemporaryDirectory() as folder:
            spec = spec_of(path, Path(folder))
            if spec is None:
                counts["no robot"] += 1
                continue
            actuators: ActuatorSet | None = None
            try:
                actuators = api.resolve(spec)
                found = actuators.diagnostics
            except ActspecError as err:
                found = err.diagnostics
        counts["resolved" if actuators is not None else "not resolved"] += 1
        doubts = [item for item in found if item.code in BY_CODE]
        counts["reported"] += bool(doubts)
        for item in doubts:
            print(f"{path}: {item.code} [{item.severity.value}] {item.where}: {item.message}")
        for joint in actuators.joints if actuators is not None else ():
            if joint.kind is JointKind.HINGE:
                for name, value in figures(joint):
                    extremes[name].append((value, f"{path.parent.name}/{path.name} {joint.joint}"))
    if arguments.extremes:
        for name, values in extremes.items():
            least, most = min(values), max(values)
            print(f"{name}: {least[0]:.4g} ({least[1]}) to {most[0]:.4g} ({most[1]}), {len(values)} joints")
    print(", ".join(f"{count} {name}" for name, count in sorted(counts.items())))
    return 1 if counts["reported"] else 0


if __name__ == "__main__":
    sys.exit(main())
