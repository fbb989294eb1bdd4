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

from collections.abc import Sequence
from dataclasses import replace

from actspec.diagnostics import Collector, listed
from actspec.ir import ActuatorSet, Command, JointActuator, Level
from actspec.sampling import nominal_of
from actspec.simulators.isaaclab import FrictionUnit, IsaacLabDialect
from actspec.spec.models import IsaacLabTarget
from actspec.targets.base import EmittedFile
from actspec.targets.isaaclab import dialect_for
from actspec.targets.isaaclab.fields import viscous_in_damping
from actspec.targets.kit.draw_losses import Losses, each, factor_error, factor_lost, viscous_change
from actspec.targets.kit.draws import Draw, Draws, as_abs, as_scale, as_uniform, draws_of, stated_range
from actspec.targets.kit.events import EventTerm, Namer, StackWriter, comments, patterns_of
from actspec.targets.kit.python_text import grouped

INDENT = "    "

GAINS = "mdp.randomize_actuator_gains"
"""The term that draws kp and kd."""


def write(stack: StackWriter) -> EmittedFile | None:
    """The events of a robot; None: there are none, or an error."""
    dialect = dialect_for(stack.options, stack.version("isaaclab"))
    terms = isaaclab_terms(stack.actuators, stack.names, dialect, stack.losses, stack.collector)
    if not terms:
        return None
    late = any(term.func == GAINS and term.mode != "startup" for term in terms)
    labs = [o.of(IsaacLabTarget) for o in stack.options.siblings if o.kind == "isaaclab"]
    implicit = any(lab.actuator_class == "implicit" for lab in labs)
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


def isaaclab_terms(
    actuators: ActuatorSet,
    names: Sequence[str],
    dialect: IsaacLabDialect,
    losses: Losses,
    collector: Collector,
) -> list[EventTerm]:
    """The event terms of a robot.

    Args:
        actuators: What is drawn.
        names: All joints of the articulation.
        dialect: Isaac Lab's version and the Isaac Sim below it.
        losses: Takes what stock terms cannot do.
        collector: Takes errors: a friction of 0 that only a factor could draw (RND010).
    """
    draws = {actuator.joint: draws_of(actuator) for actuator in actuators.joints}
    namer = Namer()
    terms = [*_gains(draws, names, dialect, namer, losses), *_armature(draws, names, namer, losses)]
    terms += _friction(draws, names, dialect, namer, losses, collector)
    _without_term(actuators, draws, losses)
    return terms


def _gains(
    draws: Draws, names: Sequence[str], dialect: IsaacLabDialect, namer: Namer, losses: Losses
) -> list[EventTerm]:
    stiffness = {draw.actuator.joint: _scalable(draw) for draw in each(draws, "kp")}
    damping = {
        draw.actuator.joint: _scalable(_beside_viscous(draw, dialect, losses)) for draw in each(draws, "kd")
    }
    terms = []
    both: list[tuple[Draw | None, Draw | None]] = []
    for joint in draws:
        kp, kd = stiffness.get(joint), damping.get(joint)
        if kp is not None and kd is not None and _setting(kp) == _setting(kd):
            both.append((kp, kd))
        else:
            both += [(draw, None) for draw in (kp,) if draw] + [(None, draw) for draw in (kd,) if draw]
    for _, members in grouped(both, lambda pair: tuple(draw and draw.numbers for draw in pair)):
        pairs = [kp or kd for kp, kd in members]
        first = [draw for draw in pairs if draw is not None]
        kp, kd = members[0]
        params = []
        if kp is not None:
            params.append(("stiffness_distribution_params", (kp.low, kp.high)))
        if kd is not None:
            params.append(("damping_distribution_params", (kd.low, kd.high)))
        what = "gains" if kp and kd else "stiffness" if kp else "damping"
        summed = kd is not None and viscous_in_damping(kd.actuator, dialect) > 0.0
        remark = (
            "`damping` holds the passive viscous friction too, which is not drawn here." if summed else ""
        )
        terms.append(_term(namer.name(first, what), GAINS, first, names, params, remark))
    drawn = [*each(draws, "kp"), *each(draws, "kd")]
    losses.shared(drawn)
    for draw in drawn:
        losses.product(draw)
    return terms


def _armature(draws: Draws, names: Sequence[str], namer: Namer, losses: Losses) -> list[EventTerm]:
    found = [_scalable(draw) for draw in each(draws, "armature")]
    losses.shared(found)
    return [
        _term(
            namer.name(members, "armature"),
            "mdp.randomize_joint_parameters",
            members,
            names,
            [("armature_distribution_params", (members[0].low, members[0].high))],
        )
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
        losses.entry(draw, draw.parts[0], f"{found.distribution} of the sum", why, None)
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


def _friction(
    draws: Draws,
    names: Sequence[str],
    dialect: IsaacLabDialect,
    namer: Namer,
    losses: Losses,
    collector: Collector,
) -> list[EventTerm]:
    fields = ("friction.coulomb", "friction.static", "friction.viscous")
    if not dialect.friction.torque:
        for field in fields:
            for draw in each(draws, field):
                losses.dropped(draw, _NO_FRICTION[dialect.friction])
        return []
    found = []
    undrawable = []
    for of_joint in draws.values():
        wanted = {field: of_joint[field] for field in fields if field in of_joint}
        zeros = [draw for draw in wanted.values() if not nominal_of(draw.actuator, draw.field)]
        undrawable += zeros
        if wanted and not zeros:
            found.append(_friction_draw(wanted, losses))
    for (group, field, nominal), members in grouped(
        undrawable, lambda draw: (draw.actuator.group, draw.field, draw.nominal)
    ):
        first = members[0]
        collector.at(f"actuators.{group}.randomize.{field}", first.parts[0].span).error(
            "RND010",
            f"{listed(draw.actuator.joint for draw in members)}: Isaac Sim {dialect.sim_text} draws static, dynamic "
            f"and viscous friction from one range, so only a factor can be written, and the nominal {field} is "
            + ("unknown" if nominal is None else f"0 {first.unit}"),
            f"state {field}, or leave isaaclab out of `for`",
        )
    losses.shared(found)
    remark = (
        "One range draws static, dynamic and viscous friction, each on its own: only factors are safe here."
    )
    return [
        _term(
            namer.name(members, "friction"),
            "mdp.randomize_joint_parameters",
            members,
            names,
            [("friction_distribution_params", (members[0].low, members[0].high))],
            remark,
        )
        for _, members in grouped(found, lambda draw: draw.numbers)
    ]


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
        losses.entry(
            main,
            main.parts[0],
            f"scale {factor.low:g} to {factor.high:g}",
            "a factor's gaussian is refused (its pair counts as low and high): uniform of the same spread",
            None,
        )
    if main.operation == "add" and main.distribution == "log_uniform":
        losses.entry(main, main.parts[0], "uniform factor", "the term cannot draw a log_uniform offset", None)
    reach = max(abs(factor.low - 1.0), abs(factor.high - 1.0))
    actuator = main.actuator
    text = f"scale {factor.low:g} to {factor.high:g}"
    why = "static, dynamic and viscous friction have one range"
    for field in ("friction.coulomb", "friction.static", "friction.viscous"):
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
            losses.entry(other, other.parts[0], text, why, error)
        else:
            losses.add(actuator, field, "not drawn", text, why, error)
    if main.field == "friction.coulomb" and actuator.friction_static is None:
        losses.entry(
            main,
            main.parts[0],
            "static and dynamic friction drawn apart, dynamic cut at static",
            "static, dynamic and viscous friction are drawn apart",
            (main.nominal or 0.0) * (factor.high - factor.low),
        )
    return factor


# --- no term ----------------------------------------------------------------------------------------------


def _without_term(actuators: ActuatorSet, draws: Draws, losses: Losses) -> None:
    reasons = {
        "effort_limit": "Isaac Lab has no term for effort limits",
        "encoder_bias": "Isaac Lab has no term for encoder biases",
        "delay": "Isaac Lab draws a delay in DelayedPDActuatorCfg alone, between its min_delay and max_delay",
        "friction.stribeck_velocity": "Isaac Lab has no Stribeck friction",
    }
    for field, why in reasons.items():
        for draw in each(draws, field):
            losses.dropped(draw, why)
    for actuator in actuators.joints:
        _factors(actuator, losses)


def _factors(actuator: JointActuator, losses: Losses) -> None:
    for entry in actuator.randomize:
        if entry.field not in ("gains", "strength"):
            continue
        if actuator.level is Level.ACTUATOR_NET:
            losses.add(
                actuator,
                entry.field,
                stated_range(entry, "1"),
                "none",
                "a network's torque has no term",
                None,
            )
            continue
        if actuator.command is Command.EFFORT:
            why = "the drive has no gains, and Isaac Lab has no term for effort limits"
            error = factor_lost(actuator, entry)
            losses.add(actuator, entry.field, stated_range(entry, "1"), "none", why, error)
            continue
        gains = entry.field == "gains"
        losses.add(
            actuator,
            entry.field,
            stated_range(entry, "1"),
            "a factor each on kp and kd" if gains else "a factor each on kp and kd, none on the limit",
            "randomize_actuator_gains draws kp and kd apart"
            + ("" if gains else ", and Isaac Lab has no term for effort limits"),
            factor_error(actuator, entry, limit=False),
        )


def _term(
    name: str,
    func: str,
    draws: Sequence[Draw],
    names: Sequence[str],
    params: list[tuple[str, tuple[float, float]]],
    remark: str = "",
) -> EventTerm:
    first = draws[0]
    return EventTerm(
        name,
        func,
        first.when,
        first.every,
        patterns_of(draws, names),
        None,
        (*params, ("operation", first.operation), ("distribution", first.distribution)),
        comments(remark, indent=INDENT),
    )
