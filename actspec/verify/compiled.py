"""Static agreement of models: what the compiled model has of a joint that is no figure, and its keyframes."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import RobotError, Span, listed, one_line
from actspec.ir import ActuatorSet, JointActuator
from actspec.readings.compare import NOTHING
from actspec.robot.view import ModelFormat
from actspec.robot.xml import read_model_files
from actspec.simulate.rollout import PLACES, drivers
from actspec.verify.agreement import Row, TargetFiles
from actspec.verify.layout import TOLERANCE
from actspec.verify.readback import Figures

if TYPE_CHECKING:
    import mujoco

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
        return compile_spec(open_spec(read_model_files(path), format=ModelFormat.MJCF))
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
    wrong = next((i for i, pair in enumerate(zip(asked, got, strict=True)) if not _equal(*pair)), None)
    if wrong is None:
        return
    turned = asked[wrong] != 0.0 and _equal(asked[wrong], -got[wrong])
    which = f"{name}[{wrong}]" if len(asked) > 1 else name
    yield target.fault(
        name,
        "VFY106" if turned else "VFY110",
        f"MuJoCo's {which} is {got[wrong]:.6g}, and should be {asked[wrong]:.6g}"
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
    """The first number of each keyframe that is another one; keyframes are known by name, or place."""
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
            elif any(not _equal(a, b) for a, b in zip(values, found, strict=True)):
                i = next(i for i, pair in enumerate(zip(values, found, strict=True)) if not _equal(*pair))
                text = f"the {name} of keyframe {key} at {_where(ours, name, i)} is {found[i]:.6g}"
                yield _key_row(target, key, f"{text}, and should be {values[i]:.6g}", place)


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


def _equal(asked: float, got: float) -> bool:
    return math.isclose(asked, got, rel_tol=TOLERANCE, abs_tol=NOTHING)
