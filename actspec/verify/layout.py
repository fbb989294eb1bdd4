"""Static agreement of what is no figure of a joint: which joints there are, their orders, steps, classes; of models
what MuJoCo compiles beside the figures, and keyframes."""

from __future__ import annotations

import math
import os
from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import RobotError, Span, listed, one_line
from actspec.files import FAULTS, read_regular
from actspec.ir import ActuatorSet, JointActuator
from actspec.readings.compare import same
from actspec.readings.dynamics import SETTING_NOUNS
from actspec.robot.view import ModelFormat
from actspec.robot.xml import open_document
from actspec.simulate.rollout import PLACES, drivers
from actspec.units import format_number, format_quantity
from actspec.verify.agreement import Row, TargetFiles, alike
from actspec.verify.readback import Figures, FileFigures

if TYPE_CHECKING:
    import mujoco

TOLERANCE = 1e-6
"""Relative difference of equal figures. Source: MuJoCo's own form has six digits; the others have all."""


MAPS = ("order", "index")
"""Blocks of the file whose entries are lists over the joints."""

MOST_BYTES = 8 << 20
"""Chosen: as the audit's reader, which has taken the file before."""

OPTIONS = ("integrator", "disableflags", "enableflags", "disableactuator")
"""Options that change what drives and friction do; those of contacts are the model's own."""

KEYS = ("qpos", "qvel", "act", "ctrl")
"""Arrays of a keyframe: a robot that starts with other controls jumps."""

FOLLOWING = PLACES | {"jnt_group", "actuator_group", "actuator_lengthrange"}
"""Arrays that are places in the model, follow from its bodies, or are shown and no more."""

LIMITED = {
    "jnt_range": "jnt_limited",
    "jnt_actfrcrange": "jnt_actfrclimited",
    "actuator_ctrlrange": "actuator_ctrllimited",
    "actuator_forcerange": "actuator_forcelimited",
    "actuator_actrange": "actuator_actlimited",
}
"""Range to whether it is one: without, a viewer alone reads it."""


def layout_rows(
    target: TargetFiles, actuators: ActuatorSet, fresh: FileFigures, built: FileFigures
) -> Iterator[Row]:
    """Rows of a file's joints, steps, order and settings; see `fields.field_rows`."""
    yield from _missing(target, actuators, fresh, built)
    yield from _settings(target, actuators, fresh, built)
    yield from _order(target, fresh, built)
    yield from _raw(target, actuators, fresh, built)


def driven(joint: str, fresh: FileFigures, built: FileFigures) -> bool:
    """Whether a file has a joint, with a drive where actspec writes one."""
    if joint not in built.figures:
        return joint not in fresh.figures
    return built.controls.get(joint) != "none" or fresh.controls.get(joint) == "none"


def figure_text(value: float | None, unit: str, digits: int = 6) -> str:
    """A figure with its unit; `none` where there is no limit."""
    if value is None:
        return "unknown"
    if math.isinf(value):
        return "none"
    return format_quantity(value, unit, digits)


def _missing(
    target: TargetFiles, actuators: ActuatorSet, fresh: FileFigures, built: FileFigures
) -> Iterator[Row]:
    """Joints that the file does not have, or does not drive, though actspec writes them so."""
    for members in alike(actuators):
        gone = [a for a in members if not driven(a.joint, fresh, built)]
        if gone:
            had = gone[0].joint in built.figures
            what = f"the file does not {'drive' if had else 'have'} the joint"
            yield target.fault("joint", "VFY109", what, actuator=gone[0], joints=len(gone))


def _settings(
    target: TargetFiles, actuators: ActuatorSet, fresh: FileFigures, built: FileFigures
) -> Iterator[Row]:
    """What concerns the whole file: its steps."""
    decimation = None if actuators.decimation is None else float(actuators.decimation)
    spec = {"physics_dt": actuators.physics_dt.value, "decimation": decimation}
    spec["control_dt"] = actuators.control_period
    for name in dict.fromkeys((*fresh.settings, *built.settings)):
        expected = spec.get(name)
        if expected is None:
            expected = fresh.settings.get(name)
        got = built.settings.get(name)
        error = None if expected is None or got is None else abs(got - expected)
        tolerance = TOLERANCE * abs(expected or 0.0)
        ok = error is not None and error <= tolerance
        unit = "" if name == "decimation" else "s"
        asked, said = figure_text(expected, unit), figure_text(got, unit)
        if asked == said:
            # Six digits do not tell them apart: 1/60 s and 0.0166667 s.
            asked, said = figure_text(expected, unit, 12), figure_text(got, unit, 12)
        message = f"the {SETTING_NOUNS.get(name, name)} is {said}, and should be {asked}"
        yield Row(
            *(target.name, "", "", 0, name, unit, error, tolerance, ok, expected, got),
            code=None if ok else "VFY110",
            message="" if ok else message,
        )


def _order(target: TargetFiles, fresh: FileFigures, built: FileFigures) -> Iterator[Row]:
    """The order of the joints, on which policies and deploy code depend."""
    if not fresh.order or set(fresh.order) - set(built.order):
        return
    kept = tuple(name for name in built.order if name in set(fresh.order))
    if kept == fresh.order:
        return
    wrong = next((a, b) for a, b in zip(fresh.order, kept, strict=False) if a != b)
    what = f"the order of the joints differs: {wrong[1]} stands in the place of {wrong[0]}"
    row = target.fault("order", "VFY109", what, joints=len(kept))
    yield replace(row, joint=wrong[0])


def _raw(
    target: TargetFiles, actuators: ActuatorSet, fresh: FileFigures, built: FileFigures
) -> Iterator[Row]:
    """Drives and settings that are no number with a unit: class, network, scales."""
    for members in alike(actuators):
        wrong: dict[str, list[str]] = {}
        for actuator in members:
            joint = actuator.joint
            if joint not in built.figures or not driven(joint, fresh, built):
                continue
            ours, theirs = _written(fresh, joint), _written(built, joint)
            for name in dict.fromkeys((*ours, *theirs)):
                if ours.get(name) != theirs.get(name):
                    wrong.setdefault(name, []).append(joint)
        for name, joints in wrong.items():
            asked, got = (_written(reading, joints[0]).get(name) for reading in (fresh, built))
            what = one_line(f"{name} is {got!r}, and should be {asked!r}")
            first = next(one for one in members if one.joint == joints[0])
            yield target.fault(name, "VFY110", what, actuator=first, joints=len(joints))


def _written(reading: FileFigures, joint: str) -> dict[str, object]:
    return {"drive": reading.controls.get(joint), **reading.raw.get(joint, {})}


def order_rows(target: TargetFiles) -> Iterator[Row]:
    """Rows of each order and each map between two, held to what actspec writes."""
    ours, theirs = (
        _blocks(os.path.join(folder, target.files[0])) for folder in (target.fresh, target.folder)
    )
    for name in dict.fromkeys((*ours, *theirs)):
        asked, got = ours.get(name), theirs.get(name)
        if asked == got:
            yield target.right(name, joints=len(asked or ()))
        else:
            what = one_line(f"{name} differs: {_first_difference(asked, got)}")
            yield target.fault(name, "VFY109", what, joints=len(asked or ()))


def _blocks(path: str) -> dict[str, list[Any]]:
    """Lists of the blocks, by `order.isaac`; those that cannot be read are missing."""
    import yaml

    try:
        data = yaml.load(read_regular(path, MOST_BYTES), Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))
    except (*FAULTS, yaml.YAMLError, RecursionError):
        return {}
    if not isinstance(data, Mapping):
        return {}
    return {
        f"{block}.{name}": value
        for block in MAPS
        if isinstance(data.get(block), Mapping)
        for name, value in data[block].items()
        if isinstance(value, list)
    }


def _first_difference(asked: list[Any] | None, got: list[Any] | None) -> str:
    """The first entry that differs."""
    if asked is None or got is None:
        return "it is missing" if got is None else "actspec writes none"
    if len(asked) != len(got):
        return f"it has {len(got)} entries, and should have {len(asked)}"
    place, (want, have) = next(
        (i, pair) for i, pair in enumerate(zip(asked, got, strict=True)) if pair[0] != pair[1]
    )
    return f"entry {place} is {have!s:.60}, and should be {want!s:.60}"


def compiled_rows(
    target: TargetFiles, actuators: ActuatorSet, figures: Figures, wrong: Collection[str]
) -> Iterator[Row]:
    """Rows of a model that somebody edited, held to the one that actspec writes.

    Args:
        target: The target, whose model MuJoCo takes.
        actuators: What the spec asks for.
        figures: What the file says, for places.
        wrong: Joints of which a figure is reported to be wrong already.
    """
    ours, theirs = (_compiled(f"{folder}/{target.files[0]}") for folder in (target.fresh, target.folder))
    if ours is None or theirs is None:
        return
    for actuator in actuators.joints:
        if actuator.joint in wrong or actuator.joint not in figures:
            continue
        asked, got = (_arrays(model, actuator.joint) for model in (ours, theirs))
        place = next((figure.place for figure in figures[actuator.joint].values()), None)
        for name, values in asked.items():
            if name in got and not _unlimited(name, asked, got):
                yield from _differences(target, actuator, name, values, got[name], place)
    yield from _options(target, ours, theirs)
    yield from _keyframes(target, ours, theirs)


def _compiled(path: str) -> mujoco.MjModel | None:
    """A model that a process of its own has compiled before."""
    from actspec.robot.mjspec import compile_spec, open_spec

    try:
        return compile_spec(open_spec(open_document(path).files, format=ModelFormat.MJCF))
    except RobotError:
        return None


def _arrays(model: Any, joint: str) -> dict[str, list[float]]:
    """Rows of a joint, of its degree of freedom and of its one actuator, by the names of their arrays."""
    import mujoco

    index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, joint)
    if index < 0:
        return {}
    drives = drivers(model, index)
    rows = {"jnt_": index, "dof_": int(model.jnt_dofadr[index])}
    if len(drives) == 1:
        rows["actuator_"] = drives[0]
    found = {}
    for name in dir(model):
        row = next((i for start, i in rows.items() if name.startswith(start)), None)
        if row is not None and name not in FOLLOWING:
            found[name] = [float(value) for value in getattr(model, name)[row].ravel()]
    place = int(model.jnt_qposadr[index])
    for name in ("qpos0", "qpos_spring"):
        found[name] = [float(getattr(model, name)[place])]
    return found


def _unlimited(name: str, asked: Mapping[str, list[float]], got: Mapping[str, list[float]]) -> bool:
    limited = LIMITED.get(name)
    return limited is not None and not any((*asked.get(limited, ()), *got.get(limited, ())))


def _differences(
    target: TargetFiles,
    actuator: JointActuator,
    name: str,
    asked: list[float],
    got: list[float],
    place: Span | None,
) -> Iterator[Row]:
    wrong = next(
        (i for i, pair in enumerate(zip(asked, got, strict=True)) if not same(*pair, TOLERANCE)), None
    )
    if wrong is None:
        return
    turned = asked[wrong] != 0.0 and same(asked[wrong], -got[wrong], TOLERANCE)
    which = f"{name}[{wrong}]" if len(asked) > 1 else name
    yield target.fault(
        name,
        "VFY106" if turned else "VFY110",
        f"MuJoCo's {which} is {format_number(got[wrong])}, and should be {format_number(asked[wrong])}"
        + (": the sign is wrong" if turned else ", as actspec writes it"),
        actuator=actuator,
        max_error=abs(got[wrong] - asked[wrong]),
        tolerance=TOLERANCE * abs(asked[wrong]),
        expected=asked[wrong],
        got=got[wrong],
        place=place,
    )


def _options(target: TargetFiles, ours: Any, theirs: Any) -> Iterator[Row]:
    for name in OPTIONS:
        asked, got = (int(getattr(model.opt, name, 0)) for model in (ours, theirs))
        if asked != got:
            yield target.fault(
                name,
                "VFY110",
                f"the option {name} is {_option(name, got)}, and should be {_option(name, asked)}",
                max_error=float(abs(got - asked)),
                expected=float(asked),
                got=float(got),
                place=Span(target.path(target.files[0])),
            )


def _option(name: str, value: int) -> str:
    """A value of an option in MuJoCo's words: `EULER`, or the flags that are set."""
    import mujoco

    if name == "integrator":
        return str(mujoco.mjtIntegrator(value).name.removeprefix("mjINT_"))
    bits = {"disableflags": mujoco.mjtDisableBit, "enableflags": mujoco.mjtEnableBit}.get(name)
    if bits is None:
        return str(value)
    # mjDSBL_FRICTIONLOSS; mjNDISABLE is how many there are
    parts = [(bit.name.partition("_")[2], bit.value) for bit in bits.__members__.values()]
    flags = [name.lower() for name, bit in parts if name and value & bit]
    return listed(flags) if flags else "none"


def _keyframes(target: TargetFiles, ours: Any, theirs: Any) -> Iterator[Row]:
    """The first number of each keyframe that differs; keyframes are known by name, or place."""
    place = Span(target.path(target.files[0]))
    asked, got = (_keys(model) for model in (ours, theirs))
    for key, arrays in asked.items():
        others = got.get(key)
        if others is None:
            yield _key_row(target, key, f"the keyframe {key} is missing", place)
            continue
        for name, values in arrays.items():
            found = others[name]
            if len(found) != len(values):
                yield _key_row(target, key, f"the {name} of keyframe {key} has another length", place)
            elif any(not same(a, b, TOLERANCE) for a, b in zip(values, found, strict=True)):
                i = next(
                    i for i, pair in enumerate(zip(values, found, strict=True)) if not same(*pair, TOLERANCE)
                )
                text = f"the {name} of keyframe {key} at {_where(ours, name, i)} is {format_number(found[i])}"
                yield _key_row(target, key, f"{text}, and should be {format_number(values[i])}", place)


def _key_row(target: TargetFiles, key: str, message: str, place: Span) -> Row:
    return target.fault(one_line(f"keyframe {key}"), "VFY110", one_line(message), place=place)


def _keys(model: Any) -> dict[str, dict[str, list[float]]]:
    return {
        model.key(i).name or str(i): {
            name: [float(value) for value in getattr(model, f"key_{name}")[i]] for name in KEYS
        }
        for i in range(model.nkey)
    }


def _where(model: Any, name: str, index: int) -> str:
    """What a number of a keyframe is about: a joint or an actuator, else its place."""
    if name == "ctrl" and index < len(model.actuator_trntype):
        return model.actuator(index).name or str(index)
    addresses = {"qpos": model.jnt_qposadr, "qvel": model.jnt_dofadr}.get(name)
    if addresses is not None:
        joint = max((j for j in range(model.njnt) if addresses[j] <= index), default=None)
        if joint is not None:
            return model.joint(joint).name or str(index)
    return str(index)
