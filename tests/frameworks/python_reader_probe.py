"""Run by `Frameworks.run_probe`: executes the robots that Isaac Lab and mjlab ship, and tells their actuators.

Job:
    framework: isaaclab or mjlab.
    root: folder with `isaaclab` and `isaaclab_assets` (Isaac Lab alone).
    modules: names of modules to import, or of files in the folder `robots` (Isaac Lab).
    yaml: folder of PyYAML, which both frameworks write with.

Answers: module to name of the constant to its robot: `groups`, by key or index, each with its class, joints and
`fields` (name to [value, the class's default]); `default_position`; `soft_joint_pos_limit_factor`; `run`, the YAML that
the framework writes of an environment with the robot.
"""

from __future__ import annotations

import copy
import dataclasses
import importlib
import importlib.util
import json
import sys
import tempfile
import types
from pathlib import Path
from typing import Any

import numpy as np

FOLDER = "{FOLDER}"
"""Where the simulator would say where its assets are."""


class Names(type):
    """A class with any class in it: `Usd.Prim`, `RayCasterCfg.OffsetCfg`."""

    def __getattr__(cls, name: str) -> type:
        if name.startswith("__"):
            raise AttributeError(name)
        made = Names(name, (Recorder,), {})
        setattr(cls, name, made)
        return made


class Recorder:
    """Any cfg of the simulator, which is not here: keeps what it is given."""

    def __init__(self, *args: object, **kwargs: object) -> None:
        self.__dict__.update(kwargs)

    def replace(self, **kwargs: object) -> Recorder:
        made = copy.deepcopy(self)
        made.__dict__.update(kwargs)
        return made

    copy = replace


class Namespace(types.ModuleType):
    """A module of the simulator: each of its names is a class like `Recorder`."""

    def __getattr__(self, name: str) -> type:
        made = Names.__getattr__(Names("module", (Recorder,), {}), name)
        setattr(self, name, made)
        return made


def stand_in(name: str, **content: object) -> types.ModuleType:
    module = Namespace(name)
    module.__dict__.update(content)
    sys.modules[name] = module
    return module


def enable(root: Path) -> None:
    """Make the real actuators, `ArticulationCfg` and robots importable on a machine without Isaac Sim."""
    source = root / "isaaclab" / "isaaclab"
    sys.path[:0] = [str(root / "isaaclab"), str(root / "isaaclab_assets")]
    settings = types.SimpleNamespace(get=lambda key: FOLDER)
    stand_in("carb", settings=types.SimpleNamespace(get_settings=lambda: settings))
    stand_in("omni", __path__=[], client=stand_in("omni.client"))
    stand_in("omni.log", warn=print, info=print, error=print)
    if importlib.util.find_spec("toml") is None:
        import tomllib

        stand_in("toml", load=lambda path: tomllib.loads(Path(path).read_text(encoding="utf-8")))
    for name in ("trimesh", "pxr"):
        if importlib.util.find_spec(name) is None:
            stand_in(name)
    stand_in("isaaclab.sim")
    stand_in("isaaclab.sensors")
    # The packages' own cfg modules, without the simulator that their __init__ imports.
    assets = stand_in("isaaclab.assets", __path__=[str(source / "assets")])
    inner = stand_in("isaaclab.assets.articulation", __path__=[str(source / "assets" / "articulation")])
    stand_in("isaaclab.assets.asset_base")
    stand_in("isaaclab.assets.articulation.articulation")
    cfg = importlib.import_module("isaaclab.assets.articulation.articulation_cfg").ArticulationCfg
    assets.ArticulationCfg = inner.ArticulationCfg = cfg


def plain(value: Any) -> Any:
    """For JSON."""
    if isinstance(value, (list, tuple)):
        return [plain(one) for one in value]
    if isinstance(value, dict):
        return {str(key): plain(one) for key, one in value.items()}
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    return f"<{type(value).__name__}>"


def group(cfg: Any, joints: str) -> dict[str, Any]:
    fields = {}
    for one in dataclasses.fields(cfg):
        default = one.default_factory() if callable(one.default_factory) else one.default
        fields[one.name] = [plain(getattr(cfg, one.name)), plain(default)]
    return {"class": type(cfg).__name__, "joints": plain(fields.pop(joints)[0]), "fields": fields}


def run(write: Any, environment: dict[str, Any]) -> str:
    """What the framework's own `dump_yaml` writes beside a run."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "env.yaml"
        write(path if write.__module__.startswith("mjlab") else str(path), environment)
        return path.read_text(encoding="utf-8")


def isaaclab(module: types.ModuleType) -> dict[str, Any]:
    of_dict = importlib.import_module("isaaclab.utils.dict").class_to_dict
    write = importlib.import_module("isaaclab.utils.io.yaml").dump_yaml
    found = {}
    for name, value in vars(module).items():
        if type(value).__name__ == "ArticulationCfg" and value.spawn is not None:
            actuators = value.actuators.items()
            found[name] = {
                "groups": {key: group(cfg, "joint_names_expr") for key, cfg in actuators},
                "default_position": plain(value.init_state.joint_pos),
                "soft_joint_pos_limit_factor": value.soft_joint_pos_limit_factor,
                "run": run(
                    write, {"scene": {"robot": of_dict(value)}, "sim": {"dt": 0.005}, "decimation": 4}
                ),
            }
    return found


def mjlab(module: types.ModuleType) -> dict[str, Any]:
    from mjlab.utils.os import dump_yaml

    (maker,) = (value for name, value in vars(module).items() if name.endswith("_robot_cfg"))
    entity = maker()
    found = {}
    for name, value in vars(module).items():
        if type(value).__name__ == "EntityArticulationInfoCfg":
            groups = [group(cfg, "target_names_expr") for cfg in value.actuators]
            found[name] = {
                "groups": dict(enumerate(groups)),
                "default_position": plain(entity.init_state.joint_pos),
                "soft_joint_pos_limit_factor": value.soft_joint_pos_limit_factor,
                "run": run(
                    dump_yaml,
                    {
                        "scene": {"entities": {"robot": dataclasses.asdict(entity)}},
                        "sim": {"mujoco": {"timestep": 0.005}},
                        "decimation": 4,
                    },
                ),
            }
    return found


def main() -> None:
    job = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    spec = importlib.util.spec_from_file_location(
        "yaml", f"{job['yaml']}/__init__.py", submodule_search_locations=[job["yaml"]]
    )
    assert spec is not None and spec.loader is not None
    sys.modules["yaml"] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(sys.modules["yaml"])
    if job["framework"] == "isaaclab":
        enable(Path(job["root"]))
    read = {"isaaclab": isaaclab, "mjlab": mjlab}[job["framework"]]
    said = {}
    if "robots" in job:
        stand_in("isaaclab_assets", __path__=[str(Path(job["robots"]).parent)])
        stand_in("isaaclab_assets.robots", __path__=[job["robots"]])
        stand_in("isaaclab_assets.sensors", __path__=[])
        stand_in("isaaclab_assets.sensors.velodyne", VELODYNE_VLP_16_RAYCASTER_CFG=Recorder())
    prefix = "isaaclab_assets.robots." if "robots" in job else ""
    for name in job["modules"]:
        module = importlib.import_module(prefix + name)
        said[name] = {"file": module.__file__, "robots": read(module)}
    Path(sys.argv[3]).write_text(json.dumps(said), encoding="utf-8")
    np.savez(sys.argv[4])


main()
