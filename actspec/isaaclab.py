"""Live Isaac Lab objects from a spec, where Isaac Lab is installed and its simulator has been started.

from actspec.isaaclab import actuators
ArticulationCfg(spawn=..., actuators=actuators("robots/a1.yaml"))

and logs of a running environment, `recorder`.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from importlib.machinery import ModuleSpec
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from actspec.recorder import EnvironmentRecorder
    from actspec.spec.validate import Spec
    from actspec.targets.base import TargetOptions

__all__ = ["actuators", "module", "recorder"]


def actuators(path: str | os.PathLike[str], *, target: str | None = None) -> dict[str, Any]:
    """A spec's actuators as Isaac Lab's cfgs: what `ArticulationCfg(actuators=...)` takes.

    The module that `actspec compile` writes is made for the installed Isaac Lab and run in memory; no file is
    written, and nothing but that text is executed. The class is that of the spec's isaaclab target. The Isaac
    Sim version, which decides what friction means, is that of the installed `isaacsim` distribution. A simulator
    that was not installed by pip has no metadata: then it is the target's `isaac_sim`, where the target is for
    the installed Isaac Lab version, else the newest that this version runs on.

    Args:
        path: The spec.
        target: Name of the spec's target, where it has several for Isaac Lab; default: the one for the
            installed version.

    Returns: cfg by name of the group.

    Raises:
        ModuleNotFoundError: Isaac Lab is not installed, or its simulator has not been started.
        ValueError: the spec has no such target for Isaac Lab, or several and none is named.
        ActspecError: the spec does not compile, or actspec does not know the installed Isaac Lab or Isaac Sim.
    """
    names = module(path, target=target)
    return next(value for name, value in names.items() if name.endswith("_ACTUATORS"))


def module(path: str | os.PathLike[str], *, target: str | None = None) -> dict[str, Any]:
    """Everything that the emitted module defines: the dict of cfgs, and the robot's own class for `class: custom`.

    Args:
        path: The spec.
        target: As in `actuators`.

    Returns: value by name.

    Raises: as `actuators`.
    """
    from actspec.api import compile as compile_spec
    from actspec.api import load
    from actspec.live import find_package, network_files, run_module

    version = _installed_release(find_package("isaaclab", "install Isaac Lab"))
    spec = load(path)
    compiled = compile_spec(spec, targets=[_options(spec, version, target)])
    names = run_module(
        compiled.emissions[0].files[0], path, "isaaclab", "start the simulator first, with its AppLauncher"
    )
    # The text looks for networks beside itself, and it is nowhere: the spec's own files are the same.
    files = network_files(compiled)
    for name, value in names.items():
        for cfg in value.values() if name.endswith("_ACTUATORS") else ():
            if hasattr(cfg, "network_file"):
                cfg.network_file = files[os.path.basename(cfg.network_file)]
    return names


def recorder(
    env: Any, *, environment: int = 0, entity: str = "robot", slides: Sequence[str] = ()
) -> EnvironmentRecorder:
    """A recorder of one of an environment's robots: `add()` after `reset()` and after each `step()`, then `save(path)`.

    The torque is `applied_torque`: of explicit actuators what their model gives, of implicit ones Isaac Lab's own
    estimate of what PhysX applies.

    Args:
        env: A `ManagerBasedRLEnv` or `DirectRLEnv`, wrapped or not.
        environment: Which of them.
        entity: Name of the robot in the scene; of a `DirectRLEnv` as it was added to `scene.articulations`.
        slides: Its joints that are slides, in m and N.
    """
    from actspec.recorder import of_scene

    return of_scene(env, "applied_torque", environment=environment, entity=entity, slides=slides)


def _options(spec: Spec, version: str, target: str | None) -> TargetOptions:
    """The target's options for what is installed."""
    from actspec.diagnostics import Collector
    from actspec.live import distribution_version
    from actspec.simulators import newest_known, text_of
    from actspec.simulators.isaaclab import RELEASES
    from actspec.spec.models import IsaacLabTarget
    from actspec.targets.choose import choose_targets

    name = _target(spec, version, target)
    (options,) = choose_targets(spec, [f"{name}=={version}"], None, False, Collector())
    if name in spec.model.targets and _stated_release(spec, name) != version:
        # These go with the version that the spec states.
        given = options.of(IsaacLabTarget)
        options = replace(options, given=given.model_copy(update={"isaac_sim": None, "backend": None}))
    sim = distribution_version("isaacsim")
    if sim is None:
        return options
    runs_on = {text_of(release): row.sims for release, row in RELEASES.items()}.get(version)
    # Its place in the spec is not where this one comes from.
    sim = newest_known(sim, runs_on) if runs_on else sim
    given = options.of(IsaacLabTarget).model_copy(update={"isaac_sim": sim})
    return replace(options, given=given, spans={})


def _target(spec: Spec, version: str, asked: str | None) -> str:
    """Name of the target to compile.

    Raises:
        ValueError: see `actuators`.
    """
    names = [name for name, entry in spec.model.targets.items() if (entry.target or name) == "isaaclab"]
    if asked is not None:
        if asked not in names:
            raise ValueError(f"the spec has no isaaclab target {asked!r}, got {', '.join(names) or 'none'}")
        return asked
    if len(names) > 1:
        names = [name for name in names if _stated_release(spec, name) == version] or names
    if len(names) > 1:
        raise ValueError(f"the spec has several isaaclab targets, {', '.join(names)}: name one with `target`")
    return names[0] if names else "isaaclab"


def _stated_release(spec: Spec, name: str) -> str:
    """The version that the spec's target is for."""
    from actspec.simulators import DEFAULT_VERSIONS, newest_known
    from actspec.simulators.isaaclab import RELEASES

    return newest_known(spec.model.targets[name].version or DEFAULT_VERSIONS["isaaclab"], tuple(RELEASES))


def _installed_release(package: ModuleSpec) -> str:
    """The installed Isaac Lab, as a version to compile for.

    Raises:
        ModuleNotFoundError: nothing tells its version.
    """
    from actspec.live import distribution_version
    from actspec.simulators import newest_known
    from actspec.simulators.isaaclab import RELEASES

    version = _checkout_version(package) or distribution_version("isaaclab")
    if version is None:
        raise ModuleNotFoundError(
            "the version of Isaac Lab is unknown: install it with pip, or from its repository",
            name="isaaclab",
        )
    return newest_known(version, tuple(RELEASES))


def _checkout_version(package: ModuleSpec) -> str | None:
    """The release of a checkout that the package was installed from; None for a wheel.

    In a checkout the metadata has the version of the package alone (0.54.2 in Isaac Lab 2.3.2); the release is
    in the file VERSION at its root, with the package in source/isaaclab/isaaclab.
    """
    if package.origin is None:
        return None
    folder = Path(package.origin).resolve().parent
    if folder.parts[-3:] != ("source", "isaaclab", "isaaclab"):
        return None
    try:
        return (folder.parents[2] / "VERSION").read_text(encoding="utf-8").strip()
    except (OSError, UnicodeDecodeError):
        return None
