"""The table of known robots, made of the specs that ship and of `robots/limits`."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import yaml

from actspec import api
from actspec.ir import ActuatorSet, JointActuator, Quantity
from actspec.readings.called import telling

ROBOTS = Path(__file__).parents[2] / "robots"
TABLE = ROBOTS / "known.json"
MAKERS = (
    *(f"Unitree's URDF of the {robot}" for robot in ("A1", "Go1", "Go2", "H1", "G1")),
    "Unitree's URDFs of the G1",
    # Unitree's motor specifications; its URDFs of the G1 have the same.
    "mjlab 1.6.0, Unitree G1 constants",
)
"""How titles of sources begin that are the maker's own."""


def _with_others(row: dict[str, Any], limits: dict[float, list[str]]) -> list[dict[str, Any]]:
    """A row, or one for each of its joints that have other limits too."""
    groups: dict[tuple[float, ...], list[str]] = {}
    for joint in row["joints"]:
        also = tuple(float(limit) for limit, joints in limits.items() if joint in joints)
        groups.setdefault(also, []).append(joint)
    return [
        {**row, "joints": joints, **({"also": list(also)} if also else {})} for also, joints in groups.items()
    ]


def _faster(
    row: dict[str, Any], faster: dict[float, dict[str, Any]], sources: dict[str, Any]
) -> Iterator[dict[str, Any]]:
    """A row, and one for those of its joints to which another source gives a larger speed."""
    rest = row["joints"]
    for speed, other in faster.items():
        mine = [joint for joint in rest if joint in other["joints"]]
        rest = [joint for joint in rest if joint not in mine]
        if mine:
            # The torque of the robot's own source, the speed of the other one.
            own = row.get("sources", {})
            titles = {**own, "speed": _title(sources[other["source"]])}
            slower = {str(row["speed"]): own.get("speed", row["source"])} if row.get("speed") else {}
            more = {"slower": slower} if slower else {}
            yield {**row, "joints": mine, "speed": speed, **more, "sources": titles}
    if rest:
        yield {**row, "joints": rest}


def table() -> str:
    """The text of `robots/known.json`."""
    published: dict[str, dict[str, Any]] = {}
    for path in sorted((ROBOTS / "limits").glob("*.yaml")):
        for section, entries in yaml.safe_load(path.read_text(encoding="utf-8")).items():
            assert published.setdefault(section, {}).keys().isdisjoint(entries), (path, section)
            published[section] |= entries
    robots: dict[str, dict[str, Any]] = {}
    models: set[str] = set()
    for path in sorted(ROBOTS.glob("*.yaml")):
        spec = api.load(path)
        if spec.model.robot.model in models:
            # Other gains of the same robot.
            continue
        models.add(spec.model.robot.model)
        variants = spec.model.variants
        for variant in (None, *sorted(variants)):
            actuators = api.resolve(spec if variant is None else f"{path}#{variant}")
            entry = robots.setdefault(
                actuators.robot, {"words": sorted(telling(actuators.robot)), "variants": {}}
            )
            rows = list(_groups(actuators))
            # A variant of other gains is the same robot.
            if rows not in entry["variants"].values():
                entry["variants"][actuators.variant or ""] = rows
    for name, variants in published["variants"].items():
        for variant, more in variants.items():
            robots[name]["variants"][variant] = list(_changed(robots[name]["variants"], more, published))
    for name, arm in published["robots"].items():
        if "either" in arm:
            variants = {size: robots[other]["variants"][""] for size, other in arm["either"].items()}
            robots[name] = {key: arm[key] for key in ("words", "prefixes", "spelt", "former")} | {
                "variants": variants
            }
            continue
        source = _title(published["sources"][arm["source"]])
        speeds = {joint: speed for speed, joints in arm.get("speeds", {}).items() for joint in joints}
        groups: list[dict[str, Any]] = []
        for limit, joints in arm["limits"].items():
            for speed in dict.fromkeys(speeds.get(joint) for joint in joints):
                row = {
                    "joints": [joint for joint in joints if speeds.get(joint) == speed],
                    "effort": float(limit),
                }
                if speed is not None:
                    row["velocity"] = float(f"{math.radians(speed):.9g}")
                groups.append({**row, "source": source, "maker": True})
        robots[name] = {"words": arm["words"], "variants": {"": groups}}
        robots[name] |= {key: arm[key] for key in ("with", "prefixes", "spelt", "former") if key in arm}
    for name, limits in published["also"].items():
        for rows in robots[name]["variants"].values():
            rows[:] = [each for row in rows for each in _with_others(row, limits)]
    for name, faster in published["also_speeds"].items():
        for rows in robots[name]["variants"].values():
            rows[:] = [each for row in rows for each in _faster(row, faster, published["sources"])]
    for name, others in published["armatures"].items():
        robots[name]["armatures"] = {
            str(figure): _title(published["sources"][source]) for figure, source in others.items()
        }
    lines = []
    for name, entry in sorted(robots.items()):
        rows = [
            f'      "{variant}": [\n' + ",\n".join(f"        {json.dumps(row)}" for row in rows) + "\n      ]"
            for variant, rows in sorted(entry["variants"].items())
        ]
        head = "".join(
            f'    "{key}": {json.dumps(entry[key])},\n'
            for key in ("words", "with", "prefixes", "spelt", "former", "armatures")
            if key in entry
        )
        lines.append(f'  "{name}": {{\n{head}    "variants": {{\n' + ",\n".join(rows) + "\n    }\n  }")
    return "{\n" + ",\n".join(lines) + "\n}\n"


def _groups(actuators: ActuatorSet) -> Iterator[dict[str, Any]]:
    titles = {source.key: source.title for source in actuators.sources}
    found: dict[tuple[float | None, ...], list[JointActuator]] = {}
    for joint in actuators.joints:
        speed = max((_value(q) or 0.0 for q in _speeds(joint)), default=None)
        key = (_value(_largest(joint)), _value(joint.armature), speed, joint.gear)
        found.setdefault(key, []).append(joint)
    for (effort, armature, speed, gear), joints in found.items():
        row: dict[str, Any] = {"joints": [joint.joint for joint in joints], "effort": effort}
        if armature:
            row["armature"] = armature
        if speed:
            row["speed"] = speed
        if gear:
            row["gear"] = float(f"{gear:.9g}")
        row["source"] = titles[str(_largest(joints[0]).source)]
        one = joints[0]
        of_other = {"armature": one.armature, "speed": max(_speeds(one), key=_figure, default=None)}
        others = {name: titles[str(q.source)] for name, q in of_other.items() if q and row.get(name)}
        if others := {name: title for name, title in others.items() if title != row["source"]}:
            row["sources"] = others
        stated = (joints[0].effort_limit, joints[0].peak_torque, joints[0].stall_torque)
        alike = (q for q in stated if q is not None and q.value == effort and q.source is not None)
        if any(titles.get(str(q.source), "").startswith(MAKERS) for q in alike):
            row["maker"] = True
        yield row


def _speeds(joint: JointActuator) -> list[Quantity]:
    """Its speed limit and the end of its torque-speed line, where they are known."""
    return [
        q for q in (joint.velocity_limit, joint.no_load_speed) if q and q.value and math.isfinite(q.value)
    ]


def _figure(quantity: Quantity) -> float:
    return quantity.require()


def _largest(joint: JointActuator) -> Quantity:
    """What its limit, peak or torque-speed line has most; the limit where they are equal."""
    known = [
        q for q in (joint.effort_limit, joint.peak_torque, joint.stall_torque) if q is not None and q.value
    ]
    return max(known, key=lambda quantity: float(f"{quantity.require():.4g}"))


def _changed(
    variants: dict[str, Any], more: dict[str, Any], published: dict[str, Any]
) -> Iterator[dict[str, Any]]:
    """The rows of the spec itself, the joints of a published variant in rows of their own."""
    moved = {joint for joints in more["limits"].values() for joint in joints}
    for row in variants["mode_5"]:
        kept = [joint for joint in row["joints"] if joint not in moved]
        if kept:
            yield {**row, "joints": kept}
    source = _title(published["sources"][more["source"]])
    maker = {"maker": True} if source.startswith(MAKERS) else {}
    for limit, joints in more["limits"].items():
        yield {"joints": joints, "effort": float(limit), "speed": more["speed"], "source": source, **maker}


def _value(quantity: Quantity | None) -> float | None:
    value = None if quantity is None else quantity.value
    return None if value is None else float(f"{value:.9g}")


def _title(source: dict[str, Any]) -> str:
    return str(source["title"])
