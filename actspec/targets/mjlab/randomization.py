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
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from actspec.diagnostics import Collector
from actspec.ir import ActuatorSet, JointActuator, Level
from actspec.robot.view import ModelFormat, RobotView
from actspec.sampling import nominal_of
from actspec.simulators import UnknownVersion, text_of
from actspec.simulators.mjlab import EVENTS, MjlabDialect, mjlab_dialect
from actspec.targets.base import EmittedFile
from actspec.targets.kit.draw_losses import Losses, capped_error, each, factor_error, factor_lost
from actspec.targets.kit.draws import Draw, Draws, as_abs, as_uniform, draws_of, stated_range
from actspec.targets.kit.events import EventTerm, Namer, StackWriter, comments, patterns_of
from actspec.targets.kit.joint import joint_by_joint
from actspec.targets.kit.python_text import grouped
from actspec.targets.mjlab.joint_cfg import OF_A_JOINT, JointCfg, cfg_of
from actspec.targets.mjlab.text import WIDTH

INDENT = "  "

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
    configs = configs_of(stack.actuators, stack.robot, dialect, stack.collector)
    if stack.collector.failed:
        return None
    # mjlab calls a joint what is behind the last `/`.
    short = {name: name.rsplit("/", 1)[-1] for name in stack.names}
    terms = mjlab_terms(stack.actuators, configs, short, stack.losses)
    if not terms:
        return None
    notes = []
    if any(term.actuators is not None for term in terms):
        notes = ["actuator_ids count the configs of the articulation that actspec's mjlab target writes:"]
        notes += [f"{index}: {', '.join(config.joints)}" for index, config in enumerate(configs)]
    return stack.file(
        "mjlab_events.py.j2",
        "mjlab_events.py",
        f"mjlab {dialect.text}",
        notes,
        width=WIDTH,
        terms=terms,
        variable=f"{stack.stem.upper()}_EVENTS",
    )


@dataclass(frozen=True, slots=True)
class Config:
    """One actuator config of the articulation: its class and its joints."""

    kind: str
    joints: tuple[str, ...]


def configs_of(
    actuators: ActuatorSet, robot: RobotView, dialect: MjlabDialect, collector: Collector
) -> tuple[Config, ...]:
    """The configs of the articulation that the mjlab target writes, in its order; its errors are ours."""
    step = actuators.physics_dt.value or STEP

    def cfg(actuator: JointActuator, own: Collector) -> JointCfg | None:
        joint = None if robot.format is ModelFormat.NONE else robot.joint(actuator.joint)
        return cfg_of(actuator, joint, dialect, step, "mjlab", own)

    found = joint_by_joint(actuators, cfg, OF_A_JOINT, collector)
    return tuple(
        Config(members[0].kind, tuple(member.actuator.joint for member in members))
        for _, members in grouped(found, lambda cfg: cfg.key)
    )


STEP = 0.005
"""Stands in for an unknown step [s]: it decides no grouping but that of delays, which are equal or not."""

JOINT_TERMS = {
    "armature": ("dr.joint_armature", "armature"),
    "friction.coulomb": ("dr.joint_friction", "friction"),
    "friction.viscous": ("dr.joint_damping", "viscous_friction"),
}


def mjlab_terms(
    actuators: ActuatorSet, configs: Sequence[Config], names: Mapping[str, str], losses: Losses
) -> list[EventTerm]:
    """The events of a robot.

    Args:
        actuators: What is drawn.
        configs: Actuator configs of the articulation, in its order.
        names: All joints of the robot, and what mjlab calls each.
        losses: Takes what stock functions cannot do.
    """
    draws = {actuator.joint: draws_of(actuator) for actuator in actuators.joints}
    namer = Namer()
    terms = [
        *_gains(draws, configs, namer, losses),
        *_limits(draws, configs, namer, losses),
        *_joints(draws, names, namer, losses),
        *_bias(draws, names, namer, losses),
    ]
    kinds = {joint: config.kind for config in configs for joint in config.joints}
    for actuator in actuators.joints:
        _factors(actuator, kinds[actuator.joint], losses)
    reasons = {
        "friction.static": "MuJoCo's frictionloss is one number for sticking and sliding",
        "friction.stribeck_velocity": "MuJoCo has no Stribeck friction",
        "delay": "mjlab draws a delay in the actuator's config alone, between delay_min_lag and delay_max_lag",
    }
    for field, why in reasons.items():
        for draw in each(draws, field):
            losses.dropped(draw, why)
    return terms


# --- actuators --------------------------------------------------------------------------------------------


def _gains(draws: Draws, configs: Sequence[Config], namer: Namer, losses: Losses) -> list[EventTerm]:
    wanted: dict[int, tuple[Draw, Draw]] = {}
    held = []
    for index, config in enumerate(configs):
        kp, kd = (_common(config, draws, field, losses) for field in ("kp", "kd"))
        first = kp or kd
        if first is None:
            continue
        found = [
            draws[joint][field] for joint in config.joints for field in ("kp", "kd") if field in draws[joint]
        ]
        if config.kind not in WITH_GAINS:
            for draw in found:
                losses.dropped(draw, f"dr.pd_gains takes no {config.kind}")
            continue
        for draw in found:
            _note_gain(draw, losses)
        held += found
        pair = _pair(first.actuator, kp, kd)
        for draw in found:
            _note_pair(draw, pair[draw.field == "kd"], losses)
        wanted[index] = pair
    losses.shared(held)
    terms = []
    for _, members in grouped(wanted.items(), lambda item: tuple(d.numbers for d in item[1])):
        kp, kd = members[0][1]
        terms.append(
            EventTerm(
                namer.name([pair[0] for _, pair in members], "gains"),
                "dr.pd_gains",
                kp.when,
                kp.every,
                None,
                _chosen([index for index, _ in members], configs),
                (
                    ("kp_range", (kp.low, kp.high)),
                    ("kd_range", (kd.low, kd.high)),
                    ("distribution", kp.distribution),
                    ("operation", kp.operation),
                ),
            )
        )
    return terms


def _common(config: Config, draws: Draws, field: str, losses: Losses) -> Draw | None:
    """The draw of a config: that of its joints, or where identified ranges differ, from the least to the largest.

    A config holds joints of one group, so all have the range or none has.
    """
    found = [draws[joint][field] for joint in config.joints if field in draws[joint]]
    if len({draw.numbers for draw in found}) <= 1:
        return found[0] if found else None
    values = [as_abs(as_uniform(draw)) for draw in found]
    low, high = min(draw.low for draw in values), max(draw.high for draw in values)
    for draw in found:
        text = f"abs {low:g} to {high:g}, uniform"
        losses.entry(draw, draw.parts[0], text, "an event reaches all joints of an actuator config", None)
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
        why = "dr.pd_gains draws kp and kd at one time"
        losses.entry(draw, draw.parts[0], f"drawn at {made.when}{every}", why, None)
    if draw.distribution == "log_uniform" and made.distribution == "uniform" and draw.operation != "add":
        text = f"{made.operation} {made.low:g} to {made.high:g}, uniform"
        for entry in draw.parts:
            losses.entry(draw, entry, text, "dr.pd_gains has one distribution for kp and kd", None)


def _flattened(draw: Draw, losses: Losses, why: str) -> None:
    flat = as_uniform(draw)
    if flat.distribution != "uniform":
        flat = as_abs(flat)
    for entry in draw.parts:
        losses.entry(draw, entry, f"{flat.operation} {flat.low:g} to {flat.high:g}, uniform", why, None)


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


def _limits(draws: Draws, configs: Sequence[Config], namer: Namer, losses: Losses) -> list[EventTerm]:
    wanted: dict[int, Draw] = {}
    held = []
    for index, config in enumerate(configs):
        draw = _common(config, draws, "effort_limit", losses)
        if draw is None:
            continue
        for one in (draws[joint]["effort_limit"] for joint in config.joints):
            if config.kind not in WITH_GAINS | IN_PYTHON:
                losses.dropped(one, f"dr.effort_limits takes no {config.kind}")
                continue
            held.append(one)
            losses.product(one)
            if one.distribution == "gaussian" or (one.operation, one.distribution) == ("add", "log_uniform"):
                _flattened(one, losses, "dr.effort_limits draws a uniform or log_uniform factor or value")
            if config.kind in IN_PYTHON and one.nominal is not None and one.ends[1] > one.nominal:
                for entry in one.parts:
                    if entry.field == "effort_limit":
                        why = "an explicit actuator's limit moves in Python alone; MuJoCo cuts at the nominal"
                        losses.entry(
                            one, entry, "values above the nominal are cut to it", why, capped_error(one)
                        )
        if config.kind in WITH_GAINS | IN_PYTHON:
            flat = as_uniform(draw)
            wanted[index] = flat if flat.operation == "scale" else as_abs(flat)
    losses.shared(held)
    return [
        EventTerm(
            namer.name([draw for _, draw in members], "effort_limits"),
            "dr.effort_limits",
            members[0][1].when,
            members[0][1].every,
            None,
            _chosen([index for index, _ in members], configs),
            (
                ("effort_limit_range", (members[0][1].low, members[0][1].high)),
                ("distribution", members[0][1].distribution),
                ("operation", members[0][1].operation),
            ),
        )
        for _, members in grouped(wanted.items(), lambda item: item[1].numbers)
    ]


def _factors(actuator: JointActuator, kind: str, losses: Losses) -> None:
    for entry in actuator.randomize:
        if entry.field not in ("gains", "strength"):
            continue
        asked = stated_range(entry, "1")
        if kind not in WITH_GAINS | IN_PYTHON:
            why = f"dr.pd_gains and dr.effort_limits take no {kind}"
            losses.add(actuator, entry.field, asked, "none", why, factor_lost(actuator, entry))
        elif entry.field == "gains":
            why, error = "dr.pd_gains draws kp and kd apart", factor_error(actuator, entry, limit=False)
            if actuator.level is not Level.ACTUATOR_NET:
                losses.add(actuator, "gains", asked, "a factor each on kp and kd", why, error)
        else:
            emitted, why = (
                "a factor each on kp, kd and the limit",
                "dr.pd_gains and dr.effort_limits draw apart",
            )
            if kind == "LearnedMlpActuatorCfg":
                emitted, why = "a factor on the limit", "a network's torque has no event"
            if kind in IN_PYTHON:
                emitted += ", which is not raised above the nominal"
                why += "; MuJoCo cuts an explicit actuator at the nominal"
            if kind == "DcMotorActuatorCfg":
                why += ", and the torque-speed line has no event"
            error = factor_error(actuator, entry, limit=True, capped=kind in IN_PYTHON)
            losses.add(actuator, "strength", asked, emitted, why, error)


# --- joints -----------------------------------------------------------------------------------------------


def _joints(draws: Draws, names: Mapping[str, str], namer: Namer, losses: Losses) -> list[EventTerm]:
    terms = []
    for field, (func, what) in JOINT_TERMS.items():
        asked = list(each(draws, field))
        for draw in asked:
            if draw.distribution == "gaussian":
                _flattened(draw, losses, ONE_NUMBER)
        found = [as_uniform(draw) for draw in asked]
        for key, members in grouped(found, _sharing):
            first = members[0]
            shared = key[-1] is not None
            params: list[tuple[str, object]] = [
                ("ranges", (first.low, first.high)),
                ("distribution", first.distribution),
                ("operation", first.operation),
            ]
            if shared:
                params.append(("shared_random", True))
            remark = (
                "Recomputes constants of the model: costly at every reset." if field == "armature" else ""
            )
            terms.append(
                EventTerm(
                    namer.name(members, what),
                    func,
                    first.when,
                    first.every,
                    _patterns(members, names),
                    None,
                    tuple(params),
                    comments(remark if first.when != "startup" else "", indent=INDENT),
                )
            )
        # Joints of one robot with different ranges are in different terms, which share nothing.
        whole = [draw for draw in found if draw.per != "joint"]
        for draw in whole:
            mates = [
                d
                for d in whole
                if d.per == draw.per and (d.per == "env" or d.actuator.group == draw.actuator.group)
            ]
            if len({_sharing(mate) for mate in mates}) > 1:
                losses.entry(
                    draw,
                    draw.parts[0],
                    "one draw for the joints with this range",
                    "a term shares within itself",
                    None,
                )
    return terms


def _sharing(draw: Draw) -> tuple[object, ...]:
    """Draws with the same can be one term; the last part says what shares one number."""
    share = {"joint": None, "group": draw.actuator.group, "env": ""}[draw.per]
    return (*draw.numbers, share)


def _patterns(draws: Sequence[Draw], names: Mapping[str, str]) -> tuple[str, ...]:
    if all(name == short for name, short in names.items()) or len(draws) == len(names):
        return patterns_of(draws, tuple(names))
    return tuple(re.escape(names.get(draw.actuator.joint, draw.actuator.joint)) for draw in draws)


def _bias(draws: Draws, names: Mapping[str, str], namer: Namer, losses: Losses) -> list[EventTerm]:
    found = []
    for draw in each(draws, "encoder_bias"):
        flat = as_abs(as_uniform(draw))
        if draw.distribution != "uniform":
            flat = replace(flat, distribution="uniform")
            _flattened(draw, losses, "dr.encoder_bias draws uniformly")
        found.append(flat)
    losses.shared(found)
    return [
        EventTerm(
            namer.name(members, "encoder_bias"),
            "dr.encoder_bias",
            members[0].when,
            members[0].every,
            _patterns(members, names),
            None,
            (("bias_range", (members[0].low, members[0].high)),),
        )
        for _, members in grouped(found, lambda draw: draw.numbers)
    ]
