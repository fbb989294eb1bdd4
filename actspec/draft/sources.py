"""The files that a spec is imported from, as its `sources` name them, and the targets that it compiles to."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, NamedTuple

from actspec.diagnostics import RobotError, Span, one_line
from actspec.draft.names import one_pattern
from actspec.draft.text import scalar
from actspec.ir import ActuatorSet, AsymmetricCurve, Command, JointActuator, Level, Origin, Quantity, Source
from actspec.lift.lifted import Lifted
from actspec.patterns import PatternError
from actspec.readings.artifact import ActuatorGroup, Artifact, FileKind, Framework, RobotConfig
from actspec.readings.config import control_of_group, is_own_class, selected
from actspec.readings.isaaclab import has_curve
from actspec.readings.versions import Versions, is_native
from actspec.robot.view import NAMELESS, ModelFormat
from actspec.simulators import DEFAULT_VERSIONS
from actspec.units import format_quantity

if TYPE_CHECKING:
    from actspec.draft.combine import Combined

_MOST_RUNS = 4
"""Chosen: more runs of lines than these are told as the first and the last line."""


@dataclass(frozen=True, slots=True)
class RobotReading:
    """One robot as one file has it.

    Attributes:
        lifted: What it says.
        artifact: What that was lifted from.
        includes: Other files that its numbers may stand in.
        reference: The file as the spec is to name it; "": as `path` does.
    """

    lifted: Lifted
    artifact: Artifact
    includes: tuple[str, ...] = ()
    reference: str = ""

    @property
    def kind(self) -> FileKind:
        """What the file is."""
        return self.artifact.kind

    @property
    def path(self) -> str:
        """The file, as the user named it."""
        return self.artifact.path

    @property
    def framework(self) -> Framework | None:
        """Whose conventions a configuration follows; None for a robot file."""
        return None if self.artifact.config is None else self.artifact.config.framework


def robot_name(reading: RobotReading) -> str:
    """What the robot is called, else its file, as a folder may be called: `UNITREE_A1_CFG` is unitree_a1,
    `Cassie.asset_cfg` is Cassie, and the robot of `UnitreeA1FlatEnvCfg` is UnitreeA1."""
    stem = os.path.splitext(os.path.basename(reading.path))[0]
    given = reading.artifact.name
    for text in ("" if given == NAMELESS else given, stem):
        if reading.framework is not None:
            text = re.sub(r"(?<=.)(?:Flat|Rough)?EnvCfg(?:_PLAY)?$", "", text)
            text = re.sub(r"(?<=.)(?:_?(?:ARTICULATION|ROBOT)?_?CFG|\.(?:asset|robot)(?:_cfg)?)$", "", text)
            text = text.lower() if text.isupper() else text
        name = re.sub(r"[^A-Za-z0-9_.-]+", "_", text).strip("_.-")[:60]
        if name:
            return name
    return "robot"


_ENDINGS = {FileKind.MJCF: "mjcf", FileKind.URDF: "urdf", FileKind.CFG: "cfg", FileKind.DEPLOY: "deploy"}
_TITLES = {FileKind.MJCF: "MJCF", FileKind.URDF: "URDF", FileKind.DEPLOY: "deploy file"}
_FRAMEWORKS = {
    Framework.ISAACLAB: "Isaac Lab",
    Framework.MJLAB: "mjlab",
    Framework.LEGGED_GYM: "legged_gym",
}


def source_keys(readings: Sequence[RobotReading]) -> dict[str, str]:
    """File to its key in the spec's `sources`: `a1_mjcf`."""
    keys: dict[str, str] = {}
    for reading in readings:
        if reading.path in keys or reading.kind not in _ENDINGS:
            continue
        ending = _ENDINGS[reading.kind]
        stem = os.path.splitext(os.path.basename(reading.path))[0]
        stem = re.sub(r"[^a-z0-9]+", "_", stem.lower()).strip("_")[:40]
        key = stem if stem.endswith(ending) else f"{stem}_{ending}".strip("_")
        while key in keys.values():
            key += "_2"
        keys[reading.path] = key
    return keys


def keyed(reading: RobotReading, keys: Mapping[str, str]) -> RobotReading:
    """The reading with keys of `sources` in place of files."""
    own = keys.get(reading.path)
    if own is None:
        return reading
    files = dict.fromkeys((reading.path, *reading.includes), own)
    lifted = reading.lifted

    def rekey(quantity: Quantity) -> Quantity:
        if not quantity.known:
            return quantity
        if not math.isfinite(quantity.require()):
            why = (
                "no limit"
                if quantity.value == math.inf
                else f"the file has {format_quantity(quantity.value, '')}"
            )
            return replace(quantity, value=None, origin=Origin.UNKNOWN, note=why)
        place = quantity.span.path if quantity.span is not None else quantity.source
        # A number that another file of the same robot gave it keeps that file's key.
        key = files.get(place or "") or keys.get(place or "") or (own if stated(quantity) else None)
        return replace(quantity, source=key)

    actuators = lifted.actuators
    return replace(
        reading,
        lifted=replace(
            lifted,
            actuators=replace(
                actuators,
                joints=tuple(_named(_mapped(joint, rekey), reading) for joint in actuators.joints),
                physics_dt=rekey(actuators.physics_dt),
                control_dt=None if actuators.control_dt is None else rekey(actuators.control_dt),
            ),
        ),
    )


def _named(joint: JointActuator, reading: RobotReading) -> JointActuator:
    """A joint with the name of its group, where a file has groups: a robot file has names of actuators only."""
    grouped = reading.kind is FileKind.SPEC or reading.framework in (Framework.ISAACLAB, Framework.MJLAB)
    return joint if grouped else replace(joint, group="")


def stated(quantity: Quantity) -> bool:
    """Whether somebody wrote the number, be it a file or its author."""
    return quantity.known and quantity.origin is not Origin.DEFAULT


def _mapped(joint: JointActuator, change: Callable[[Quantity], Quantity]) -> JointActuator:
    """A joint with every quantity changed."""
    changed: dict[str, object] = {
        item.name: change(value)
        for item in fields(joint)
        if isinstance(value := getattr(joint, item.name), Quantity)
    }
    if joint.curve is not None:
        parts = {part.name: change(getattr(joint.curve, part.name)) for part in fields(joint.curve)}
        changed["curve"] = AsymmetricCurve(**parts)
    if joint.delay is not None:
        changed["delay"] = replace(joint.delay, nominal=change(joint.delay.nominal))
    if joint.command_range is not None:
        changed["command_range"] = tuple(change(end) for end in joint.command_range)
    return replace(joint, **changed)  # type: ignore[arg-type]


def sources_of(
    readings: Sequence[RobotReading], keys: Mapping[str, str], sets: Sequence[ActuatorSet]
) -> Iterator[Source]:
    """What the keys stand for."""
    given = set()
    for reading in readings:
        key = keys.get(reading.path)
        if key is None or key in given:
            continue
        given.add(key)
        yield Source(key, _title(reading), page=reading.reference or reading.path)
    for item in (source for actuators in sets for source in actuators.sources):
        if item.key not in given:
            given.add(item.key)
            yield item


def _title(reading: RobotReading) -> str:
    """`UNITREE_A1_CFG in unitree.py, Isaac Lab`; `a1.xml, MJCF`."""
    file = os.path.basename(reading.path)
    if reading.framework in _FRAMEWORKS:
        return f"{one_line(reading.artifact.name)} in {file}, {_FRAMEWORKS[reading.framework]}"
    return f"{file}, {_TITLES[reading.kind]}"


def places(spans: Sequence[Span | None]) -> str:
    """Where something stands, file by file: `go2.xml:82, 90 to 96; unitree.py:41`."""
    files: dict[str, set[int]] = {}
    for span in spans:
        if span is not None:
            files.setdefault(os.path.basename(span.path), set()).update([span.line] if span.line else [])
    return "; ".join(f"{file}:{_lines(sorted(lines))}" if lines else file for file, lines in files.items())


def _lines(lines: Sequence[int]) -> str:
    """`82, 90 to 92, 96`; of many runs only the first and the last line."""
    runs: list[tuple[int, int]] = []
    for line in lines:
        if runs and line == runs[-1][1] + 1:
            runs[-1] = (runs[-1][0], line)
        else:
            runs.append((line, line))
    if len(runs) > _MOST_RUNS:
        runs = [(lines[0], lines[-1])]
    return ", ".join(str(a) if a == b else f"{a} to {b}" if b > a + 1 else f"{a}, {b}" for a, b in runs)


_STACKS = {
    Framework.ISAACLAB: "isaaclab",
    Framework.LEGGED_GYM: "isaaclab",
    Framework.MJLAB: "mjlab",
}
"""Where a configuration goes. legged_gym's own simulator is no more; its heirs train in Isaac Lab."""


class DraftTarget(NamedTuple):
    """A target of a drafted spec.

    Attributes:
        name: Its key.
        value: Its options, as a flow mapping.
        remark: What stands beside it; "" for nothing.
        left_out: Why the robot's files cannot serve it: it is a comment; "" for a target.
    """

    name: str
    value: str
    remark: str = ""
    left_out: str = ""

    def as_fragment(self) -> DraftTarget | None:
        """The target of a robot without a model as what it can be; None for one that is something else."""
        remark = "a fragment to include in the robot's MJCF, which is not named"
        return self._replace(remark=remark, left_out="") if self.left_out == _NO_MODEL else None


_NO_MODEL = "no MJCF or URDF is named; `compile -t mujoco` writes a fragment to include in one"
_NO_URDF = "it is written into the robot's URDF, and none is named"


def targets_of(
    readings: Sequence[RobotReading], combined: Combined, versions: Versions
) -> tuple[DraftTarget, ...]:
    """What a spec of the files is for.

    MuJoCo is among them for an MJCF, and for a URDF whose gains are known: without gains nothing drives its joints.

    Args:
        readings: The files.
        combined: What they say.
        versions: What they are meant for; what is not said is the default.
    """
    return tuple(_targets(readings, combined, versions))


def _targets(
    readings: Sequence[RobotReading], combined: Combined, versions: Versions
) -> Iterator[DraftTarget]:
    kinds = [reading.kind for reading in readings]
    stacks = dict.fromkeys(_STACKS[r.framework] for r in readings if r.framework in _STACKS)
    model = combined.model
    if model is not None:
        served = model.kind is FileKind.MJCF or _has_gains(combined)
        why = _refused(model) or ("" if served else "its servos need kp and kd, which are unknown")
        version = versions.mujoco or DEFAULT_VERSIONS["mujoco"]
        yield DraftTarget("mujoco", _mapping({"version": version}), left_out=why)
    else:
        version = versions.mujoco or DEFAULT_VERSIONS["mujoco"]
        yield DraftTarget("mujoco", _mapping({"version": version}), left_out=_NO_MODEL)
        yield DraftTarget("urdf", "{}", left_out=_NO_URDF)
    if model is not None and model.kind is FileKind.URDF:
        yield DraftTarget("urdf", "{}")
    if "isaaclab" in stacks:
        options = {
            "version": versions.isaaclab or DEFAULT_VERSIONS["isaaclab"],
            "isaac_sim": versions.isaac_sim,
            "backend": versions.backend,
        }
        yield DraftTarget("isaaclab", _mapping(options, _class(readings, combined, versions)))
    if "mjlab" in stacks:
        yield DraftTarget("mjlab", _mapping({"version": versions.mjlab or DEFAULT_VERSIONS["mjlab"]}))
    if FileKind.DEPLOY in kinds:
        yield DraftTarget("deploy", _deploy(readings, combined))
    if stacks and any(joint.randomize for joint in combined.actuators.joints):
        yield DraftTarget("randomization", f"{{for: [{', '.join(stacks)}]}}")


def _refused(model: RobotReading) -> str:
    """Why MuJoCo refuses a URDF with its shapes, which reading leaves out; "" where it does not, or of an MJCF."""
    robot = model.artifact.robot
    if model.kind is not FileKind.URDF or robot is None:
        return ""
    if model.artifact.text_only is not None:
        # It may have been a crash.
        reason, at = model.artifact.text_only, model.artifact.refused_at
    else:
        from actspec.robot.mjspec import compiled_model
        from actspec.robot.xml import parse_document

        try:
            compiled_model(parse_document(robot.files), ModelFormat.URDF, shapes=True)
            return ""
        except RobotError as err:
            reason, at = err.diagnostics[0].message, err.diagnostics[0].span
    place = f"{one_line(os.path.basename(at.path))}:{at.line}: " if at is not None and at.line else ""
    return f"{place}{reason}"


def _has_gains(combined: Combined) -> bool:
    return all(
        joint.command is Command.EFFORT
        or joint.level is Level.ACTUATOR_NET
        or all(gain is None or gain.known for gain in (joint.kp, joint.kd))
        for joint in combined.actuators.joints
    )


def _class(readings: Sequence[RobotReading], combined: Combined, versions: Versions) -> str:
    """The option for the joints that an Isaac Lab configuration drives by the solver, or by a class whose law the stock
    classes do not hold; "" where there are none.
    """
    managed = [joint.joint for joint in combined.actuators.joints]
    chosen: dict[str, str] = {}
    for reading in readings:
        config = reading.artifact.config
        if config is not None and config.framework is Framework.ISAACLAB:
            chosen |= {
                joint: _drive(config, group)
                for group in config.groups  # the last one that selects a joint has it
                for joint, _ in selected(config, group, managed)
            }
    if is_native(versions):
        # 3.0 has its own kernels, and no class beside them.
        chosen = {joint: "" if drive == "custom" else drive for joint, drive in chosen.items()}
    drives = [chosen.get(joint, "") for joint in managed]
    if len(set(drives)) == 1:
        return f"class: {drives[0]}" if drives[0] else ""
    parts = []
    for drive in sorted(set(drives) - {""}):
        wanted = [joint for joint, its in zip(managed, drives, strict=True) if its == drive]
        try:
            parts += [f"{scalar(pattern)}: {drive}" for pattern in one_pattern(wanted, managed)]
        except PatternError:
            # Of a name that no pattern can hold the draft says so.
            return ""
    return f"class: {{{', '.join(parts)}}}" if parts else ""


def _drive(config: RobotConfig, group: ActuatorGroup) -> str:
    """The class of the target that a group's is: `implicit`, `custom`, or "" for the stock class of the level."""
    if control_of_group(config.framework, group) == "implicit":
        return "implicit"
    return "custom" if has_curve(group) or is_own_class(group) else ""


def _mapping(options: dict[str, str | None], more: str = "") -> str:
    """Options that are set; versions in quotes, because 3.10 would be read as 3.1."""
    parts = [f"{key}: {scalar(text, quoted=True)}" for key, text in options.items() if text]
    return f"{{{', '.join([*parts, more] if more else parts)}}}"


def _deploy(readings: Sequence[RobotReading], combined: Combined) -> str:
    """The SDK's order of the joints, where the deploy file names exactly those of the spec."""
    managed = {joint.joint for joint in combined.actuators.joints}
    for reading in readings:
        artifact = reading.artifact
        if reading.kind is not FileKind.DEPLOY or artifact.config is None:
            continue
        # A file that actspec wrote has the model's order in its lists, and the SDK's beside it.
        settings = artifact.config.settings
        order = settings.get("sdk_order", settings.get("joint_order"))
        entries = order.value if order is not None and isinstance(order.value, tuple) else ()
        names = [str(name) for name in entries if name]
        if len(names) == len(managed) and set(names) == managed:
            written = (scalar(str(name)) if name else "null" for name in entries)
            return f"{{joint_order: [{', '.join(written)}]}}"
    return "{}"
