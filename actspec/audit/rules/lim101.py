from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import ClassVar

from actspec.audit.case import MODELS
from actspec.audit.known import likenesses
from actspec.audit.rule import Case, Confidence, Finding, RuleInParts, Severity
from actspec.audit.rules.actuator_texts import clamps_not_in_force, is_turned, ranges_not_in_force
from actspec.audit.rules.clamped import TIMES, Bounded, bound_of, by_command, input_of, is_in_doubt
from actspec.audit.rules.joints import (
    effort_noun,
    folders_in_common,
    is_called_undriven,
    is_driven_by_mjlab,
    is_exporters,
    is_nobodys,
    own_figure,
    partner_rows,
    shown,
    unit,
)
from actspec.audit.rules.limits_of_files import (
    LIMITS,
    WITHOUT,
    few_zeros,
    furniture,
    limited_by_own,
    mimics,
    round_for_all,
    taken_by_gym,
)
from actspec.audit.rules.src101 import placeholders_beside_limits
from actspec.audit.rules.urdf_drives import is_left_undriven, wheel_drive
from actspec.diagnostics import Span
from actspec.fields import FIELDS, GRAVITY, LONGEST_LEVER, PLACEHOLDER
from actspec.ir import JointKind
from actspec.readings.artifact import FileKind, Setting
from actspec.readings.drive import largest
from actspec.readings.ledger import LedgerRow
from actspec.robot.view import ActuatorView
from actspec.units import format_number, format_quantity

_URDF = {
    "effort_limit": "the URDF's effort is 0: MuJoCo reads it as no limit, and a tool that sets up drives from it as a "
    "joint that can give nothing",
    "velocity_limit": "the URDF's velocity is 0: MuJoCo leaves it out, and a solver that enforces it holds the joint",
}

_LINE = {
    "stall_torque": "the stall torque is 0: the drive cannot move the joint",
    "no_load_speed": "the no-load speed is 0: the torque-speed line divides by it, and the torque is not a number",
}

_BOTH_ZERO = (
    "the URDF's effort and velocity are 0: MuJoCo reads them as no limit, a tool that sets up drives from them as a "
    "joint that can give nothing and is held"
)


class NoEffectiveLimit(RuleInParts):
    code = "LIM101"
    name = "no-effective-limit"
    noted_in_folders = True
    aliases: ClassVar[dict[str, str]] = {
        "LIM101": "no-limit-of-any-kind",
        "LIM102": "limit-is-a-placeholder",
        "LIM103": "limit-of-zero",
    }
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    paired = True
    needs = "no file states an effort or velocity limit, and no MJCF has actuators on joints"
    options: ClassVar[dict[str, float]] = {"least": PLACEHOLDER}

    def subjects(self, case: Case) -> Iterator[Iterable[Finding]]:
        written = ranges_not_in_force(case, "force")
        clamps = {name: ranges_not_in_force(case, name) for name in ("ctrl", "act")}
        of_joints = clamps_not_in_force(case)
        held: dict[Span, Bounded] = {}
        for index, artifact in case.of_kind(FileKind.MJCF):
            limited = _limited_elsewhere(case, index)
            speaks = _limits_most(case, index)
            views = {} if artifact.robot is None else {view.span: view for view in artifact.robot.actuators}
            meant = _is_unlimited_by_intent(case, index)
            driven = Counter(row.joint for row in case.rows_of(index) if row.control != "none")
            for row in case.rows_of(index):
                if row.control in ("position", "pid") and row.joint and driven[row.joint] == 1:
                    yield self._one_way(case, row, views.get(row.span))
                if row.control != "none" and row.joint:
                    bounded = self._held(case, row, views.get(row.span))
                    if bounded is not None:
                        held[row.span] = bounded
                    elsewhere = limited.get(row.joint)
                    free = row.effort_limit == math.inf
                    # mjlab drives the model by actuators of its own.
                    if elsewhere is not None and (not speaks or is_driven_by_mjlab(case, row)):
                        free = False
                    view = views.get(row.span)
                    looked = free and not _is_bounded(row, view) and not _is_empty(written.get(row.span))
                    looked = looked and not is_turned(case, row, view)
                    off = of_joints.get((index, row.joint))
                    missing = (
                        self._missing(
                            case, row, view, written.get(row.span), off, clamps[input_of(view)].get(row.span)
                        )
                        if looked
                        else ()
                    )
                    if elsewhere is not None:
                        missing = (_beside(one, elsewhere) for one in missing)
                    quiet = (meant and row.span not in written and off is None) or is_called_undriven(row)
                    yield (replace(one, severity=Severity.INFO) for one in missing) if quiet else missing
        for _, artifact in case.of_kind(FileKind.CFG):
            settings = {} if artifact.config is None else artifact.config.settings
            if (factor := settings.get("soft_joint_pos_limit_factor")) is not None:
                yield self._soft(factor)
        followers = case.once(mimics)
        for row in case.rows:
            if row.effort_limit == math.inf and _is_empty(written.get(row.span)):
                yield (self._empty(row, written[row.span]),)
            idle = (row.artifact, row.joint) in followers or row.kp == row.kd == 0.0
            undriven = is_called_undriven(row) or _is_passive(case, row)
            limits = {field: getattr(row, field) for field in LIMITS if field in row.stated}
            urdf = case.artifacts[row.artifact].kind is FileKind.URDF
            gym = None if idle or undriven or _is_overruled(case, row) else taken_by_gym(case, row)
            if gym is not None:
                yield (self._taken_by_gym(row, *gym),)
                continue
            if urdf and not idle and limits == dict.fromkeys(LIMITS, 0.0):
                nothing = self._zero(row, "effort_limit", _BOTH_ZERO)
                quiet = undriven or row.artifact in case.once(few_zeros) or _is_overruled(case, row)
                yield self._heard(case, row, (nothing,), quiet)
                continue
            if urdf and is_exporters(row):
                yield self._heard(case, row, self._exporters(case, row), _is_overruled(case, row))
                continue
            if all(self._is_placeholder(case, row, field) for field in LIMITS):
                yield self._heard(case, row, (_graver(case, row, self._placeholders(row, limits)),))
                continue
            for field, effect in _LINE.items() if case.artifacts[row.artifact].kind is FileKind.CFG else ():
                if field in row.stated and getattr(row, field) == 0.0 and not idle:
                    worst = Severity.ERROR if field == "no_load_speed" else self.severity
                    severity = Severity.INFO if undriven else worst
                    yield (replace(self._zero(row, field, effect), severity=severity),)
            for field, limit in limits.items():
                mass = None if limit is None else case.once(round_for_all).get((row.artifact, limit))
                if mass is not None and field == "effort_limit" and not undriven:
                    yield self._heard(case, row, (_graver(case, row, self._round(case, row, limit, mass)),))
                elif limit is not None:
                    found = self._stated(case, row, field, limit, idle, undriven)
                    if field == "effort_limit" and row.span in held:
                        found = self._held_back(case, row, limit, held[row.span])
                    yield self._heard(case, row, found)

    def _heard(
        self, case: Case, row: LedgerRow, found: Iterable[Finding], quiet: bool = False
    ) -> Iterator[Finding]:
        """Of limits, notes where nothing takes them, and where a plugin of the file has a torque of the wheel."""
        for one in found:
            drive = wheel_drive(case, row) if one.value and "effort_limit" in one.fields else None
            if drive is not None and drive.most < (one.value or 0.0):
                torque = shown(row, "effort_limit", drive.most, 6)
                message = f"{one.message}; in Gazebo {drive.plugin} drives it with {torque} at most"
                related = (*one.related, drive.place)
                yield replace(one, message=message, related=related, severity=Severity.INFO)
            elif quiet or row.artifact in case.once(furniture) or is_left_undriven(case, row):
                yield replace(one, severity=Severity.INFO)
            else:
                yield one

    def _soft(self, setting: Setting) -> Iterator[Finding]:
        """Of a share of the joints' ranges that is none."""
        factor = setting.number
        if factor is None or 0.0 < factor <= 1.0:
            return
        effect = (
            "the soft limits lie outside of the joints' ranges, and limit nothing"
            if factor > 1.0
            else "no position lies within the soft limits"
        )
        message = f"soft_joint_pos_limit_factor is {factor:g}: {effect}"
        help = "it is the share of each joint's range: above 0, at most 1"
        yield Finding(self.code, message, setting.span, value=factor, help=help)

    def _held(self, case: Case, row: LedgerRow, view: ActuatorView | None) -> Bounded | None:
        """What is said where the clamped command of a servo bounds its torque below a limit that is a placeholder."""
        limit = row.effort_limit
        if view is None or limit is None or not self.option(case, "least") <= limit < math.inf:
            return None
        bound, how = bound_of(row, view)
        if bound is None or bound >= limit:
            return None
        bounded = by_command(case, row, view, bound, how)
        # Motors of one robot differ, but not so far: who wrote limits beside it left this one out.
        beside = [
            other
            for other in case.rows_of(row.artifact)
            if other.kind is row.kind and 0.0 < (other.effort_limit or 0.0) < self.option(case, "least")
        ]
        most = max(beside, key=lambda other: other.effort_limit or 0.0, default=None)
        far = most is not None and bound >= TIMES * (most.effort_limit or 0.0)
        if bounded.confidence is not None or most is None or not far or is_in_doubt(case, row):
            return bounded
        limit_there = own_figure(most, "effort_limit", 6)
        effect = f"{bounded.effect}, and no other joint of the file has more than {limit_there}"
        return Bounded(effect, most, self.confidence)

    def _held_back(self, case: Case, row: LedgerRow, limit: float, bounded: Bounded) -> Iterator[Finding]:
        """Of a placeholder that a clamped command's bound makes idle: a note, unless that is far above other limits."""
        for one in self._stated(case, row, "effort_limit", limit, False, False):
            yield replace(
                one,
                message=one.message.replace("and it limits nothing", f"and {bounded.effect}"),
                related=bounded.related,
                severity=Severity.INFO if bounded.confidence is None else one.severity,
                confidence=bounded.confidence,
            )

    def _missing(
        self,
        case: Case,
        row: LedgerRow,
        view: ActuatorView | None,
        written: tuple[float, float] | None,
        of_joint: tuple[float, float] | None,
        clamp: tuple[float, float] | None,
    ) -> Iterator[Finding]:
        """Of an actuator without a limit, with the ranges of force, joint and control that are not in force."""
        noun = effort_noun(row)
        bound, how = bound_of(row, view) if view is not None else (None, "")
        bounded = Bounded(f"its {noun} is unlimited", None, self.confidence)
        if bound is not None:
            bounded = by_command(case, row, view, bound, how)
        name, off, times = "force", written, 1.0 if view is None else abs(view.gear)
        if written is None:
            name, off, times = "actuatorfrc", of_joint, 1.0
        if off is None:
            what = "no force range or joint limit limits this actuator"
            if bound is None:
                what = f"no force range, joint limit or {_INPUTS[input_of(view)]} range limits this actuator"
            if clamp is not None:
                vain = _switched_off(input_of(view), clamp)
                what = f"no force range or joint limit limits this actuator, and {vain}"
        else:
            what = _switched_off(name, off)
            if bound is not None and view is not None and bound <= times * largest(off):
                return
        yield Finding(
            self.code,
            f"{what}: {bounded.effect}",
            row.span,
            row.joint,
            help=f"leave {name}limited out, or the range"
            if off is not None
            else "add actuatorfrcrange to the joint, or forcerange to the actuator"
            + (f", or leave {input_of(view)}limited out" if clamp is not None else ""),
            related=bounded.related,
            fields=("effort_limit",),
            severity=Severity.INFO if bounded.confidence is None and off is None else self.severity,
            confidence=None if off is not None else bounded.confidence,
            about="" if bound is None else shown(row, "effort_limit", bound),
        )

    def _is_placeholder(self, case: Case, row: LedgerRow, field: str) -> bool:
        least = self.option(case, "least")
        nobodys = is_nobodys(row, field, least) and row.span not in case.once(limited_by_own)
        return nobodys and not (field == "effort_limit" and _holds_its_robot(case, row))

    def _round(self, case: Case, row: LedgerRow, effort: float, mass: float) -> Finding:
        """Of a round effort that every hinge of a light robot has, and a slide too."""
        robot, times = f"the whole robot, {format_quantity(mass, 'kg', 3)}", effort / (mass * GRAVITY)
        why = f"every hinge has it, and it would hold {robot}, on a lever of {format_quantity(times, 'm', 3)}"
        if row.kind is JointKind.SLIDE:
            why = f"every hinge has the same figure, and it is {times:.3g} times the weight of {robot}"
        return Finding(
            self.code,
            f"the effort limit of {own_figure(row, 'effort_limit', 6)} is a placeholder: {why}",
            row.place("effort_limit"),
            row.joint,
            effort,
            unit(row, "effort_limit"),
            help="state the motor's effort limit",
            fields=("effort_limit",),
        )

    def _placeholders(self, row: LedgerRow, limits: Mapping[str, float | None]) -> Finding:
        """One finding of both limits."""
        effort, speed = (own_figure(row, field, 6) for field in LIMITS)
        return Finding(
            self.code,
            f"the effort limit of {effort} and the velocity limit of {speed} are placeholders: no motor reaches them, "
            "and they limit nothing",
            row.place("effort_limit"),
            row.joint,
            limits["effort_limit"],
            unit(row, "effort_limit"),
            help="state the motor's effort and velocity limits",
            fields=LIMITS,
        )

    def _exporters(self, case: Case, row: LedgerRow) -> Iterator[Finding]:
        """Limits that nobody stated, where another file of the robot has the motor's.

        Not in a file that gives another joint of that speed, or most of its joints, another effort: somebody wrote
        efforts there.
        """
        stated = [one for one in case.rows_of(row.artifact) if one.effort_limit is not None]
        other_efforts = [one for one in stated if one.effort_limit != row.effort_limit]
        speeds_alike = any(one.velocity_limit == row.velocity_limit for one in other_efforts)
        if speeds_alike or 2 * len(other_efforts) > len(stated):
            return
        others = (
            other for other in partner_rows(case, row) if 0.0 < (other.effort_limit or 0.0) < PLACEHOLDER
        )
        motors = (one for one in others if not is_exporters(one))
        other = max(motors, key=lambda one: folders_in_common(row, one), default=None)
        if other is None or other.effort_limit == row.effort_limit:
            return
        effort, speed = (own_figure(row, field, 6) for field in LIMITS)
        yield Finding(
            self.code,
            f"the effort of {effort} and the velocity of {speed} are what exporters write where nobody states any, and "
            f"another file of the robot has {own_figure(other, 'effort_limit', 6)}",
            row.place("effort_limit"),
            row.joint,
            row.effort_limit,
            unit(row, "effort_limit"),
            expected=other.effort_limit,
            help="state the motor's effort and velocity limits",
            related=(other.place("effort_limit"),),
            fields=LIMITS,
        )

    def _stated(
        self, case: Case, row: LedgerRow, field: str, limit: float, idle: bool, undriven: bool
    ) -> Iterator[Finding]:
        """A limit that a file states: so large that it is none, or 0."""
        if self._is_placeholder(case, row, field):
            nothing = (
                "no motor reaches it" if limit >= PLACEHOLDER else "no joint behind a gear turns so fast"
            )
            found = Finding(
                self.code,
                f"the {FIELDS[field].noun} of {own_figure(row, field, 6)} is a placeholder: {nothing}, and it limits "
                "nothing",
                row.place(field),
                row.joint,
                limit,
                unit(row, field),
                help=f"state the motor's {FIELDS[field].noun}",
                fields=(field,),
                # Few simulators enforce a speed limit at all, and joints without a motor have one too. A slide is more
                # often a base, a lift or a block that is moved than an axis with a motor.
                severity=Severity.INFO if field == "velocity_limit" or row.kind is JointKind.SLIDE else None,
            )
            yield found if found.severity is Severity.INFO else _graver(case, row, found)
        elif limit == 0.0 and not idle:
            urdf = case.artifacts[row.artifact].kind is FileKind.URDF
            effect = (
                _URDF[field] if urdf else f"the {FIELDS[field].noun} is 0: the drive cannot move the joint"
            )
            found = self._zero(row, field, effect)
            # A drive without stiffness and effort is how a configuration writes a bearing.
            bearing = not urdf and row.kp == 0.0
            few = field == "effort_limit" and row.artifact in case.once(few_zeros)
            overruled = field == "effort_limit" and _is_overruled(case, row)
            nobodys = few or overruled or row.artifact in case.once(WITHOUT[field])
            if undriven or bearing or (urdf and nobodys):
                found = replace(found, severity=Severity.INFO)
            yield found

    def _zero(self, row: LedgerRow, field: str, message: str) -> Finding:
        return Finding(
            self.code,
            message,
            row.place(field),
            row.joint,
            0.0,
            unit(row, field),
            help=f"state the motor's {FIELDS[field].noun}",
            fields=(field,),
        )

    def _taken_by_gym(self, row: LedgerRow, config: LedgerRow, other: LedgerRow) -> Finding:
        message = f"the URDF's effort is 0, and {os.path.basename(config.file)} takes it for the joint's torque limit: "
        return _beside(self._zero(row, "effort_limit", f"{message}Isaac Gym gives it no torque"), other)

    def _one_way(self, case: Case, row: LedgerRow, view: ActuatorView | None) -> Iterator[Finding]:
        """Of the only servo of a hinge, without a spring against it, that gives no torque in one direction."""
        robot = case.artifacts[row.artifact].robot
        joint = None if robot is None else robot.joint(row.joint)
        if joint is None or view is None or row.kind is not JointKind.HINGE or joint.stiffness > 0.0:
            return
        own = None if "force_range" in view.unknown else view.force_range
        clamp = None if "effort_range" in joint.unknown else joint.effort_range
        for name, ends in (("forcerange", own), ("actuatorfrcrange", clamp)):
            if ends is None or ends[0] >= ends[1] or ends[0] < 0.0 < ends[1]:
                continue
            most = format_number(largest(ends))
            turned = name == "forcerange" and view.gear < 0.0
            towards = "higher" if (ends[0] < 0.0) is not turned else "lower"
            yield Finding(
                self.code,
                f'{name}="{ends[0]:g} {ends[1]:g}" lets this servo push in one direction alone: it cannot move the '
                f"joint to {towards} positions",
                row.place("effort_limit"),
                row.joint,
                help=f"write -{most} {most}",
                fields=("effort_limit",),
                about=f"{name} {ends[0]:g} {ends[1]:g}",
                confidence=Confidence.MEDIUM,
            )

    def _empty(self, row: LedgerRow, ends: tuple[float, float]) -> Finding:
        """Of a force range whose ends are one."""
        low, high = ends
        message = f'forcerange="{low:g} {high:g}" is no limit: MuJoCo takes an empty range for none'
        found = self._zero(row, "effort_limit", message)
        return found if low == 0.0 else replace(found, value=None, unit=None)


def _holds_its_robot(case: Case, row: LedgerRow) -> bool:
    """Whether a hinge's limit is what it takes to hold the whole robot on a lever that one may have: a crane's is.

    Of a configuration, and of a file without masses, the model that has the joint and the masses tells.
    """
    robots = (case.artifacts[one.artifact].robot for one in (row, *partner_rows(case, row, *MODELS)))
    mass = next((robot.mass for robot in robots if robot is not None and robot.mass), 0.0)
    return row.kind is JointKind.HINGE and (row.effort_limit or 0.0) <= LONGEST_LEVER * mass * GRAVITY


_INPUTS = {"ctrl": "control", "act": "activation"}


def _is_unlimited_by_intent(case: Case, index: int) -> bool:
    """Whether nobody limits any actuator of a model: a pendulum, or one whose limits are in the code that drives it.

    A limit of a known robot, or of a file that is no other MJCF, tells that it was left out.
    """
    driven = [row for row in case.rows_of(index) if row.control != "none" and row.joint]
    if any((row.effort_limit or math.inf) < math.inf for row in driven):
        return False
    if any(row.artifact == index for one in case.once(likenesses) for row, _ in one.joints):
        return False
    others = (
        other
        for row in driven
        for other in partner_rows(case, row)
        if case.artifacts[other.artifact].kind is not FileKind.MJCF
    )
    return all((other.effort_limit or math.inf) == math.inf for other in others)


def _is_overruled(case: Case, row: LedgerRow) -> bool:
    """Whether a configuration states the joint's limit, and a model's 0 is not read."""
    return any((other.effort_limit or 0.0) > 0.0 for other in partner_rows(case, row, FileKind.CFG))


def _is_passive(case: Case, row: LedgerRow) -> bool:
    """Whether a model of the same robot has the joint and drives, and none of them on it: a spring or a rod."""
    others = list(partner_rows(case, row, FileKind.MJCF))
    return bool(others) and all(
        other.control == "none" and any(one.control != "none" for one in case.rows_of(other.artifact))
        for other in others
    )


def _is_bounded(row: LedgerRow, view: ActuatorView | None) -> bool:
    """Whether the voltage of a dcmotor or an activation bounds its torque, or the actuator gives none of its own.

    Of several actuators on one joint that has no limit, each is looked at alone.
    """
    if view is not None and (view.gear == 0.0 or _is_limited_alone(row, view)):
        return True
    # Only a dcmotor whose control is its voltage has back-EMF beside no other gain.
    voltage = row.stall_torque is not None or (bool(row.back_emf) and row.command_range is not None)
    return voltage if row.control == "dcmotor" else row.control == "other" and row.kd is None


def _is_limited_alone(row: LedgerRow, view: ActuatorView) -> bool:
    """Whether an actuator has a range of its own for what it gives, or gives nothing at all."""
    nothing = view.gain == view.offset == 0.0 and "gain" not in view.unknown and not (row.kp or row.kd)
    of_input = (view.control == "motor" or view.is_filled) and view.input_range is not None
    return nothing or of_input or view.force_range is not None


def _limited_elsewhere(case: Case, artifact: int) -> dict[str, LedgerRow]:
    """Joints that a configuration of the same robot limits, with the first row that does."""
    others = [i for i in case.robot_of(artifact).artifacts if case.artifacts[i].kind is FileKind.CFG]
    found: dict[str, LedgerRow] = {}
    for row in (row for other in others for row in case.rows_of(other)):
        if row.effort_limit is not None and row.effort_limit < math.inf:
            found.setdefault(row.joint, row)
    return found


def _limits_most(case: Case, artifact: int) -> bool:
    """Whether a model that somebody named limits half of its driven joints or more: who wrote those meant the rest too.

    Chosen: half. A model whose limits are in the code that drives it has none, or those of a part that it includes.
    """
    if case.is_met(artifact):
        return False
    limits = {
        row.joint: row.effort_limit for row in case.rows_of(artifact) if row.control != "none" and row.joint
    }
    return 2 * sum(0.0 < (limit or 0.0) < PLACEHOLDER for limit in limits.values()) >= len(limits)


def _graver(case: Case, row: LedgerRow, found: Finding) -> Finding:
    """Of a placeholder an error where another file has the joint's limit, as a smaller figure would be by SRC101."""
    other = case.once(placeholders_beside_limits).get((row.artifact, row.joint))
    return found if other is None else replace(_beside(found, other), severity=Severity.ERROR)


def _beside(found: Finding, other: LedgerRow) -> Finding:
    """With the limit that a configuration gives the joint, which does not hold in the model."""
    place, limit = other.place("effort_limit"), own_figure(other, "effort_limit", 6)
    message = f"{found.message}, and {place.path} limits the joint to {limit}"
    return replace(found, message=message, related=(*found.related, place))


def _is_empty(ends: tuple[float, float] | None) -> bool:
    """Whether a range is one that MuJoCo takes for none: of one that begins above its end AUD022 tells."""
    return ends is not None and ends[0] == ends[1]


def _switched_off(name: str, ends: tuple[float, float]) -> str:
    """That a range of `force`, `actuatorfrc`, `ctrl` or `act` is written in vain."""
    return f'{name}range="{ends[0]:g} {ends[1]:g}" is switched off by {name}limited="false"'
