"""Ranges as mjlab events, with the stock functions of mjlab.envs.mdp.dr.

Traps, all of mjlab 1.6.0:

- `dr.pd_gains` and `dr.effort_limits` index the articulation's actuator configs, not its actuators, but names
  resolve to actuators: configs are chosen by index here, or all of them.
- `dr.pd_gains` takes both ranges, `scale` or `abs`, uniform or log_uniform, and draws kp and kd apart.
- `dr.effort_limits` on an explicit actuator moves its clamp in Python alone: MuJoCo still cuts at the nominal.
- `gaussian` hands tensors of one number to a sampler that then ignores the size: all environments get the
  same (measured), so a gaussian is written as the uniform range of the same spread.
- `dr.joint_damping` is the passive viscous friction.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

from actspec.ir import JointActuator, Level
from actspec.sampling import FACTORS, nominal_of
from actspec.simulators import UnknownVersion, text_of
from actspec.simulators.mjlab import EVENTS, mjlab_dialect
from actspec.targets.base import EmittedFile
from actspec.targets.kit.draws import (
    Draw,
    Losses,
    as_abs,
    as_uniform,
    capped_error,
    factor_error,
    factor_lost,
)
from actspec.targets.kit.events import EventTerm, StackWriter
from actspec.targets.kit.python_text import comment_lines, grouped
from actspec.targets.mjlab.joint_cfg import JointCfg, cfgs_of
from actspec.targets.mjlab.text import WIDTH

Config = Sequence[JointCfg]
"""One actuator config of the articulation: what its joints have in common."""

WITH_GAINS = frozenset({"BuiltinPositionActuatorCfg", "DcMotorActuatorCfg", "IdealPdActuatorCfg"})
"""Classes that `dr.pd_gains` and `dr.effort_limits` take; the others that actspec writes raise a TypeError."""

ONE_NUMBER = "mjlab 1.6 draws one number of a gaussian for all environments and joints together"

IN_PYTHON = frozenset({"DcMotorActuatorCfg", "IdealPdActuatorCfg", "LearnedMlpActuatorCfg"})
"""Explicit classes, whose limit MuJoCo repeats."""


def write(stack: StackWriter) -> EmittedFile | None:
    """The events of a robot; None: there are none, or an error.

    Raises: UnknownVersion: there is no such mjlab, or none that events are written for.
    """
    dialect = mjlab_dialect(stack.version("mjlab"))
    if dialect.version < EVENTS:
        raise UnknownVersion(
            f"randomisation for mjlab {dialect.text} is not written",
            f'write version: "{text_of(EVENTS)}", or leave it out',
        )
    cfgs = cfgs_of(stack.actuators, stack.robot, dialect, "mjlab", stack.collector)
    if stack.collector.failed:
        return None
    configs = [members for _, members in grouped(cfgs, lambda cfg: cfg.key)]
    terms = [*_gains(stack, configs), *_limits(stack, configs), *_joints(stack), *_bias(stack)]
    for cfg in cfgs:
        _factors(cfg.actuator, cfg.kind, stack.losses)
    stack.drop(NO_TERM)
    if not terms:
        return None
    notes = []
    if any(term.actuators is not None for term in terms):
        notes = ["actuator_ids count the configs of the articulation that actspec's mjlab target writes:"]
        notes += [
            f"{index}: {', '.join(cfg.actuator.joint for cfg in config)}"
            for index, config in enumerate(configs)
        ]
    return stack.file(
        "mjlab_events.py.j2",
        "mjlab_events.py",
        f"mjlab {dialect.text}",
        notes,
        width=WIDTH,
        terms=terms,
        variable=f"{stack.stem.upper()}_EVENTS",
    )


JOINT_TERMS = {
    "armature": ("dr.joint_armature", "armature"),
    "friction.coulomb": ("dr.joint_friction", "friction"),
    "friction.viscous": ("dr.joint_damping", "viscous_friction"),
}

NO_TERM = {
    "friction.static": "MuJoCo's frictionloss is one number for sticking and sliding",
    "friction.stribeck_velocity": "MuJoCo has no Stribeck friction",
    "delay": "mjlab draws a delay in the actuator's config alone, between delay_min_lag and delay_max_lag",
}


# --- actuators --------------------------------------------------------------------------------------------


def _gains(stack: StackWriter, configs: Sequence[Config]) -> list[EventTerm]:
    losses = stack.losses
    wanted: dict[int, tuple[Draw, Draw]] = {}
    held = []
    for index, config in enumerate(configs):
        kp, kd = (_common(_own(stack, config, field), losses) for field in ("kp", "kd"))
        first = kp or kd
        if first is None:
            continue
        kind = config[0].kind
        found = _own(stack, config, "kp", "kd")
        if kind not in WITH_GAINS:
            for draw in found:
                losses.dropped(draw, f"dr.pd_gains takes no {kind}")
            continue
        for draw in found:
            _note_gain(draw, losses)
        pair = _pair(first.actuator, kp, kd)
        for draw in found:
            _note_pair(draw, pair[draw.field == "kd"], losses)
        held += found
        wanted[index] = pair
    losses.shared(held)
    terms = []
    for _, members in grouped(wanted.items(), lambda item: tuple(d.numbers for d in item[1])):
        kp, kd = members[0][1]
        params = (
            ("kp_range", (kp.low, kp.high)),
            ("kd_range", (kd.low, kd.high)),
            ("distribution", kp.distribution),
            ("operation", kp.operation),
        )
        chosen = _chosen([index for index, _ in members], configs)
        draws = [pair[0] for _, pair in members]
        terms.append(stack.term("gains", "dr.pd_gains", draws, params, actuators=chosen))
    return terms


def _own(stack: StackWriter, config: Config, *fields: str) -> list[Draw]:
    """The draws of a config's joints.

    A config holds joints of one group, so all have the range or none has.
    """
    of_joints = (stack.draws[cfg.actuator.joint] for cfg in config)
    return [draws[field] for draws in of_joints for field in fields if field in draws]


def _common(found: Sequence[Draw], losses: Losses) -> Draw | None:
    """The draw of a config: that of its joints, or where identified ranges differ, from the least to the largest."""
    if len({draw.numbers for draw in found}) <= 1:
        return found[0] if found else None
    values = [as_abs(as_uniform(draw)) for draw in found]
    low, high = min(draw.low for draw in values), max(draw.high for draw in values)
    for draw in found:
        text = f"abs {low:g} to {high:g}, uniform"
        losses.of(draw, text, "an event reaches all joints of an actuator config")
    return replace(values[0], low=low, high=high, distribution="uniform")


def _chosen(indices: Sequence[int], configs: Sequence[Config]) -> tuple[int, ...] | None:
    return None if len(indices) == len(configs) else tuple(indices)


def _note_gain(draw: Draw, losses: Losses) -> None:
    losses.product(draw)
    if draw.distribution == "gaussian":
        _flattened(draw, losses, "dr.pd_gains draws uniform or log_uniform")
    elif draw.distribution == "log_uniform" and draw.operation == "add":
        _flattened(draw, losses, "dr.pd_gains takes no offset")


def _note_pair(draw: Draw, made: Draw, losses: Losses) -> None:
    """What a gain's draw gives up for the other's, with which it shares an event."""
    if (draw.when, draw.every) != (made.when, made.every):
        every = "" if made.every is None else f" of {made.every[0]:g} to {made.every[1]:g} s"
        losses.of(draw, f"drawn at {made.when}{every}", "dr.pd_gains draws kp and kd at one time")
    if draw.distribution == "log_uniform" and made.distribution == "uniform" and draw.operation != "add":
        text = f"{made.operation} {made.low:g} to {made.high:g}, uniform"
        for entry in draw.parts:
            losses.entry(draw.actuator, entry, text, "dr.pd_gains has one distribution for kp and kd")


def _flattened(draw: Draw, losses: Losses, why: str) -> None:
    flat = as_uniform(draw)
    if flat.distribution != "uniform":
        flat = as_abs(flat)
    for entry in draw.parts:
        losses.entry(draw.actuator, entry, f"{flat.operation} {flat.low:g} to {flat.high:g}, uniform", why)


def _pair(actuator: JointActuator, kp: Draw | None, kd: Draw | None) -> tuple[Draw, Draw]:
    """Both draws with one operation and distribution; a gain that is not drawn keeps its nominal."""
    given = [as_uniform(draw) for draw in (kp, kd) if draw is not None]
    scaled = all(draw.operation == "scale" for draw in given)
    given = given if scaled else [as_abs(draw) for draw in given]
    kinds = {draw.distribution for draw in given}
    distribution = kinds.pop() if len(kinds) == 1 else "uniform"
    first = given[0]

    def whole(draw: Draw | None, field: str) -> Draw:
        if draw is not None:
            found = next(item for item in given if item.field == field)
            return replace(found, distribution=distribution, when=first.when, every=first.every)
        nominal = 1.0 if scaled else nominal_of(actuator, field) or 0.0
        return replace(first, field=field, low=nominal, high=nominal, distribution=distribution)

    pair = whole(kp, "kp"), whole(kd, "kd")
    if distribution == "log_uniform" and any(draw.low <= 0.0 for draw in pair):
        # The logarithm of a gain of 0 that stays.
        return replace(pair[0], distribution="uniform"), replace(pair[1], distribution="uniform")
    return pair


def _limits(stack: StackWriter, configs: Sequence[Config]) -> list[EventTerm]:
    losses = stack.losses
    wanted: dict[int, Draw] = {}
    held = []
    for index, config in enumerate(configs):
        kind, own = config[0].kind, _own(stack, config, "effort_limit")
        draw = _common(own, losses)
        if draw is None:
            continue
        if kind not in WITH_GAINS | IN_PYTHON:
            for one in own:
                losses.dropped(one, f"dr.effort_limits takes no {kind}")
            continue
        for one in own:
            _note_limit(one, kind, losses)
        held += own
        flat = as_uniform(draw)
        wanted[index] = flat if flat.operation == "scale" else as_abs(flat)
    losses.shared(held)
    terms = []
    for _, members in grouped(wanted.items(), lambda item: item[1].numbers):
        draws = [draw for _, draw in members]
        params = (
            ("effort_limit_range", (draws[0].low, draws[0].high)),
            ("distribution", draws[0].distribution),
            ("operation", draws[0].operation),
        )
        chosen = _chosen([index for index, _ in members], configs)
        terms.append(stack.term("effort_limits", "dr.effort_limits", draws, params, actuators=chosen))
    return terms


def _note_limit(draw: Draw, kind: str, losses: Losses) -> None:
    losses.product(draw)
    if draw.distribution == "gaussian" or (draw.operation, draw.distribution) == ("add", "log_uniform"):
        _flattened(draw, losses, "dr.effort_limits draws a uniform or log_uniform factor or value")
    if kind in IN_PYTHON and draw.nominal is not None and draw.ends[1] > draw.nominal:
        for entry in draw.parts:
            if entry.field == "effort_limit":
                why = "an explicit actuator's limit moves in Python alone; MuJoCo cuts at the nominal"
                cut = "values above the nominal are cut to it"
                losses.entry(draw.actuator, entry, cut, why, capped_error(draw))


def _factors(actuator: JointActuator, kind: str, losses: Losses) -> None:
    for entry in (entry for entry in actuator.randomize if entry.field in FACTORS):
        if kind not in WITH_GAINS | IN_PYTHON:
            why = f"dr.pd_gains and dr.effort_limits take no {kind}"
            losses.entry(actuator, entry, "none", why, factor_lost(actuator, entry))
        elif entry.field == "gains":
            why, error = "dr.pd_gains draws kp and kd apart", factor_error(actuator, entry, limit=False)
            if actuator.level is not Level.ACTUATOR_NET:
                losses.entry(actuator, entry, "a factor each on kp and kd", why, error)
        else:
            emitted = "a factor each on kp, kd and the limit"
            why = "dr.pd_gains and dr.effort_limits draw apart"
            if kind == "LearnedMlpActuatorCfg":
                emitted, why = "a factor on the limit", "a network's torque has no event"
            if kind in IN_PYTHON:
                emitted += ", which is not raised above the nominal"
                why += "; MuJoCo cuts an explicit actuator at the nominal"
            if kind == "DcMotorActuatorCfg":
                why += ", and the torque-speed line has no event"
            error = factor_error(actuator, entry, limit=True, capped=kind in IN_PYTHON)
            losses.entry(actuator, entry, emitted, why, error)


# --- joints -----------------------------------------------------------------------------------------------


def _joints(stack: StackWriter) -> list[EventTerm]:
    terms = []
    for field, (func, what) in JOINT_TERMS.items():
        asked = list(stack.each(field))
        for draw in asked:
            if draw.distribution == "gaussian":
                _flattened(draw, stack.losses, ONE_NUMBER)
        found = [as_uniform(draw) for draw in asked]
        for key, members in grouped(found, _sharing):
            first = members[0]
            params: list[tuple[str, object]] = [
                ("ranges", (first.low, first.high)),
                ("distribution", first.distribution),
                ("operation", first.operation),
            ]
            if key[-1] is not None:
                params.append(("shared_random", True))
            costly = field == "armature" and first.when != "startup"
            remark = "Recomputes constants of the model: costly at every reset."
            comments = comment_lines(remark, indent="  ") if costly else ()
            joints = _patterns(stack, members)
            terms.append(stack.term(what, func, members, params, joints=joints, comments=comments))
        # Joints of one robot with different ranges are in different terms, which share nothing.
        whole = [draw for draw in found if draw.per != "joint"]
        for draw in whole:
            mates = [
                d
                for d in whole
                if d.per == draw.per and (d.per == "env" or d.actuator.group == draw.actuator.group)
            ]
            if len({_sharing(mate) for mate in mates}) > 1:
                one = "one draw for the joints with this range"
                stack.losses.of(draw, one, "a term shares within itself")
    return terms


def _sharing(draw: Draw) -> tuple[object, ...]:
    """Draws with the same can be one term; the last part says what shares one number."""
    share = {"joint": None, "group": draw.actuator.group, "env": ""}[draw.per]
    return (*draw.numbers, share)


def _patterns(stack: StackWriter, draws: Sequence[Draw]) -> tuple[str, ...]:
    """Patterns of joints; mjlab calls one what is behind the last `/`."""
    if not any("/" in name for name in stack.names) or len(draws) == len(stack.names):
        return stack.patterns(draws)
    return tuple(re.escape(draw.actuator.joint.rsplit("/", 1)[-1]) for draw in draws)


def _bias(stack: StackWriter) -> list[EventTerm]:
    found = []
    for draw in stack.each("encoder_bias"):
        flat = as_abs(as_uniform(draw))
        if draw.distribution != "uniform":
            flat = replace(flat, distribution="uniform")
            _flattened(draw, stack.losses, "dr.encoder_bias draws uniformly")
        found.append(flat)
    stack.losses.shared(found)
    terms = []
    for _, members in grouped(found, lambda draw: draw.numbers):
        params = [("bias_range", (members[0].low, members[0].high))]
        joints = _patterns(stack, members)
        terms.append(stack.term("encoder_bias", "dr.encoder_bias", members, params, joints=joints))
    return terms
