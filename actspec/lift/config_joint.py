"""One joint of a configuration: what its class makes of what is written."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from actspec.diagnostics import listed, one_line
from actspec.fields import units_of
from actspec.ir import (
    AsymmetricCurve,
    Command,
    Delay,
    JointActuator,
    JointKind,
    Level,
    Network,
    Quantity,
    Randomization,
    assumed,
    stated,
    unknown,
)
from actspec.lift.curves import curve_of, limit_of, no_curve, remarks
from actspec.lift.figures import NONE_FROM, counted, delay_of_steps, quantity_of, real_limit
from actspec.readings.actions import command_of
from actspec.readings.artifact import ActuatorGroup, Framework, RobotConfig
from actspec.readings.config import (
    control_of,
    control_of_group,
    figures_of,
    is_network,
    is_own_class,
    lags_of,
)
from actspec.readings.isaaclab import CURVE, has_curve, idle_speeds
from actspec.readings.networks import stated_manifest
from actspec.readings.versions import Versions, is_native
from actspec.robot.view import JointView
from actspec.simulators.isaaclab import CLIPPING_AT_SOLVERS, NEW_NAMES, OLD_NAMES
from actspec.units import format_quantity

HELD_FROM = 1_000_000
"""Steps between two draws from which on a lag is held for an episode. Chosen: hours at any physics step."""

_BY_ANGLE = "joint_parameter_lookup"
"""Setting of Isaac Lab's `RemotizedPDActuatorCfg`."""

_COMMANDS = {command.value: command for command in Command}


@dataclass
class ConfigJoint:
    """One joint of one group.

    Attributes:
        config: The configuration.
        group: Its group.
        joint: Name of the joint.
        pattern: What selects it.
        named: All joints of the robot.
        view: The joint in the robot's file; None: there is none.
        versions: What the configuration is written for.
        physics_dt: The simulation's step [s]; None: nobody states it.
        earlier: Groups before it that have the joint too, each with what selects it.
        notes: What a spec cannot hold, or says otherwise; complete once the actuator is made.
    """

    config: RobotConfig
    group: ActuatorGroup
    joint: str
    pattern: str
    named: tuple[str, ...]
    view: JointView | None
    versions: Versions
    physics_dt: float | None
    earlier: Sequence[tuple[ActuatorGroup, str]] = ()
    notes: list[str] = field(default_factory=list, init=False)

    def __post_init__(self) -> None:
        """What its class makes of the settings."""
        config, group = self.config, self.group
        self._control = drive_kind(config.framework, group)
        speeds = idle_speeds(config.framework, self._control)
        self._idle = tuple(name for name in speeds if name in group.settings)
        used = {name: setting for name, setting in group.settings.items() if name not in self._idle}
        acting = replace(group, settings=used)
        self._figures = figures_of(
            config.unrolled,
            acting,
            self.joint,
            self.pattern,
            self.named,
            self.versions,
            self.physics_dt,
            self.earlier,
        )
        if config.framework is Framework.MJLAB and self._control == "network":
            # Its learned class is a DC motor. Source: mjlab 1.6.0, learned_actuator.py.
            speed = self._figures.pop("velocity_limit", None)
            self._figures |= {} if speed is None else {"no_load_speed": speed}
        self._kind = JointKind.HINGE if self.view is None else self.view.kind
        self._units = units_of(self._kind)
        self._own = is_own_class(group)
        self._curved = config.framework is Framework.ISAACLAB and has_curve(group)

    def actuator(self, randomize: tuple[Randomization, ...]) -> JointActuator:
        """The joint's actuator.

        Args:
            randomize: Its ranges.
        """
        units = self._units
        network = self._network()
        kp, kd, command = self._gains()
        if network is not None:
            kp = kd = None
        curve = self._curve()
        stall = None if curve is not None else self._line("stall_torque", units.torque)
        speed = None if curve is not None else self._line("no_load_speed", units.speed)
        if stall is None or speed is None or not self._is_line(stall, speed):
            self._note_half_line()
            stall = speed = None
        level = Level.IDEAL_PD
        if network is not None:
            level = Level.ACTUATOR_NET
        elif curve is not None or stall is not None:
            level = Level.DC_MOTOR
        coulomb, static = self._dry_friction()
        self._note_class()
        return JointActuator(
            joint=self.joint,
            kind=self._kind,
            group=self.group.name,
            pattern=self.pattern,
            level=level,
            command=command,
            kp=kp,
            kd=kd,
            effort_limit=self._effort_limit(),
            velocity_limit=real_limit(self._figure("velocity_limit", units.speed)),
            stall_torque=stall,
            no_load_speed=speed,
            curve=curve,
            peak_torque=unknown(units.torque),
            continuous_torque=unknown(units.torque),
            armature=self._figure("armature", units.inertia, self._kept("armature")),
            reflected_inertia=unknown(units.inertia),
            friction_coulomb=coulomb,
            friction_static=static,
            friction_viscous=self._figure(
                "joint_damping", units.velocity_gain, self._kept("viscous friction")
            ),
            filter_cutoff=self._optional("filter_cutoff", "Hz"),
            command_range=self._command_range(command),
            delay=self._delay(),
            encoder_bias=self._optional("encoder_bias", units.position)
            or assumed(0.0, units.position, "no bias is stated"),
            action_scale=self._optional("action_scale", ""),
            default_position=self._default_position(),
            position_range=self._position_range(),
            network=network,
            randomize=randomize,
            span=self.group.span,
        )

    def _figure(self, name: str, unit: str, silent: str | None = None) -> Quantity:
        """A figure of the ledger; unknown where nothing is written, `silent` says what that means."""
        found = self._figures.get(name)
        if found is None:
            return unknown(unit, silent)
        return quantity_of(found, unit)

    def _optional(self, name: str, unit: str) -> Quantity | None:
        found = self._figures.get(name)
        return None if found is None else quantity_of(found, unit)

    def _kept(self, name: str) -> str | None:
        """What stands where a configuration does not state a number of the joint itself."""
        if self.config.framework is Framework.ISAACLAB:
            return "the USD's own"
        if self.config.framework is Framework.MJLAB and name in ("armature", "frictionloss"):
            return f"the model's own {name} from mjlab 1.3 on, 0 before"
        if self.config.framework is Framework.MJLAB:
            return f"the model's own {name}"
        return None

    def _gains(self) -> tuple[Quantity | None, Quantity | None, Command]:
        """kp, kd and what the command means: a drive without stiffness follows a speed, one without gains a torque."""
        units = self._units
        kp = self._figure("kp", units.stiffness, self._kept("stiffness"))
        kd = self._figure("kd", units.velocity_gain, self._kept("damping"))
        command = self._named_command()
        if command is None:
            command = Command(command_of(self._control, self._figures))
            if command is not Command.POSITION and self._control not in ("velocity", "motor"):
                zero = self._figures["kp"]
                why = (
                    "stiffness 0"
                    if zero.stated
                    else "no key of stiffness is for it, which is 0 in Isaac Lab 2.x"
                )
                self.notes.append(f"{why}: the command is {_ARTICLE[command]}")
        return (
            kp if command is Command.POSITION else None,
            None if command is Command.EFFORT else kd,
            command,
        )

    def _named_command(self) -> Command | None:
        """What the command is in so many words; our own class only reads them for its filter and its clamp."""
        written = self.group.settings.get("command")
        if written is None or not (self._own or self.config.framework is Framework.DEPLOY):
            return None
        readers = ("filter_cutoff", "command_low", "command_high")
        if self._own and not any(name in self._figures for name in readers):
            return None
        return _COMMANDS.get(str(written.value))

    def _table(self) -> tuple[float, float] | None:
        """Least and largest torque of a limit by angle [N*m or N]; None where it cannot be read.

        Rows are [angle, ratio, torque]; its class has no other limit of its own. Source: Isaac Lab 2.3.2,
        actuator_pd.py, RemotizedPDActuator: effort_limit becomes inf, and the torque is clipped by the third column.
        """
        setting = self.group.settings[_BY_ANGLE]
        rows = setting.value if setting.unknown is None and isinstance(setting.value, tuple) else ()
        torques = [row[2] for row in rows if isinstance(row, tuple) and len(row) == 3]
        real = [float(t) for t in torques if isinstance(t, int | float) and 0.0 <= t < math.inf]
        return (min(real), max(real)) if rows and len(real) == len(rows) and max(real) > 0.0 else None

    def _peak(self) -> Quantity:
        """The largest torque of a limit by angle, in place of it."""
        unit, setting = self._units.torque, self.group.settings[_BY_ANGLE]
        ends = self._table()
        if ends is None:
            return unknown(
                unit, f"it depends on the angle, by a table that is not known ({_BY_ANGLE})", setting.span
            )
        low, high = (format_quantity(end, unit, 4) for end in ends)
        self.notes.append(
            f"its torque limit depends on the angle, {low} to {high} by a table at line {setting.span.line} "
            f"({_BY_ANGLE}): effort_limit is its peak, too strong at other angles; `linkages` can hold the table"
        )
        return stated(ends[1], unit, setting.span)

    def _effort_limit(self) -> Quantity:
        unit = self._units.torque
        if self._curved:
            found, remark = limit_of(self._figures, self._solvers_name(), unit)
            self.notes += [remark] if remark else []
            return found
        by_angle = _BY_ANGLE in self.group.settings and self.config.framework is Framework.ISAACLAB
        found = self._peak() if by_angle else self._figure("effort_limit", unit, self._no_limit())
        if found.value is not None and found.value >= NONE_FROM:
            return real_limit(found)
        solver = self._figures.get("solver_effort_limit")
        if solver is None or solver.value is None or solver.value >= NONE_FROM:
            return found
        name = self._solvers_name()
        clips = f"the solver clips at {solver.value:g} {unit} too ({name})"
        model = self._figures.get("effort_limit")
        if found.value is not None or (model is not None and model.stated):
            if solver.value < (found.value or 0.0):
                self.notes.append(f"{clips}, below effort_limit")
            return found
        if model is not None:
            self.notes.append(
                f"effort_limit is {name}, {solver.value:g} {unit}, where the solver clips; the model: {model.why}"
            )
            return quantity_of(solver, unit)
        own = None if self.view is None else self.view.effort_range
        usds = f"outside {CLIPPING_AT_SOLVERS} the model clips at the USD's limit"
        if own is not None and max(own) < solver.value:
            self.notes.append(f"{clips}; {usds}: the robot file's, which is lower, is taken")
            return found
        self.notes.append(
            f"effort_limit is {name}, {solver.value:g} {unit}, where the solver clips; {usds} too, if that is lower"
        )
        return quantity_of(solver, unit)

    def _solvers_name(self) -> str:
        """What the group calls the limit of the solver."""
        names = (OLD_NAMES.solver_effort, NEW_NAMES.solver_effort)
        return next((name for name in names if name in self.group.settings), names[0])

    def _no_limit(self) -> str | None:
        if self.config.framework is Framework.ISAACLAB and self._control != "implicit":
            if self.group.bases and not self._own:
                return f"no effort_limit, and what {one_line(self.group.cls)} clips at is not known here"
            return f"{CLIPPING_AT_SOLVERS} do not clip then, others at the USD's"
        return self._kept("limit") if self.config.framework is Framework.ISAACLAB else None

    def _line(self, name: str, unit: str) -> Quantity | None:
        """A point of the torque-speed line; None without one, or where it is put out of the way."""
        found = self._optional(name, unit)
        if found is None or not (self._own or self._control in ("dc_motor", "network")):
            return None
        return None if found.value is not None and found.value >= NONE_FROM else found

    def _curve(self) -> AsymmetricCurve | None:
        curve = curve_of(self._figures, self._units.torque, self._units.speed)
        if curve is None:
            return None
        lost = no_curve(curve)
        if lost is not None:
            self.notes += [lost] if lost else []
            return None
        # The torque may fall from standstill on: a knee at 0 is a figure like another.
        parts = (curve.drive_torque, curve.brake_torque, curve.knee_speed, curve.no_load_speed)
        points = [part for part in parts if part is not curve.knee_speed or part.value != 0.0]
        return curve if self._is_line(*points) else None

    def _is_line(self, *points: Quantity) -> bool:
        """Whether all points of a torque-speed line are known and above 0; says so where they are not."""
        wrong = next((p for p in points if p.value is None or not 0.0 < p.value < math.inf), None)
        if wrong is not None:
            why = wrong.note or "not known" if wrong.value is None else f"{wrong.value:g} {wrong.unit}"
            self.notes.append(f"its torque-speed line is left out: a point of it is {why}")
        return wrong is None

    def _note_half_line(self) -> None:
        """Say which end is missing of a class that cannot be made without its line."""
        ends = {"saturation_effort": "stall_torque", "velocity_limit": "no_load_speed"}
        missing = [name for name, figure in ends.items() if figure not in self._figures]
        if self._control in ("dc_motor", "network") and len(missing) == 1:
            solvers = " (velocity_limit_sim is the solver's)" if "velocity_limit" in self._figures else ""
            self.notes.append(
                f"its torque-speed line is left out: no {missing[0]}{solvers}, without which {self.group.cls} cannot "
                "be built"
            )

    def _dry_friction(self) -> tuple[Quantity, Quantity | None]:
        """Sliding friction, and the static one where it is another number."""
        unit = self._units.torque
        isaaclab = self.config.framework is Framework.ISAACLAB
        sliding = self._figure("frictionloss", unit, self._kept("friction" if isaaclab else "frictionloss"))
        static = self._optional("friction_static", unit)
        return sliding, None if static is None or static.value == sliding.value else static

    def _default_position(self) -> Quantity:
        """The position at zero action: the robot's default position, unless the action term has one of its own."""
        zero, unit = self._figures.get("action_zero"), self._units.position
        if zero is None:
            return self._figure("default_position", unit)
        start = self._figures.get("start")
        if zero.value is not None and start is not None and start.value is not None:
            ends = [format_quantity(value, unit) for value in (zero.value, start.value)]
            self.notes.append(
                f"default_pose is {ends[0]}, the command at zero action (line {zero.span.line}); that it starts at "
                f"{ends[1]} is left out"
            )
        return quantity_of(zero, unit)

    def _command_range(self, command: Command) -> tuple[Quantity, Quantity] | None:
        ends = next((one for one in ("command", "clip") if f"{one}_low" in self._figures), None)
        if ends is None and "command_high" not in self._figures:
            return None
        units = self._units
        unit = {Command.POSITION: units.position, Command.VELOCITY: units.speed, Command.EFFORT: units.torque}
        low, high = (self._figure(f"{ends or 'command'}_{end}", unit[command]) for end in ("low", "high"))
        if ends == "clip" and (why := _not_carried(low, high)):
            line = "" if low.span is None else f" (line {low.span.line})"
            self.notes.append(f"command_range is left out: the action's clip{line} {why}")
            return None
        return low, high

    def _delay(self) -> Delay | None:
        """Physics steps in the frameworks, seconds in a deploy file; Isaac Lab 3.0 has one lag, the largest."""
        if self.config.framework is Framework.DEPLOY:
            return self._delay_in_seconds()
        low, high = lags_of(self.config.framework, self.group, self.versions)
        step, sampling, losses = self.physics_dt, "episode", list[str]()
        if self.config.framework is Framework.MJLAB:
            sampling, losses = _mjlab_sampling(self.group)
        if high is None:
            return None
        most, least = high.number, 0.0 if low is None else low.number
        if least is None or most is None:
            why = high.unknown or (low.unknown if low else None)
            return Delay(unknown("s", why, high.span), 0.0, 0.0, sampling)
        if most == 0.0 == least:
            return None
        if not _is_range(least, most):
            self.notes.append(f"delay: {counted(least, most)} physics steps, which is none")
            return None
        delay, notes = delay_of_steps(least, most, step, high.span, sampling)
        self.notes += notes or (losses if least < most else [])
        return delay

    def _delay_in_seconds(self) -> Delay | None:
        nominal, low, high = (
            self._optional(name, "s") for name in ("delay_nominal", "delay_low", "delay_high")
        )
        if nominal is None and (low is None or high is None):
            return None
        middle = None if nominal is None else nominal.value
        ends = [end.value for end in (low, high) if end is not None and end.value is not None]
        if len(ends) != 2:
            ends = [middle or 0.0] * 2
        middle = ends[0] if middle is None else middle
        if not (_is_range(ends[0], middle) and _is_range(middle, ends[1])):
            self.notes.append(f"delay: {middle:g} s in {ends[0]:g} to {ends[1]:g} s, which is none")
            return None
        place = None if high is None else high.span
        return Delay(nominal or unknown("s", "a range", place), ends[0], ends[1], "episode")

    def _position_range(self) -> tuple[float, float] | None:
        if self.view is not None:
            return self.view.range
        if self.config.framework is not Framework.DEPLOY:
            return None
        low, high = (self._figure(f"position_{end}", "").value for end in ("low", "high"))
        return None if low is None or high is None else (low, high)

    def _network(self) -> Network | None:
        reading = self.group.network
        if self._control != "network":
            if reading is not None:
                self.notes.append(f"the network {reading.file} beside the gains is left out")
            return None
        stated = stated_manifest(self.config.framework, self.group, self.physics_dt)
        unused = [name for name in ("stiffness", "damping") if name in self.group.settings]
        if self.config.framework is Framework.LEGGED_GYM and unused:
            why = "use_actuator_network: the network gives the torque"
            self.notes.append(f"{' and '.join(unused)} are left out, which training does not use ({why})")
        if reading is None:
            return Network("", None, self.group.span, *stated)
        file = reading.path or below_root(reading.file, reading.span.path) or reading.file
        if reading.manifest is not None:
            return Network(file, reading.manifest.path, reading.span)
        return Network(file, None, reading.span, *stated)

    def _note_class(self) -> None:
        group = self.group
        ignored = self._control == "implicit" and "velocity_limit" in group.settings
        if ignored and "velocity_limit" not in self._figures and not is_native(self.versions):
            value = group.settings["velocity_limit"].value
            shown = f" {value:g}" if isinstance(value, float | int) else ""
            self.notes.append(f"velocity_limit{shown} is left out: an implicit drive ignores it")
        for own in ("effort_limit", "velocity_limit") if self._control == "implicit" else ():
            pair = [group.settings.get(name) for name in (own, f"{own}_sim")]
            values = [
                one.value for one in pair if one is not None and one.unknown is None and one.value is not None
            ]
            # In 3.0 both names are aliases of one field. The audit says it too (LIM106).
            if len(values) == 2 and values[0] != values[1] and not is_native(self.versions):
                self.notes.append(
                    f"{own} and {own}_sim differ: Isaac Lab 2.x raises ValueError when it builds the group; "
                    f"{own}_sim is taken"
                )
        efforts = (OLD_NAMES.effort, NEW_NAMES.effort) if self._curved else ()
        for name in (*self._idle, *efforts):
            setting = group.settings.get(name)
            if setting is None or setting.value is None or (setting.number or 0.0) >= NONE_FROM:
                continue
            names = NEW_NAMES if is_native(self.versions) else OLD_NAMES
            shown = "" if setting.number is None else f" {setting.number:g}"
            line = f"its class clips by {', '.join(CURVE)} alone" if self._curved else _NO_LINE
            usds = f"; the solver's limit is {names.solver_velocity}, else the USD's own"
            self.notes.append(f"{name}{shown} is left out: {line}{'' if name in efforts else usds}")
        if self._own:
            self.notes.append(f"{group.cls} is read as the class that actspec writes")
        elif self._curved:
            self.notes += remarks(group, self._figures, self._kind)
        elif self.config.framework is Framework.LEGGED_GYM:
            if group.own:
                self.notes.append(
                    f"control has {listed(group.own)} of its own: what that does is not known here"
                )
        elif group.bases or group.own:
            alike = (base for base in group.bases if control_of(self.config.framework, base) == self._control)
            # A run's file of mjlab has the fields of a class, and not its name.
            cls, base = (group.cls, next(alike, group.bases[0])) if group.bases else ("its class", group.cls)
            own = f" with {listed(group.own)}" if group.own else ""
            self.notes.append(f"{cls} is read as {base}: what else it does{own} is not known here")


def drive_kind(framework: Framework, group: ActuatorGroup) -> str:
    """What drives a group's joints, in the words of the ledger."""
    return "network" if is_network(framework, group) else control_of_group(framework, group)


def below_root(path: str, config: str) -> str | None:
    """A file that legged_gym names below its own folder (`{LEGGED_GYM_ROOT_DIR}/...`), which is above a configuration.

    Args:
        path: As the configuration names it.
        config: The configuration's own path.

    Returns: None where it is named another way, or is not there.
    """
    below = re.fullmatch(r"\{\w+\}/([^\0]+)", path)
    if below is None:
        return None
    folder = os.path.dirname(config)
    for _ in range(_ABOVE):
        if os.path.isfile(found := os.path.normpath(os.path.join(folder, below[1]))):
            return found
        folder = os.path.join(folder, os.pardir)
    return None


_ABOVE = 6
"""Folders in which the file of `{LEGGED_GYM_ROOT_DIR}/...` is looked for. Chosen: forks have the configuration three or
four below their root."""

_NO_LINE = "an explicit drive without a torque-speed line uses it nowhere"

_ARTICLE: Mapping[Command, str] = {Command.VELOCITY: "a speed", Command.EFFORT: "a torque"}


def _not_carried(low: Quantity, high: Quantity) -> str | None:
    """Why a clip is no `command_range`; None where it is one."""
    if low.value is None:
        return f"is not known: {low.note}"
    ends = [end for end in (low, high) if abs(end.require()) < NONE_FROM]
    if len(ends) == 2:
        return None
    (end,) = ends
    place = "[LOW, {}]" if end is high else "[{}, HIGH]"
    text = format_quantity(end.require(), end.unit)
    return f"has one end, {text}: write {place.format(text)} with another that no command reaches"


def _is_range(low: float, high: float) -> bool:
    return 0.0 <= low <= high < math.inf


def _mjlab_sampling(group: ActuatorGroup) -> tuple[str, list[str]]:
    """When mjlab draws a lag anew. Source: mjlab 1.6.0, actuator.py; without a period, in every step."""

    def number(name: str) -> float:
        setting = group.settings.get(name)
        return (setting.number if setting is not None else None) or 0.0

    period, hold = number("delay_update_period"), number("delay_hold_prob")
    notes = []
    if hold:
        notes.append(
            f"delay: a lag is kept with probability {hold:g} (delay_hold_prob), which a spec cannot express"
        )
    if period >= HELD_FROM:
        return "episode", notes
    if period > 1:
        notes.append(f"delay: a lag is drawn every {period:g} steps, a spec has every step or every episode")
    return "step", notes
