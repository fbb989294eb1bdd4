"""Ranges as Isaac Lab event terms, with the stock functions of isaaclab.envs.mdp.

Traps, all of 2.3.2 (source/isaaclab/isaaclab/envs/mdp/events.py):

- `operation` must be among the params: the terms' constructors read it there.
- `scale` refuses a stiffness factor of 0 and a pair whose second number is below its first, which a gaussian's
  mean and standard deviation are: such draws are written as `abs`.
- `randomize_joint_parameters` draws static, dynamic and viscous friction from one and the same range on Isaac
  Sim >= 5, so only factors keep them apart, and a nominal of 0 cannot be drawn.
- Where the passive viscous friction is a part of `damping`, a factor on it would draw that part too: kd is
  written as values with that part added.
- kp, kd and limits have no common factor; limits, delays and encoder biases have no term.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from actspec.diagnostics import Collector, listed
from actspec.ir import Command, JointActuator, Level
from actspec.sampling import FACTORS, nominal_of
from actspec.simulators.isaaclab import FrictionUnit, IsaacLabDialect
from actspec.targets.base import EmittedFile
from actspec.targets.isaaclab import dialect_for
from actspec.targets.isaaclab.classes import classes_of
from actspec.targets.isaaclab.fields import viscous_in_damping
from actspec.targets.kit.draws import (
    Draw,
    Losses,
    as_abs,
    as_scale,
    as_uniform,
    factor_error,
    factor_lost,
    viscous_change,
)
from actspec.targets.kit.events import EventTerm, StackWriter
from actspec.targets.kit.python_text import comment_lines, grouped

GAINS, OF_JOINTS = "mdp.randomize_actuator_gains", "mdp.randomize_joint_parameters"
"""The terms that draw kp and kd, and what belongs to the joint."""

NO_TERM = {
    "effort_limit": "Isaac Lab has no term for effort limits",
    "encoder_bias": "Isaac Lab has no term for encoder biases",
    "delay": "Isaac Lab draws a delay in DelayedPDActuatorCfg alone, between its min_delay and max_delay",
    "friction.stribeck_velocity": "Isaac Lab has no Stribeck friction",
}


def write(stack: StackWriter) -> EmittedFile | None:
    """The events of a robot; None: there are none, or an error: a friction of 0 that only a factor could draw."""
    dialect = dialect_for(stack.options, stack.version("isaaclab"))
    terms = [*_gains(stack, dialect), *_armature(stack), *_friction(stack, dialect)]
    stack.drop(NO_TERM)
    for actuator in stack.actuators.joints:
        _factors(actuator, stack.losses)
    if not terms:
        return None
    late = any(term.func == GAINS and term.mode != "startup" for term in terms)
    labs = [o for o in stack.options.siblings if o.kind == "isaaclab"]
    # What is wrong with them is reported by the target itself.
    implicit = any("implicit" in classes_of(stack.actuators, lab, Collector()).values() for lab in labs)
    through_cpu = (
        'Gains of implicit groups are written to the simulator through the CPU: prefer mode="startup".'
    )
    return stack.file(
        "isaaclab_events.py.j2",
        "isaaclab_events.py",
        f"Isaac Lab {dialect.text} on Isaac Sim {dialect.sim_text}",
        [
            through_cpu if late and implicit else "",
            "" if dialect.executed else "Text-checked, not run.",
            "" if dialect.friction.torque else "Friction stays as it is: it has no known unit here.",
        ],
        terms=terms,
        configclass="isaaclab.utils.configclass" if dialect.row.native else "isaaclab.utils",
    )


def _gains(stack: StackWriter, dialect: IsaacLabDialect) -> list[EventTerm]:
    stiffness = {draw.actuator.joint: _scalable(draw) for draw in stack.each("kp")}
    damping = {
        draw.actuator.joint: _scalable(_beside_viscous(draw, dialect, stack.losses))
        for draw in stack.each("kd")
    }
    terms = []
    both: list[tuple[Draw | None, Draw | None]] = []
    for joint in stack.draws:
        kp, kd = stiffness.get(joint), damping.get(joint)
        if kp is not None and kd is not None and _setting(kp) == _setting(kd):
            both.append((kp, kd))
        else:
            both += [(draw, None) for draw in (kp,) if draw] + [(None, draw) for draw in (kd,) if draw]
    for _, members in grouped(both, lambda pair: tuple(draw and draw.numbers for draw in pair)):
        draws = [draw for kp, kd in members if (draw := kp or kd) is not None]
        kp, kd = members[0]
        ranges = {name: draw for name, draw in (("stiffness", kp), ("damping", kd)) if draw is not None}
        summed = kd is not None and viscous_in_damping(kd.actuator, dialect) > 0.0
        remark = "`damping` holds the passive viscous friction too, which is not drawn here."
        what = "gains" if len(ranges) == 2 else next(iter(ranges))
        terms.append(_term(stack, what, GAINS, draws, ranges.items(), remark if summed else ""))
    drawn = [*stack.each("kp"), *stack.each("kd")]
    stack.losses.shared(drawn)
    for draw in drawn:
        stack.losses.product(draw)
    return terms


def _armature(stack: StackWriter) -> list[EventTerm]:
    found = [_scalable(draw) for draw in stack.each("armature")]
    stack.losses.shared(found)
    return _alike(stack, "armature", found)


def _alike(stack: StackWriter, what: str, found: Sequence[Draw], remark: str = "") -> list[EventTerm]:
    """A term for each set of joints with the same draw of a number of theirs."""
    return [
        _term(stack, what, OF_JOINTS, members, [(what, members[0])], remark)
        for _, members in grouped(found, lambda draw: draw.numbers)
    ]


def _beside_viscous(draw: Draw, dialect: IsaacLabDialect, losses: Losses) -> Draw:
    """The draw of kd as one of `damping`, which holds the passive viscous friction too on some versions."""
    viscous = viscous_in_damping(draw.actuator, dialect)
    if not viscous:
        return draw
    found = as_abs(draw)
    high = found.high if found.distribution == "gaussian" else found.high + viscous
    if draw.distribution == "log_uniform":
        why = "damping is kd and the passive viscous friction in one"
        losses.of(draw, f"{found.distribution} of the sum", why)
    return replace(found, low=found.low + viscous, high=high)


def _scalable(draw: Draw) -> Draw:
    """The same draw in a form that the terms accept."""
    pair_refused = draw.distribution == "gaussian" and draw.high < draw.low
    if draw.operation == "scale" and (pair_refused or (draw.field == "kp" and draw.low <= 0.0)):
        return as_abs(draw)
    return draw


def _setting(draw: Draw) -> tuple[object, ...]:
    """What kp and kd must have in common to be drawn by one term."""
    return (draw.operation, draw.distribution, draw.when, draw.every)


# --- friction ---------------------------------------------------------------------------------------------


FRICTIONS = ("friction.coulomb", "friction.static", "friction.viscous")


def _friction(stack: StackWriter, dialect: IsaacLabDialect) -> list[EventTerm]:
    if not dialect.friction.torque:
        stack.drop(dict.fromkeys(FRICTIONS, _NO_FRICTION[dialect.friction]))
        return []
    found = []
    undrawable = []
    for of_joint in stack.draws.values():
        wanted = {field: of_joint[field] for field in FRICTIONS if field in of_joint}
        zeros = [draw for draw in wanted.values() if not nominal_of(draw.actuator, draw.field)]
        undrawable += zeros
        if wanted and not zeros:
            found.append(_friction_draw(wanted, stack.losses))
    for (group, field, nominal), members in grouped(
        undrawable, lambda draw: (draw.actuator.group, draw.field, draw.nominal)
    ):
        first = members[0]
        stack.collector.at(f"actuators.{group}.randomize.{field}", first.parts[0].span).error(
            "RND010",
            f"{listed(draw.actuator.joint for draw in members)}: Isaac Sim {dialect.sim_text} draws static, dynamic "
            f"and viscous friction from one range, so only a factor can be written, and the nominal {field} is "
            + ("unknown" if nominal is None else f"0 {first.unit}"),
            f"state {field}, or leave isaaclab out of `for`",
        )
    stack.losses.shared(found)
    remark = (
        "One range draws static, dynamic and viscous friction, each on its own: only factors are safe here."
    )
    return _alike(stack, "friction", found, remark)


_NO_FRICTION = {
    FrictionUnit.COEFFICIENT: "friction has no unit on this Isaac Sim, so the config leaves it out",
    FrictionUnit.COEFFICIENT_VISCOUS: "friction is a coefficient of this backend, so the config leaves it out",
    FrictionUnit.DEAD: "this Isaac Lab writes no friction to Isaac Sim 5",
}


def _friction_draw(wanted: dict[str, Draw], losses: Losses) -> Draw:
    """The one factor that a joint's friction gets, and what it does to the parts that ask for another."""
    main = next(iter(wanted.values()))
    factor = as_scale(main)
    if factor.distribution == "gaussian":
        factor = as_uniform(factor)
        losses.of(
            main,
            f"scale {factor.low:g} to {factor.high:g}",
            "a factor's gaussian is refused (its pair counts as low and high): uniform of the same spread",
        )
    if main.operation == "add" and main.distribution == "log_uniform":
        losses.of(main, "uniform factor", "the term cannot draw a log_uniform offset")
    reach = max(abs(factor.low - 1.0), abs(factor.high - 1.0))
    actuator = main.actuator
    text = f"scale {factor.low:g} to {factor.high:g}"
    why = "static, dynamic and viscous friction have one range"
    for field in FRICTIONS:
        nominal = nominal_of(actuator, field)
        if field == main.field or nominal == 0.0:
            continue
        if field == "friction.static" and actuator.friction_static is None:
            continue
        other = wanted.get(field)
        if nominal is None:
            losses.add(actuator, field, "not drawn", f"{text} of the USD's own", why, None)
            continue
        change = nominal * reach
        if other is not None:
            same = as_scale(other)
            if same.numbers == factor.numbers:
                continue
            change = nominal * max(abs(same.low - factor.low), abs(same.high - factor.high))
        error = viscous_change(actuator, change) if field == "friction.viscous" else change
        if other is not None:
            losses.of(other, text, why, error)
        else:
            losses.add(actuator, field, "not drawn", text, why, error)
    if main.field == "friction.coulomb" and actuator.friction_static is None:
        losses.of(
            main,
            "static and dynamic friction drawn apart, dynamic cut at static",
            "static, dynamic and viscous friction are drawn apart",
            (main.nominal or 0.0) * (factor.high - factor.low),
        )
    return factor


# --- no term ----------------------------------------------------------------------------------------------


def _factors(actuator: JointActuator, losses: Losses) -> None:
    limits = NO_TERM["effort_limit"]
    for entry in (entry for entry in actuator.randomize if entry.field in FACTORS):
        if actuator.level is Level.ACTUATOR_NET:
            losses.entry(actuator, entry, "none", "a network's torque has no term")
        elif actuator.command is Command.EFFORT:
            why = f"the drive has no gains, and {limits}"
            losses.entry(actuator, entry, "none", why, factor_lost(actuator, entry))
        else:
            emitted, why = "a factor each on kp and kd", "randomize_actuator_gains draws kp and kd apart"
            if entry.field == "strength":
                emitted, why = f"{emitted}, none on the limit", f"{why}, and {limits}"
            losses.entry(actuator, entry, emitted, why, factor_error(actuator, entry, limit=False))


def _term(
    stack: StackWriter,
    what: str,
    func: str,
    draws: Sequence[Draw],
    ranges: Iterable[tuple[str, Draw]],
    remark: str,
) -> EventTerm:
    """A term that draws numbers by their names, with what all its draws have in common."""
    params = [(f"{name}_distribution_params", (draw.low, draw.high)) for name, draw in ranges]
    shared = (("operation", draws[0].operation), ("distribution", draws[0].distribution))
    comments = comment_lines(remark, indent="    ") if remark else ()
    joints = stack.patterns(draws)
    return stack.term(what, func, draws, (*params, *shared), joints=joints, comments=comments)
