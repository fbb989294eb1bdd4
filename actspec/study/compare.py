"""Variants of each distinct actuator beside each other, alone on its inertia: as the law has it, and as MuJoCo does."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import Collector, Diagnostic, RobotError, Severity, listed
from actspec.ir import ActuatorSet, Command, JointActuator, Level
from actspec.laws import TorqueLaw, delay_steps, law_of
from actspec.laws.network import NetworkDrive
from actspec.simulate.excitation import BEFORE, rest_position, torque_scale
from actspec.simulate.experiment import without_body
from actspec.simulate.reference import DrivenJoint, PassiveFriction, Trajectory, integrate
from actspec.study.courses import SHARES, amplitude, commands, sweep
from actspec.study.learned import LearnedJoint, bundle_of, near, respond
from actspec.study.metrics import Course, Metrics, chirp_metrics, step_metrics
from actspec.study.variants import NAMES, NO_NETWORK, Assumed, Missing, variants_of
from actspec.targets.kit.network import network_clip
from actspec.verify.joint_laws import JointLaws, laws_of

if TYPE_CHECKING:
    from actspec.laws.arrays import Floats as Array
    from actspec.robot.view import RobotView
    from actspec.spec.validate import Spec
    from actspec.targets.base import TargetOptions

LIKE = 1e-3
"""Largest relative difference of the inertias of two joints that count as one. Chosen: mirrored legs differ by less."""
FINEST = 2.5e-4
"""Longest time between two samples of the law's answer [s]. Chosen: crossings between them are then good to 1e-4."""
FASTEST = 0.5
"""Largest part of the drive's own time constant J / kd in a substep of the law. Chosen: Runge-Kutta's error is 1e-3 of
what is left of a decay that is over at once."""
PARTS = 4
"""Least substeps between two samples of the law's answer."""
MOST_PARTS = 100
"""Chosen: beyond so many a joint is not compared. Its speed is gone in 5 us, which is no joint's: an inertia is
missing, or a gain is wrong."""
TAIL = 0.2
"""Last part of a course in which a joint that its step carries has come to rest, or swings no more than the law."""
RATTLES = 0.02
"""Swing of the torque in the tail beyond twice the law's, as a share of the effort limit, from which on the step does
not carry the drive. Chosen: what is seen then is about the whole limit."""
FOUR_TIMES = "MuJoCo's RK4 evaluates forces four times a step, a network once: integrator implicitfast"
NOTHING = Assumed()


@dataclass(frozen=True, slots=True)
class Trace:
    """How one course went.

    Attributes:
        time: Of the positions, from the command's change on [s], shape (n + 1,).
        answer: Position, or speed of a velocity drive, from where it began; likewise.
        speed: [rad/s or m/s], likewise.
        torque: Of the drive [N*m or N], shape (n,).
    """

    time: Array
    answer: Array
    speed: Array
    torque: Array


@dataclass(frozen=True, slots=True)
class Compared:
    """One variant of one actuator under one course.

    Attributes:
        actuator: The variant, with the first joint's name.
        joints: All that it stands for, in the robot's order.
        variant: Name of the variant.
        course: Name of the course.
        amplitude: Of the command [rad or m; rad/s or m/s of a velocity drive].
        inertia: J [kg*m^2 or kg].
        explicit_ratio: h kd / J: how much of the speed an explicit step takes away.
        command: One a physics step, from where it began.
        law: As the law has it.
        simulated: As MuJoCo does; None: it diverged.
        law_metrics: What the law's answer shows.
        simulated_metrics: What MuJoCo's shows; None where it is not stable.
        stable: Whether MuJoCo's step carries the drive.
        departure: Largest difference of the two, as a share of the amplitude; None where it is not stable.
        change: Largest difference of the law's answer from that of PD and limit, likewise; None: there is none.
    """

    actuator: JointActuator
    joints: tuple[str, ...]
    variant: str
    course: str
    amplitude: float
    inertia: float
    explicit_ratio: float
    command: Array
    law: Trace
    simulated: Trace | None
    law_metrics: Metrics
    simulated_metrics: Metrics | None
    stable: bool
    departure: float | None
    change: float | None


@dataclass(frozen=True, slots=True)
class Comparison:
    """What a comparison of one spec found.

    Attributes:
        spec: Its path.
        timestep: MuJoCo's [s].
        integrator: Its name.
        rows: In the order of joints, variants and courses.
        missing: Variants that joints do not have, and why.
        findings: Steps that do not carry a drive.
    """

    spec: str
    timestep: float
    integrator: str
    rows: tuple[Compared, ...]
    missing: tuple[Missing, ...]
    findings: tuple[Diagnostic, ...]


def compare(
    actuators: ActuatorSet,
    robot: RobotView,
    options: TargetOptions,
    *,
    spec: str,
    joints: Sequence[str],
    given: Assumed = NOTHING,
    duration: float = 1.0,
    progress: Callable[[int, int], None] | None = None,
) -> Comparison:
    """Let every variant of every distinct actuator follow every course, by law and in MuJoCo.

    Args:
        actuators: The spec, resolved.
        robot: Its model.
        options: Of a MuJoCo target.
        spec: Its path, for the result.
        joints: Names of those that are compared.
        given: Figures that the spec may lack.
        duration: Of each course [s].
        progress: Called with variants done, of how many.

    Raises:
        EmitError: a variant cannot be compiled for MuJoCo.
        RobotError: the compiled model cannot be read.
    """
    missing: list[Missing] = []
    groups = distinct([a for a in actuators.joints if a.joint in set(joints)], missing)
    members = {group[0].joint: tuple(a.joint for a in group) for group in groups}
    made: dict[str, dict[str, JointActuator]] = {}
    learned = laws_of(
        replace(actuators, joints=tuple(g[0] for g in groups if g[0].level is Level.ACTUATOR_NET))
    )
    for group in groups:
        found, lacking = variants_of(group[0], given)
        missing += lacking
        for name, actuator in found.items():
            reason = _unmoved(actuator, learned) or _too_fast(actuator)
            if reason is None:
                made.setdefault(name, {})[actuator.joint] = actuator
            else:
                missing.append(Missing(actuator.joint, name, reason))
    step = actuators.physics_dt.require()
    cases = [case for group in groups for case in _cases(group[0].joint, made, learned, step, duration)]
    references = _references(cases, step)
    rows: list[Compared] = []
    integrator = ""
    for done, (name, mine) in enumerate(made.items()):
        if progress is not None:
            progress(done, len(made))
        whole = tuple(mine.get(a.joint, a) for a in actuators.joints)
        model = _model(replace(actuators, joints=whole), robot, options)
        step, integrator = float(model.opt.timestep), _integrator(model)
        for case in cases:
            if case.variant != name:
                continue
            if case.network is not None and integrator == "RK4":
                missing.append(Missing(case.actuator.joint, name, FOUR_TIMES))
            else:
                rows += _rows(case, members[case.actuator.joint], references, model)
    ordered = _with_changes(rows, [group[0].joint for group in groups])
    return Comparison(
        spec, step, integrator, ordered, tuple(missing), tuple(_findings(ordered, step, integrator))
    )


@dataclass(frozen=True, slots=True)
class _Case:
    """One variant of one actuator, and what it is commanded.

    Attributes:
        variant: Its name.
        actuator: The variant.
        law: Its own; of a network the PD that it is near to, with the network's clamps.
        network: In its drive; None: the torque is the law's.
        asked: Law whose torques the commands are worth.
        inertia: J [kg*m^2 or kg].
        swept: First and last frequency of the chirp [rad/s].
        commands: By course, one a physics step.
    """

    variant: str
    actuator: JointActuator
    law: TorqueLaw
    network: NetworkDrive | None
    asked: TorqueLaw
    inertia: float
    swept: tuple[float, float]
    commands: Mapping[str, Array]


def _cases(
    joint: str,
    made: Mapping[str, Mapping[str, JointActuator]],
    learned: JointLaws,
    step: float,
    duration: float,
) -> Iterator[_Case]:
    """The variants of one joint, all under the same chirp, a network under the commands of its PD."""
    mine = {name: of[joint] for name, of in made.items() if joint in of}
    if not mine:
        return
    drives = {name: _drive(actuator, learned) for name, actuator in mine.items()}
    laws = {
        name: law_of(actuator) if drive is None else near(drive)
        for (name, actuator), drive in zip(mine.items(), drives.values(), strict=True)
    }
    first = next(iter(mine.values()))
    known = {name: law for name, law in laws.items() if isinstance(law, TorqueLaw)}
    swept = sweep(known.values(), first.friction_viscous.value or 0.0, _inertia(first), step)
    for name, law in known.items():
        other = known.get("ideal_pd", known.get("network", law))
        asked = law if drives[name] is None else replace(law, kp=other.kp, kd=other.kd)
        given = commands(asked, swept, step, duration)
        yield _Case(name, mine[name], law, drives[name], asked, _inertia(first), swept, given)


def _drive(actuator: JointActuator, learned: JointLaws) -> NetworkDrive | None:
    """The network of a variant, with the variant's own clamps; None: it has none."""
    if actuator.level is not Level.ACTUATOR_NET:
        return None
    return replace(learned.networks[actuator.joint], clip=law_of(network_clip(actuator)))


def simulator_of(spec: Spec, out: Collector) -> TargetOptions:
    """The MuJoCo target of a spec, else MuJoCo as it is compiled for by default."""
    from actspec.targets.choose import choose_targets

    own = [target for target in choose_targets(spec, (), None, False, out) if target.kind == "mujoco"]
    return own[0] if own else choose_targets(spec, ("mujoco",), None, False, out)[0]


def distinct(actuators: Sequence[JointActuator], missing: list[Missing]) -> list[tuple[JointActuator, ...]]:
    """Joints in groups of equal figures and inertia, in the robot's order; those without an inertia are missing."""
    groups: list[list[JointActuator]] = []
    for actuator in actuators:
        reason = without_body(actuator)
        if reason is not None:
            missing.append(Missing(actuator.joint, "spec", reason))
            continue
        for group in groups:
            if _figures(group[0]) == _figures(actuator) and math.isclose(
                _inertia(group[0]), _inertia(actuator), rel_tol=LIKE
            ):
                group.append(actuator)
                break
        else:
            groups.append([actuator])
    return [tuple(group) for group in groups]


def _unmoved(actuator: JointActuator, learned: JointLaws) -> str | None:
    if actuator.level is Level.ACTUATOR_NET:
        drive = learned.networks.get(actuator.joint)
        if drive is None:
            return learned.skipped.get(actuator.group, (NO_NETWORK, None))[0]
        found = near(drive)
        return found if isinstance(found, str) else None
    if actuator.command is Command.EFFORT:
        return "the command is an effort: there is nothing that follows it"
    gain = actuator.kp if actuator.command is Command.POSITION else actuator.kd
    if gain is None or not gain.value:
        return "a gain of 0 follows nothing"
    return None


def _too_fast(actuator: JointActuator) -> str | None:
    law = None if actuator.level is Level.ACTUATOR_NET else law_of(actuator)
    if not isinstance(law, TorqueLaw):
        return None
    rate = _rate(law, actuator)
    if FINEST * rate / FASTEST <= MOST_PARTS:
        return None
    of = "kd" if law.kd > (actuator.friction_viscous.value or 0.0) else "friction.viscous"
    return f"{of} alone stops it within {1e6 / rate:.2g} us: state the armature, or correct {of}"


def _rate(law: TorqueLaw, actuator: JointActuator) -> float:
    """One over the time in which drive and friction take a joint's speed [1/s]."""
    return (law.kd + (actuator.friction_viscous.value or 0.0)) / _inertia(actuator)


def _inertia(actuator: JointActuator) -> float:
    assert actuator.inertia_held is not None
    return actuator.inertia_held.reference


def _figures(actuator: JointActuator) -> tuple[Any, ...]:
    """What decides how a joint answers, its inertia aside."""
    ends = actuator.command_range
    width = None
    if ends is not None and ends[0].value is not None and ends[1].value is not None:
        width = round(ends[1].value - ends[0].value, 9)
    values = {name: q.value for name, q in actuator.quantities() if name in _DECIDING}
    delay = None if actuator.delay is None else actuator.delay.nominal.value
    return (
        actuator.kind,
        actuator.level,
        actuator.command,
        actuator.network,
        width,
        delay,
        *sorted(values.items()),
    )


_DECIDING = frozenset(
    (
        *(
            "kp",
            "kd",
            "effort_limit",
            "stall_torque",
            "no_load_speed",
            "armature",
            "filter_cutoff",
            "encoder_bias",
        ),
        *("friction_coulomb", "friction_static", "friction_viscous", "stribeck_velocity"),
        *("curve.drive_torque", "curve.brake_torque", "curve.knee_speed", "curve.no_load_speed"),
    )
)


def _model(actuators: ActuatorSet, robot: RobotView, options: TargetOptions) -> Any:
    """What the MuJoCo target makes of these actuators, compiled.

    A drive in the words of a version that the installed MuJoCo cannot read is the same drive in its own words.
    """
    from actspec.robot.view import ModelFile
    from actspec.simulators.mujoco import installed_dialect, mujoco_dialect
    from actspec.targets.mujoco.emit import compiled_model, emit

    def compiled(options: TargetOptions) -> Any:
        files = [
            ModelFile(os.path.join(options.folder, file.path), "" if k == 0 else file.path, file.data)
            for k, file in enumerate(emit(actuators, robot, options).files)
            if file.path.endswith(".xml")
        ]
        return compiled_model(files)

    try:
        return compiled(options)
    except RobotError:
        installed = installed_dialect()
        if mujoco_dialect(options.version).words == installed.words:
            raise
        return compiled(replace(options, version=installed.text))


def _integrator(model: Any) -> str:
    import mujoco

    name: str = mujoco.mjtIntegrator(int(model.opt.integrator)).name
    return {"EULER": "Euler", "RK4": "RK4"}.get(name[len("mjINT_") :], name[len("mjINT_") :].lower())


def _rows(
    case: _Case, joints: tuple[str, ...], references: Mapping[tuple[str, str, str], Trace], model: Any
) -> Iterator[Compared]:
    """All courses of one case."""
    law, simulated = case.law, _simulated(case, model)
    step = float(model.opt.timestep)
    for course, command in case.commands.items():
        size = amplitude(case.asked, course)
        reference = references[case.variant, case.actuator.joint, course]
        moved = simulated[course]
        asked = command[BEFORE:] - command[0]
        chirped = case.swept if course == "chirp" else None
        carried = moved if moved is not None and _carried(moved, reference, torque_scale(law)) else None
        yield Compared(
            case.actuator,
            joints,
            case.variant,
            course,
            size,
            case.inertia,
            step * law.kd / case.inertia,
            asked,
            reference,
            moved,
            _measured(reference, asked, law.effort_limit, chirped),
            None if carried is None else _measured(carried, asked, law.effort_limit, chirped),
            carried is not None,
            None if carried is None else _difference(carried, reference, size),
            None,
        )


def _measured(trace: Trace, command: Array, limit: float, swept: tuple[float, float] | None) -> Metrics:
    """What a trace shows under a command of one number a physics step; of a chirp where it is one."""
    repeated = command.repeat(len(trace.torque) // len(command))
    course = Course(float(trace.time[1]), repeated, trace.answer, trace.speed, trace.torque, limit)
    return step_metrics(course) if swept is None else chirp_metrics(course, swept)


def _references(cases: Sequence[_Case], step: float) -> dict[tuple[str, str, str], Trace]:
    """The laws' answers, by variant, joint and course, all at once.

    Delays are exact to the sample, and steps so small that smaller ones change nothing. Networks are sampled once a
    step.
    """
    import numpy as np

    found: dict[tuple[str, str, str], Trace] = {}
    for learned in (False, True):
        mine = [case for case in cases if (case.network is not None) == learned]
        columns = [(case, course) for case in mine for course in case.commands]
        if not columns:
            continue
        parts, moved = _answered(columns, step)
        before = BEFORE * parts
        time = np.arange(len(moved.q) - before, dtype=float) * (step / parts)
        for k, (case, course) in enumerate(columns):
            q, qd = moved.q[before:, k] - rest_position(case.asked), moved.qd[before:, k]
            answer = qd if case.law.command is Command.VELOCITY else q
            key = case.variant, case.actuator.joint, course
            found[key] = Trace(time, answer, qd, moved.torque[before:, k])
    return found


def _answered(columns: Sequence[tuple[_Case, str]], step: float) -> tuple[int, Trajectory]:
    """How joints go by laws alone, or by networks alone, and samples in a step."""
    import numpy as np

    command = np.stack([case.commands[course] for case, course in columns], axis=1)
    start = np.array([rest_position(case.asked) for case, _ in columns])
    frictions = [PassiveFriction.of(case.actuator) for case, _ in columns]
    learned = [
        LearnedJoint(case.network, friction, case.inertia)
        for (case, _), friction in zip(columns, frictions, strict=True)
        if case.network is not None
    ]
    if learned:
        parts = max(math.ceil(step / FINEST - 1e-9), 1)
        return parts, respond(learned, command, start, step, parts)
    parts = _divided([case.law.delay for case, _ in columns], step)
    rate = max(_rate(case.law, case.actuator) for case, _ in columns)
    substeps = max(PARTS, math.ceil(step / parts * rate / FASTEST))
    driven = [
        DrivenJoint(case.law, friction, case.inertia)
        for (case, _), friction in zip(columns, frictions, strict=True)
    ]
    still = np.zeros(len(columns))
    fine = command.repeat(parts, axis=0)
    return parts, integrate(driven, fine, start, still, step / parts, substeps=substeps)


def _divided(delays: Sequence[float], step: float) -> int:
    """Into how many samples a step is divided: fine, and such that every delay is a whole number of them, or nearly."""
    least = max(math.ceil(step / FINEST - 1e-9), 1)
    return min(
        range(least, 2 * least + 8),
        key=lambda parts: (max((_off(delay, step / parts) for delay in delays), default=0.0) > 1e-9, parts),
    )


def _off(delay: float, period: float) -> float:
    return abs(delay - delay_steps(delay, period).steps * period)


def _simulated(case: _Case, whole: Any) -> dict[str, Trace | None]:
    """MuJoCo's answers, by course; None where the simulation diverged."""
    from actspec.simulate.rollout import isolated

    actuator = case.actuator
    alone = isolated(whole, actuator.joint, case.inertia - (actuator.armature.value or 0.0))
    if case.network is None:
        return _rolled(case, alone)
    from actspec.learn.attach import Attached

    with Attached(alone, bundle_of(case.network, "joint", "actuator0", float(alone.opt.timestep))):
        return _rolled(case, alone)


def _rolled(case: _Case, alone: Any) -> dict[str, Trace | None]:
    import numpy as np

    from actspec.simulate.rollout import Rig, rollout

    rig = Rig(alone, ["joint"], ["actuator0"])
    start, found = rest_position(case.asked), {}
    for course, command in case.commands.items():
        moved = rollout(rig, command[:, None], np.array([start]), np.zeros(1))
        q, qd = moved.q[BEFORE:, 0] - start, moved.qd[BEFORE:, 0]
        time = np.arange(len(q), dtype=float) * float(alone.opt.timestep)
        answer = qd if case.law.command is Command.VELOCITY else q
        whole_course = bool(np.isfinite(q).all())
        found[course] = Trace(time, answer, qd, moved.torque[BEFORE:, 0]) if whole_course else None
    return found


def _carried(moved: Trace, law: Trace, scale: float) -> bool:
    """Whether a simulated torque comes to rest as the law's does: a drive that its step does not carry rattles on."""
    import numpy as np

    def swing(trace: Trace) -> float:
        tail = trace.torque[-max(round(TAIL * len(trace.torque)), 2) :]
        return float(np.ptp(tail))

    return swing(moved) <= 2.0 * swing(law) + RATTLES * scale


def _difference(moved: Trace, law: Trace, size: float) -> float:
    """Largest difference of two answers, as a share of the amplitude."""
    import numpy as np

    at = np.interp(moved.time, law.time, law.answer)
    return float(np.abs(moved.answer - at).max()) / abs(size)


def _with_changes(rows: Sequence[Compared], joints: Sequence[str]) -> tuple[Compared, ...]:
    """In order, each with what it changes of PD and limit."""
    bare = {(row.actuator.joint, row.course): row for row in rows if row.variant == "ideal_pd"}
    found = []
    for row in rows:
        other = bare.get((row.actuator.joint, row.course))
        change = None if other is None else _difference(row.law, other.law, other.amplitude)
        found.append(replace(row, change=change))
    order = {name: place for place, name in enumerate(joints)}
    courses = list(SHARES)

    def place(row: Compared) -> tuple[int, int, int]:
        return order[row.actuator.joint], NAMES.index(row.variant), courses.index(row.course)

    return tuple(sorted(found, key=place))


def _findings(rows: Sequence[Compared], step: float, integrator: str) -> Iterator[Diagnostic]:
    """One for each actuator that the step does not carry."""
    bad: dict[str, list[Compared]] = {}
    for row in rows:
        if not row.stable:
            bad.setdefault(row.actuator.joint, []).append(row)
    # A step that is implicit already gains nothing by the other implicit one.
    steps = "" if integrator.startswith("implicit") else "integrator implicitfast, "
    for joint, mine in bad.items():
        first = mine[0]
        others = f" (and of {len(first.joints) - 1} more)" if len(first.joints) > 1 else ""
        swing = (
            "diverges"
            if any(row.simulated is None for row in mine)
            else "rattles where the law comes to rest"
        )
        variants, courses = (
            list(dict.fromkeys(getattr(row, of) for row in mine)) for of in ("variant", "course")
        )
        yield Diagnostic(
            "CMP001",
            Severity.WARNING,
            f"a step of {step * 1e3:g} ms with {integrator} does not carry the drive{others}, which {swing} in MuJoCo "
            f"({listed(variants)}; {listed(courses)}): h kd / J is {first.explicit_ratio:.3g}",
            joint,
            first.actuator.span,
            help=f"{steps}a shorter timing.physics_dt, or less kd",
        )
