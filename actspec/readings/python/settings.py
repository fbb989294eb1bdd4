"""From folded values to the settings, groups and ranges of a configuration."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from actspec.diagnostics import Collector, Span, shortened
from actspec.patterns import NoExpression, PatternError, compile_pattern
from actspec.readings.artifact import (
    ActionTerm,
    ActuatorGroup,
    Framework,
    RandomizedRange,
    RobotConfig,
    Setting,
)
from actspec.readings.config import IN_FIGURES, OF_ALL_CLASSES
from actspec.readings.python.arithmetic import text_of
from actspec.readings.python.values import (
    MAX_NESTING,
    Cls,
    Data,
    External,
    Func,
    Obj,
    Seq,
    Table,
    Unknown,
    Value,
    ancestors,
    class_names,
    class_roots,
    elsewhere,
    reason_of,
    unread_module,
)

UNFOLDED = "CFG001"
"""Code of what could not be folded."""

NOTHING = "CFG002"
"""Code of a file without any configuration."""

NO_NUMBER = "CFG003"
"""Code of text, or a list, where the framework takes a number or numbers by joint."""

REFUSED = "CFG004"
"""Code of what the framework refuses whatever the robot is: a pattern that is none, groups that are in no dict."""

_OF_ROBOT = frozenset({"physics_dt", "decimation", "soft_joint_pos_limit_factor"})
"""Settings of a whole robot that are numbers, and of no joint."""

MAX_LEAVES = 20_000
"""Numbers and texts in one setting. Chosen: Isaac Lab's largest table has 300."""

_ACTUATOR = re.compile(r"(Actuator|Motor)\w*Cfg(_\w+)?")
"""Class names of actuator cfgs: `DCMotorCfg`, `ActuatorNetMLPCfg`, `UnitreeActuatorCfg_Go2HV`."""

JOINTS = ("joint_names_expr", "target_names_expr")
"""Fields of actuator cfgs that select their joints, of Isaac Lab and of mjlab."""

_PATHS = frozenset({"network_file", "usd_path", "asset_path", "file"})
"""Settings that keep `{NAME}` where a folder is not known."""

Events = Mapping[str, tuple[Mapping[str, str], str]]
"""A framework's randomising functions: parameters to what they randomise, and the operation where none is given."""

_NAMES = frozenset({"class_type", "command_field", "mode", "transmission_type"})
"""Settings whose value is a name of the framework; kept as that name."""


class _NotPlainError(Exception):
    pass


def plain(value: Value) -> tuple[object, str | None]:
    """A value without places: (numbers, texts, tuples and mappings, None) or (None, why it is not known)."""
    left = [MAX_LEAVES]
    try:
        return _plain(value.data, left, 0), None
    except _NotPlainError as err:
        return None, str(err)


def _plain(data: Data, left: list[int], depth: int) -> object:
    left[0] -= 1
    if left[0] < 0 or depth > MAX_NESTING:
        raise _NotPlainError(f"more than {MAX_LEAVES} values, or nested deeper than {MAX_NESTING}")
    if data is None or isinstance(data, (bool, int, float)):
        return data
    if isinstance(data, str):
        return str(data)
    if isinstance(data, Seq):
        return tuple(_plain(one.data, left, depth + 1) for one in data.items)
    if isinstance(data, Table):
        if data.open is not None:
            raise _NotPlainError(data.open)
        found = {}
        for key, one in data.items.items():
            if not isinstance(key, str):
                raise _NotPlainError(f"the key {key!r} is no text")
            try:
                found[key] = _plain(one.data, left, depth + 1)
            except _NotPlainError as err:
                raise _NotPlainError(f"{shortened(key, 40)}: {err}" if depth == 0 else str(err)) from err
        return found
    if isinstance(data, Obj):
        if data.open is not None or data.args:
            raise _NotPlainError(data.open or f"a {data.cls.name}, which is not folded")
        return {name: _plain(one.data, left, depth + 1) for name, one in data.fields.items()}
    raise _NotPlainError(reason_of(data) or "it is no value")


def setting(value: Value, name: str = "") -> Setting:
    """A value as a setting; a path or a name of the framework stays a text where the rest is not known."""
    text = text_of(value.data)
    if name in _PATHS and text is not None:
        return Setting(text, value.span)
    if name in _NAMES and isinstance(value.data, (External, Cls)):
        return Setting(value.data.name, value.span)
    found, reason = plain(value)
    if reason is not None:
        filled = value.data.filled if isinstance(value.data, Table) else None
        return Setting(None, value.span, reason, looped=None if filled is None else setting(filled))
    places = {}
    if isinstance(value.data, Table):
        # A constant's own line is not the key's, and stands before the dict or in another file.
        inside = (
            (key, one.span) for key, one in value.data.items.items() if one.span.path == value.span.path
        )
        places = {str(key): span for key, span in inside if span >= value.span}
    return Setting(found, value.span, places=places)  # type: ignore[arg-type]


def known(value: Value | None) -> object:
    """A value without places; None when it is None or not known."""
    return plain(value)[0] if value is not None else None


def is_actuator(value: Value) -> bool:
    """Whether a value is an actuator cfg."""
    data = value.data
    if not isinstance(data, Obj):
        return False
    if has_joints(data):
        return True
    return bool(class_roots(data.cls)) and any(map(_ACTUATOR.search, class_names(data.cls)))


def has_joints(obj: Obj) -> bool:
    """Whether an actuator cfg says which joints it is for."""
    return any(name in obj.fields for name in (*JOINTS, "base_cfg"))


def has_actuators(data: Data) -> bool:
    """Whether a robot's cfg may have any: a door or a peg states an empty dict, and is no robot."""
    held = data.fields.get("actuators") if isinstance(data, Obj) else None
    return held is not None and not (
        isinstance(held.data, (Seq, Table))
        and not held.data.items
        and getattr(held.data, "open", None) is None
    )


def comes_from(obj: Obj, *roots: str) -> bool:
    """Whether an object's class is, or derives from, one of these packages."""
    return any(root.startswith(roots) for root in class_roots(obj.cls))


def is_named(obj: Obj, ending: str) -> bool:
    """Whether an object's class, or one that it derives from, has a name with this ending."""
    return any(name.endswith(ending) for name in class_names(obj.cls))


@dataclass(slots=True)
class Draft:
    """What is found of one configuration, and what cannot be folded."""

    settings: dict[str, Setting] = field(default_factory=dict)
    groups: list[ActuatorGroup] = field(default_factory=list)
    ranges: list[RandomizedRange] = field(default_factory=list)
    actions: list[ActionTerm] = field(default_factory=list)
    notes: Collector = field(default_factory=Collector)
    edited: frozenset[str] = frozenset()
    elsewhere: dict[str, str] = field(default_factory=dict)
    robot_missing: Span | None = None
    entries: dict[str, Setting] = field(default_factory=dict)

    def config(self, framework: Framework, name: str, span: Span) -> RobotConfig:
        """All of it as a configuration."""
        return RobotConfig(
            framework,
            name,
            span,
            tuple(self.groups),
            self.settings,
            tuple(self.ranges),
            tuple(self.actions),
            tuple(self.notes),
            entries=self.entries,
            edited=self.edited,
            elsewhere=self.elsewhere,
            robot_missing=self.robot_missing,
        )

    def note(self, where: str, reason: str, span: Span) -> None:
        """Say that something could not be folded."""
        if name := elsewhere(reason):
            self.elsewhere[where] = name
        self.notes.info(
            UNFOLDED, f"not known without running it: {shortened(reason, 200)}", where=where, span=span
        )

    def refused(self, where: str, message: str, span: Span, help: str | None) -> None:
        """Say what the framework raises an error for, whatever the robot is."""
        self.notes.warning(REFUSED, message, where=where, span=span, help=help)

    def left_out(self, where: str, span: Span) -> None:
        """Say that a scene has another robot."""
        self.notes.info(UNFOLDED, "another robot of the scene: it is left out here", where=where, span=span)

    def set(self, name: str, value: Value | None, as_name: str = "") -> None:
        """Take a robot-wide setting; None: it is not written."""
        if value is not None:
            found = setting(value, as_name or name)
            if found.unknown is not None:
                self.note(name, found.unknown, found.span)
            elif name in _OF_ROBOT | IN_FIGURES and not isinstance(found.value, tuple):
                found = self.figure(name, found)
            self.settings[name] = found

    def pose(self, value: Value | None) -> None:
        """Take a default pose by pattern; None: it is not written."""
        self.set("default_position", value)
        if value is not None:
            self.patterns("default_position", self.settings["default_position"])

    def figure(self, where: str, one: Setting, *, certain: bool = True) -> Setting:
        """A setting that the framework takes as a number, or as numbers by joint: unknown, and said, where it is none.

        Args:
            where: What is said of: `legs.stiffness`.
            one: The setting.
            certain: Whether the class is the framework's own, which refuses anything else; one of somebody's own may
                take it.
        """
        say = self.notes.warning if certain else self.notes.info
        by_key = one.value.items() if isinstance(one.value, Mapping) else ((None, one.value),)
        for key, value in by_key:
            if isinstance(value, str):
                what = f"'{shortened(value, 40)}', which is text"
            elif isinstance(value, tuple):
                what = "a list"
            elif isinstance(value, float) and math.isnan(value):
                what = "nan"
            else:
                continue
            number = _as_number(value[0] if isinstance(value, tuple) and len(value) == 1 else value)
            message = f"{what} and no number: it is not judged"
            if key is None:
                help = f"write {number}" if number else "write a number, or a dict of numbers by joint"
                say(NO_NUMBER, f"it is {message}", where=where, span=one.span, help=help)
                # Import has a word of its own for nan.
                return one if isinstance(value, float) else Setting(None, one.span, f"it is {what}")
            hint = f"write {number}" if number else None
            said = f"{shortened(str(key), 40)} has {message}"
            say(NO_NUMBER, said, where=where, span=one.place(str(key)), help=hint)
        return one

    def group(self, name: str, obj: Obj, joints: Value | None, values: Mapping[str, Value]) -> None:
        """Take an actuator group.

        Args:
            name: Its key.
            obj: Its cfg.
            joints: What selects its joints.
            values: Its fields without that.
        """
        settings = {key: setting(value, key) for key, value in values.items()}
        bases, unread = tuple(class_names(obj.cls)[1:]), unread_module(obj.cls)
        if obj.open is not None:
            self.note(name, obj.open, obj.span)
        patterns = None if joints is None else texts(joints)
        if patterns is None:
            reason = (
                "its joints are not given"
                if joints is None
                else plain(joints)[1] or "its joints are no texts"
            )
            self.note(name, reason, obj.span)
        for key, one in settings.items():
            if one.unknown is not None:
                self.note(f"{name}.{key}", one.unknown, one.span)
            elif key in IN_FIGURES:
                settings[key] = self.figure(f"{name}.{key}", one, certain=not bases and unread is None)
            if isinstance(one.value, Mapping):
                # What a class of somebody's own does with its dicts is not known.
                self.patterns(f"{name}.{key}", one, certain=not bases and unread is None)
        if joints is not None:
            self.patterns(f"{name}.joints", setting(joints))
        own = tuple(
            key for key in _declared(obj.cls) if key in settings and key not in OF_ALL_CLASSES | _NAMES
        )
        self.groups.append(
            ActuatorGroup(name, obj.cls.name, obj.span, patterns, settings, bases, unread=unread, own=own)
        )

    def patterns(self, where: str, given: Setting, *, certain: bool = True) -> None:
        """Say which patterns are not matched, and so select nothing, and which the framework refuses.

        Args:
            where: What is said of: `legs.joints`.
            given: A pattern, several, or values by pattern.
            certain: Whether it is the framework that matches them.
        """
        several = given.value if isinstance(given.value, tuple | Mapping) else (given.value,)
        for pattern in several:
            if not isinstance(pattern, str):
                continue
            try:
                compile_pattern(pattern)
            except NoExpression as err:
                if certain:
                    self.refused(where, str(err), given.place(pattern), err.help)
            except PatternError as err:
                self.notes.info(UNFOLDED, f"not matched: {err}", where=where, span=given.place(pattern))

    def events(self, value: Value | None, known_functions: Events) -> None:
        """Take the ranges of event terms, an object or a dict.

        Args:
            value: The terms.
            known_functions: Those that randomise actuators.
        """
        for name, one in unknown_inside(value):
            self.note(f"events.{name}", reason_of(one.data) or "", one.span)
        for name, term in fields_of(value).items():
            parameters, operation = known_functions.get(function_of(term), ({}, ""))
            params = fields_of(fields_of(term).get("params"))
            given, distribution = known(params.get("operation")), known(params.get("distribution"))
            for parameter, figure in parameters.items():
                self.range(
                    figure,
                    params.get(parameter),
                    given if isinstance(given, str) else operation,
                    selected(params.get("asset_cfg"), "joint_names"),
                    distribution if isinstance(distribution, str) else "uniform",
                    selected(params.get("asset_cfg"), "actuator_names"),
                    term,
                    str(name),
                )

    def range(
        self,
        field: str,
        value: Value | None,
        operation: str,
        joints: tuple[str, ...] | None,
        distribution: str = "uniform",
        actuators: tuple[str, ...] | None = None,
        term: Value | None = None,
        event: str = "",
    ) -> None:
        """Take a randomisation range; a dict holds one for each pattern.

        Args:
            field: What it randomises.
            value: Its ends.
            operation: `scale`, `add` or `abs`.
            joints: Patterns; None: all joints.
            distribution: `uniform`, `log_uniform` or `gaussian`.
            actuators: Patterns of actuators' names; None: not given.
            term: The event term, which says when it is drawn; None without one.
            event: Its name.
        """
        if value is None or value.data is None:
            return
        if isinstance(value.data, Table) and value.data.open is None:
            for key, one in value.data.items.items():
                chosen = (key,) if isinstance(key, str) else joints
                self.range(field, one, operation, chosen, distribution, actuators, term, event)
            return
        ends, reason = plain(value)
        numbers = [float(end) for end in ends if _is_number(end)] if isinstance(ends, tuple) else []
        if isinstance(ends, tuple) and len(ends) == len(numbers) == 2:
            low, high = numbers
            mode, every = known(fields_of(term).get("mode")), _pair(fields_of(term).get("interval_range_s"))
            when = mode if isinstance(mode, str) else ""
            self.ranges.append(
                RandomizedRange(
                    field,
                    operation,
                    low,
                    high,
                    joints,
                    value.span,
                    distribution,
                    actuators,
                    when,
                    every,
                    event,
                )
            )
        else:
            self.note(field, reason or "a range is two numbers", value.span)


def _declared(cls: Cls | External) -> Iterable[str]:
    """Fields that a class and its bases declare, of those that could be read; each once."""
    classes = ancestors(cls) if isinstance(cls, Cls) else ()
    return dict.fromkeys(name for one in classes if isinstance(one, Cls) for name in one.annotated)


def _pair(value: Value | None) -> tuple[float, float] | None:
    """Two numbers; None for anything else."""
    found = known(value)
    if not isinstance(found, tuple) or len(found) != 2 or not all(map(_is_number, found)):
        return None
    return float(found[0]), float(found[1])


def _as_number(value: object) -> str | None:
    """A number, or the one that a text is, as it would be written; None for anything else."""
    try:
        return str(value).strip() if math.isfinite(float(value)) else None  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return None


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def texts(value: Value) -> tuple[str, ...] | None:
    """One text or several; None when they are not known."""
    found = known(value)
    if isinstance(found, str):
        return (found,)
    if isinstance(found, tuple) and all(isinstance(one, str) for one in found):
        return tuple(str(one) for one in found)
    return None


def fields_of(value: Value | None) -> dict[str, Value]:
    """Fields of an object, or values of a dict by text; {} for anything else."""
    data = value.data if value is not None else None
    if isinstance(data, Obj):
        return dict(data.fields)
    if isinstance(data, Table):
        return {key: one for key, one in data.items.items() if isinstance(key, str)}
    return {}


def unknown_inside(value: Value | None) -> Iterable[tuple[str, Value]]:
    """Fields of an object or dict that are not known, by name."""
    return [
        (name, one) for name, one in fields_of(value).items() if isinstance(one.data, (Unknown, External))
    ]


def function_of(term: Value) -> str:
    """Name of the function of an event term; "" where there is none."""
    function = fields_of(term).get("func")
    return (
        function.data.name
        if function is not None and isinstance(function.data, (External, Func, Cls))
        else ""
    )


def selected(entity: Value | None, names: str) -> tuple[str, ...] | None:
    """What a `SceneEntityCfg` names in one of its fields; None for all."""
    found = fields_of(entity).get(names)
    return texts(found) if found is not None and found.data is not None else None
