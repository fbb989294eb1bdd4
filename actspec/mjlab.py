"""Live mjlab objects from a spec, where mjlab is installed.

from actspec.mjlab import articulation
EntityCfg(spec_fn=get_spec, articulation=articulation("robots/a1.yaml"))

what a delta action needs to know of a running environment, `delta_state`, and logs of one, `recorder`.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from actspec.learn.delta.runtime import DeltaAction
    from actspec.recorder import EnvironmentRecorder

__all__ = ["articulation", "delta_state", "module", "recorder"]

_JOINT = {"position": "joint_pos", "velocity": "joint_vel"}
_BASE = {
    "position": "root_link_pos_w",
    "orientation": "root_link_quat_w",
    "linear_velocity": "root_link_lin_vel_w",
    "angular_velocity": "root_link_ang_vel_b",
}
"""Signal of a log to the entity's data: a gyroscope's axes are the base's."""


def articulation(path: str | os.PathLike[str]) -> Any:
    """A spec's actuators as mjlab's `EntityArticulationInfoCfg`.

    The module that `actspec compile` writes is made for the installed mjlab and run in memory; no file is
    written, and nothing but that text is executed. A model with actuators of its own also needs its
    `prepare_spec`: see `module`.

    Args:
        path: The spec.

    Raises:
        ModuleNotFoundError: mjlab is not installed, or lacks what it needs itself.
        ActspecError: the spec does not compile, or actspec does not know the installed mjlab.
    """
    names = module(path)
    return next(value for name, value in names.items() if name.endswith("_ARTICULATION"))


def module(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Everything that the emitted module defines: the articulation, `prepare_spec`, action scales.

    Args:
        path: The spec.

    Returns: value by name.

    Raises: as `articulation`.
    """
    from actspec.api import compile as compile_spec
    from actspec.live import network_files, run_module

    compiled = compile_spec(path, targets=[f"mjlab=={_installed_release()}"])
    names = run_module(compiled.emissions[0].files[0], path, "mjlab")
    # The text looks for networks beside itself, and it is nowhere: the spec's own files are the same.
    files = network_files(compiled)
    for value in names.values():
        cfg = getattr(value, "base_cfg", value)
        if hasattr(cfg, "network_file"):
            cfg.network_file = files[os.path.basename(cfg.network_file)]
    return names


def delta_state(env: Any, delta: DeltaAction, entity: str = "robot") -> Callable[[], Any]:
    """What a delta action sees of a running environment, for `delta.wrap(env, state=...)`.

    Args:
        env: A `ManagerBasedRlEnv`, or a wrapper of one; anything whose `scene` has the entity.
        delta: The delta action.
        entity: Name of the robot in the scene.

    Returns: A function to the columns `delta.measured`, shape (envs, n_column), on the environment's device.

    Raises:
        ValueError: the entity has no joint of a column's name.
    """
    from actspec.laws.arrays import array_namespace

    robot = getattr(env, "unwrapped", env).scene[entity]
    names = list(robot.joint_names)
    columns: list[tuple[str, int]] = []
    for column in delta.measured:
        rest, _, last = column.rpartition(".")
        owner, _, signal = rest.rpartition(".")
        if owner == "base" and signal in _BASE:
            columns.append((_BASE[signal], ("wxyz" if signal == "orientation" else "xyz").index(last)))
        elif rest in names:
            columns.append((_JOINT[last], names.index(rest)))
        else:
            raise ValueError(f"the entity {entity!r} has no joint {rest!r}; its joints are {names}")

    def state() -> Any:
        data = {name: getattr(robot.data, name) for name, _ in columns}
        parts = [data[name][:, k] for name, k in columns]
        return array_namespace(parts[0]).stack(parts, -1)

    return state


def recorder(
    env: Any, *, environment: int = 0, entity: str = "robot", slides: Sequence[str] = ()
) -> EnvironmentRecorder:
    """A recorder of one of an environment's robots: `add()` after `reset()` and after each `step()`, then `save(path)`.

    Args:
        env: mjlab's environment, wrapped or not.
        environment: Which of them.
        entity: Name of the robot in the scene.
        slides: Its joints that are slides, in m and N.
    """
    from actspec.recorder import of_scene

    return of_scene(env, "qfrc_actuator", environment=environment, entity=entity, slides=slides)


def _installed_release() -> str:
    """The installed mjlab, as a version to compile for."""
    from actspec.live import distribution_version, find_package
    from actspec.simulators import newest_known
    from actspec.simulators.mjlab import RELEASES

    find_package("mjlab", "pip install mjlab")
    version = distribution_version("mjlab")
    if version is None:
        raise ModuleNotFoundError("the version of mjlab is unknown: install it with pip", name="mjlab")
    return newest_known(version, tuple(RELEASES))
