"""What an imported spec compiles to: the kinds of file that it was imported from."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from actspec.diagnostics import listed, one_line
from actspec.draft.combine import Combined
from actspec.draft.sources import Reading
from actspec.draft.text import scalar
from actspec.ir import Command, Level
from actspec.readings.artifact import FileKind, Framework
from actspec.readings.config_figures import control_of_group
from actspec.readings.versions import Versions
from actspec.simulators import DEFAULT_VERSIONS

_STACKS = {
    Framework.ISAACLAB: "isaaclab",
    Framework.LEGGED_GYM: "isaaclab",
    Framework.MJLAB: "mjlab",
}
"""Where a configuration goes. legged_gym's own simulator is no more; its heirs train in Isaac Lab."""


def targets_of(
    readings: Sequence[Reading], combined: Combined, versions: Versions
) -> tuple[tuple[str, str, str], ...]:
    """Name, flow mapping and remark of each target.

    MuJoCo is among them for an MJCF, and for a URDF whose gains are known: without gains nothing drives its joints.

    Args:
        readings: The files.
        combined: What they say.
        versions: What they are meant for; what is not said is the default.
    """
    return tuple(_targets(readings, combined, versions))


def _targets(
    readings: Sequence[Reading], combined: Combined, versions: Versions
) -> Iterator[tuple[str, str, str]]:
    kinds = [reading.kind for reading in readings]
    stacks = dict.fromkeys(_STACKS[r.framework] for r in readings if r.framework in _STACKS)
    model = combined.model
    if model is not None and (model.kind is FileKind.MJCF or _has_gains(combined)):
        yield "mujoco", _mapping({"version": versions.mujoco or DEFAULT_VERSIONS["mujoco"]}), ""
    if model is not None and model.kind is FileKind.URDF:
        yield "urdf", "{}", ""
    if "isaaclab" in stacks:
        implicit, other = _classes(readings)
        options = {
            "version": versions.isaaclab or DEFAULT_VERSIONS["isaaclab"],
            "isaac_sim": versions.isaac_sim,
            "backend": versions.backend,
        }
        told = (
            f"{listed(implicit)} implicit there, becomes explicit as the others" if implicit and other else ""
        )
        yield "isaaclab", _mapping(options, "class: implicit" if implicit and not other else ""), told
    if "mjlab" in stacks:
        yield "mjlab", _mapping({"version": versions.mjlab or DEFAULT_VERSIONS["mjlab"]}), ""
    if FileKind.DEPLOY in kinds:
        yield "deploy", _deploy(readings, combined), ""
    if stacks and any(joint.randomize for joint in combined.actuators.joints):
        yield "randomization", f"{{for: [{', '.join(stacks)}]}}", ""


def _has_gains(combined: Combined) -> bool:
    return all(
        joint.command is Command.EFFORT
        or joint.level is Level.ACTUATOR_NET
        or all(gain is None or gain.known for gain in (joint.kp, joint.kd))
        for joint in combined.actuators.joints
    )


def _classes(readings: Sequence[Reading]) -> tuple[list[str], list[str]]:
    """Groups of Isaac Lab configurations whose drive the solver has, and the others."""
    implicit: list[str] = []
    other: list[str] = []
    for reading in readings:
        config = reading.lifted.artifact.config if reading.lifted.artifact is not None else None
        if config is None or config.framework is not Framework.ISAACLAB:
            continue
        for group in config.groups:
            solver = control_of_group(config.framework, group) == "implicit"
            (implicit if solver else other).append(one_line(group.name))
    return implicit, other


def _mapping(options: dict[str, str | None], more: str = "") -> str:
    """Options that are set; versions in quotes, because 3.10 would be read as 3.1."""
    parts = [f"{key}: {scalar(text, quoted=True)}" for key, text in options.items() if text]
    return f"{{{', '.join([*parts, more] if more else parts)}}}"


def _deploy(readings: Sequence[Reading], combined: Combined) -> str:
    """The SDK's order of the joints, where the deploy file names exactly those of the spec."""
    managed = {joint.joint for joint in combined.actuators.joints}
    for reading in readings:
        artifact = reading.lifted.artifact
        if reading.kind is not FileKind.DEPLOY or artifact is None or artifact.config is None:
            continue
        # A file that actspec wrote has the model's order in its lists, and the SDK's beside it.
        settings = artifact.config.settings
        order = settings.get("sdk_order", settings.get("joint_order"))
        entries = order.value if order is not None and isinstance(order.value, tuple) else ()
        names = [str(name) for name in entries if name is not None]
        if len(names) == len(managed) and set(names) == managed:
            written = ("null" if name is None else scalar(str(name)) for name in entries)
            return f"{{joint_order: [{', '.join(written)}]}}"
    return "{}"
