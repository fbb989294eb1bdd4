"""What is folded from the robots of Isaac Lab and mjlab equals what Python makes of them when it executes them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
import yaml

from actspec.readings.artifact import ActuatorGroup, FileKind, RobotConfig
from actspec.readings.deploy import read_deploy
from actspec.readings.python.read import read_python
from tests.frameworks.prepare import Frameworks

PROBE = Path(__file__).with_name("python_reader_probe.py")
YAML = str(Path(yaml.__file__).parent)

RTOL = 1e-12
"""Double precision; the order of a product may differ by a rounding or two."""

MJLAB = ("unitree_go1.go1_constants", "unitree_g1.g1_constants", "i2rt_yam.yam_constants")
ISAACLAB = ("2.2.0", "2.3.2.post1")
NOT_HERE = frozenset({"arl_robot_1.py"})
"""A multirotor of thrusters, which need the simulator; it has no joint actuators."""


def plain(value: object) -> object:
    """As JSON has it."""
    if isinstance(value, tuple):
        return [plain(one) for one in value]
    if isinstance(value, Mapping):
        return {key: plain(one) for key, one in value.items()}
    return value


def same(mine: object, real: object) -> bool:
    """Equal, numbers within RTOL; a name in a path stands for what only the simulator knows."""
    if isinstance(mine, dict) and isinstance(real, dict):
        return list(mine) == list(real) and all(same(mine[key], real[key]) for key in mine)
    if isinstance(mine, list) and isinstance(real, list):
        return len(mine) == len(real) and all(map(same, mine, real))
    if isinstance(mine, (int, float)) and isinstance(real, (int, float)):
        return mine == pytest.approx(real, rel=RTOL, abs=0.0)
    if isinstance(mine, str) and isinstance(real, str) and mine.startswith("{"):
        return real.endswith(mine.partition("}")[2])
    return mine == real


def wrong(mine: ActuatorGroup, real: Mapping[str, Any]) -> list[str]:
    """Where a group that was read differs from the executed one; classes are named in a way of the file's own."""
    found = []
    joints = [real["joints"]] if isinstance(real["joints"], str) else real["joints"]
    if mine.cls != real["class"] or list(mine.joints or ()) != joints:
        found.append(f"{mine.cls} of {mine.joints}")
    for name, (value, default) in real["fields"].items():
        setting = mine.settings.get(name)
        if setting is None:
            # Not written: the class's own.
            if value != default and name != "class_type":
                found.append(f"{name}: not read, really {value}")
        elif name in ("class_type", "transmission_type"):
            continue
        elif setting.unknown is not None or not same(plain(setting.value), value):
            found.append(f"{name}: {setting.value} ({setting.unknown}), really {value}")
    found.extend(
        f"{name}: the class has no such field" for name in mine.settings if name not in real["fields"]
    )
    return found


def compared(config: RobotConfig, real: Mapping[str, Any], keyed: bool) -> list[str]:
    """Where a robot that was read differs from the executed one."""
    found = []
    if len(config.groups) != len(real["groups"]):
        found.append(f"{len(config.groups)} groups, really {len(real['groups'])}")
    for mine, (key, group) in zip(config.groups, real["groups"].items(), strict=False):
        if keyed and mine.name != key:
            found.append(f"{mine.name}, really {key}")
        found.extend(f"{mine.name}.{one}" for one in wrong(mine, group))
    for name, default in (("default_position", {".*": 0.0}), ("soft_joint_pos_limit_factor", 1.0)):
        setting = config.settings.get(name)
        value = default if setting is None else plain(setting.value)
        if not same(value, real[name]):
            found.append(f"{name}: {value}, really {real[name]}")
    return found


def differences(answer: Mapping[str, Any], keyed: bool) -> tuple[list[str], int]:
    """All differences of all modules, and how many groups were compared."""
    found, groups = [], 0
    for module in answer.values():
        reading = read_python(module["file"])
        assert reading.reason is None, reading.reason
        configs = {artifact.name: artifact.config for artifact in reading.artifacts if artifact.config}
        for name, real in module["robots"].items():
            config = configs.get(name)
            if config is None:
                found.append(f"{name}: not read")
                continue
            groups += len(config.groups)
            found.extend(f"{name}: {one}" for one in compared(config, real, keyed))
            found.extend(f"run of {name}: {one}" for one in compared(run_of(real["run"]), real, keyed))
    return found, groups


def run_of(text: str) -> RobotConfig:
    """What is read of the file that a training writes."""
    data = text.encode()
    (artifact,) = read_deploy("env.yaml", data).artifacts
    assert artifact.config is not None and artifact.kind is FileKind.CFG
    assert artifact.config.physics_dt == 0.005 and artifact.config.settings["decimation"].number == 4.0
    return artifact.config


def test_mjlab_robots(frameworks: Frameworks) -> None:
    """Go1, G1 and YAM: 15 groups whose gains are computed from rotor inertias, one of them by a comprehension."""
    modules = [f"mjlab.asset_zoo.robots.{name}" for name in MJLAB]
    job = {"framework": "mjlab", "modules": modules, "yaml": YAML}
    answer = frameworks.run_probe(PROBE, job).said
    # 2 of the Go1, 6 of the G1, 7 of the YAM.
    found, groups = differences(answer, keyed=False)
    assert not found, "\n".join(found)
    assert groups == 15


@pytest.mark.parametrize("version", ISAACLAB)
def test_isaaclab_robots(frameworks: Frameworks, version: str) -> None:
    """Every robot of a release, with its copies, replacements and later assignments, is read as it is executed."""
    root = frameworks.isaaclab(version).parent
    robots = root / "isaaclab_assets" / "isaaclab_assets" / "robots"
    files = [path.stem for path in sorted(robots.glob("*.py")) if path.name not in {"__init__.py", *NOT_HERE}]
    # The package's __init__ imports every robot, the multirotor too: each is imported by itself.
    job = {
        "framework": "isaaclab",
        "root": str(root),
        "modules": files,
        "robots": str(robots),
        "yaml": YAML,
    }
    found, groups = differences(frameworks.run_probe(PROBE, job).said, keyed=True)
    assert not found, "\n".join(found)
    assert groups > 60
