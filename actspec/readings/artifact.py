"""What the audit reads: files, and the robot descriptions that are in them.

One file may describe several robots (a `.py` with four `*_CFG`), one robot stands in several
files. An `Artifact` is one robot as one file has it. Nothing here was executed.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import TYPE_CHECKING

from actspec.diagnostics import Diagnostic, Severity, Span
from actspec.readings.named_network import NetworkReading
from actspec.robot.view import ModelFile, RobotView

if TYPE_CHECKING:
    from actspec.ir import ActuatorSet
    from actspec.readings.pins import Asked
    from actspec.simulators import Release


def without_comments(data: bytes) -> bytes:
    """The text of an XML file without its comments; one that is not closed stays."""
    kept, at = [], 0
    while (begin := data.find(b"<!--", at)) >= 0 and (end := data.find(b"-->", begin + 4)) >= 0:
        kept.append(data[at:begin])
        at = end + 3
    return b"".join((*kept, data[at:]))


class FileKind(str, Enum):
    """What a file is."""

    MJCF = "mjcf"
    URDF = "urdf"
    CFG = "cfg"
    """Python configuration: Isaac Lab, mjlab or legged_gym style."""
    DEPLOY = "deploy"
    """YAML for the robot side: gains and joint order."""
    SPEC = "spec"


class Framework(str, Enum):
    """Whose conventions a configuration follows."""

    ISAACLAB = "isaaclab"
    MJLAB = "mjlab"
    LEGGED_GYM = "legged_gym"
    DEPLOY = "deploy"


@dataclass(frozen=True, slots=True)
class Setting:
    """One value of a configuration, folded without running it.

    Attributes:
        value: A number, a text, a truth value, None, a tuple of settings' values, or by-pattern values
            (joint pattern to number, in the author's order). Meaningless when `unknown` is set.
        span: Where it is written.
        unknown: Why it could not be folded (`a loop`, `name FOO comes from another package`); None when known.
        places: Where the value of a key stands, of those that stand in the dict itself.
        looped: What loops of a module fill it with, for import: to the audit it is unknown.
    """

    value: float | str | bool | tuple[object, ...] | Mapping[str, object] | None
    span: Span
    unknown: str | None = None
    places: Mapping[str, Span] = field(default_factory=dict, compare=False)
    looped: Setting | None = None

    @property
    def unrolled(self) -> Setting:
        """It with what loops fill."""
        return self.looped or self

    def place(self, key: str) -> Span:
        """Where a key of by-pattern values stands; the whole where nobody knows."""
        return self.places.get(key, self.span)

    @property
    def keys(self) -> tuple[str, ...] | None:
        """The patterns of by-pattern values, in the author's order; None where it is unknown or anything else."""
        return tuple(self.value) if isinstance(self.value, Mapping) else None

    @property
    def number(self) -> float | None:
        """The value where it is one number; None where it is unknown or anything else."""
        known = (
            self.unknown is None and isinstance(self.value, int | float) and not isinstance(self.value, bool)
        )
        return float(self.value) if known else None  # type: ignore[arg-type]


@dataclass(frozen=True, slots=True)
class ActuatorGroup:
    """One actuator cfg: a group of joints with one class and its settings.

    Attributes:
        name: Key of the group (`legs`), or the constant's name.
        cls: Class as written, without its module: `DCMotorCfg`, `BuiltinPositionActuatorCfg`, `P` for legged_gym.
        span: Where the cfg is written.
        joints: Patterns that select its joints, as written; None when they could not be folded.
        settings: Field of the class as written (`effort_limit_sim`, `stiffness`) to its value. A field that
            is not written is not here.
        bases: Classes that `cls` derives from, as far as they could be read, nearest first.
        network: The network that it names; None without one.
        unread: Module of `cls`, or of what it derives from, whose file is not there; None: all is known.
        own: Settings that its class has, or one of its bases, and no class of the framework's: one of somebody's own.
            Of legged_gym what a fork's `control` has and its own does not.
    """

    name: str
    cls: str
    span: Span
    joints: tuple[str, ...] | None
    settings: Mapping[str, Setting]
    bases: tuple[str, ...] = ()
    network: NetworkReading | None = None
    unread: str | None = None
    own: tuple[str, ...] = ()

    @property
    def is_stock(self) -> bool:
        """Whether its class, called as one of the framework's, can be that: it is none of somebody's own."""
        return not (self.bases or self.own or self.unread)

    @property
    def of_run(self) -> bool:
        """Whether a run wrote it of a class that is not the framework's: with all fields, and the class by its name."""
        return self.unread is not None and "class_type" in self.settings


@dataclass(frozen=True, slots=True)
class RandomizedRange:
    """One domain-randomisation range of a configuration.

    Attributes:
        field: `kp`, `kd`, `armature`, `friction`, `effort_limit`, `strength`, `encoder_bias`, `delay` or the stack's
            own name where it is none of these.
        operation: `scale`, `add` or `abs`.
        low: Lower end.
        high: Upper end.
        joints: Patterns; None: all joints.
        span: Where it is written.
        distribution: `uniform`, `log_uniform` or `gaussian` (then low, high are mean and deviation).
        actuators: Patterns of mjlab's `actuator_names`; None: not given.
        when: The event's mode (`startup`, `reset`, `interval`, ...); "" where nobody says.
        every: Time between two draws of mode `interval`, low and high [s]; None without.
        event: Name of the event term; "" without one.
    """

    field: str
    operation: str
    low: float
    high: float
    joints: tuple[str, ...] | None
    span: Span
    distribution: str = "uniform"
    actuators: tuple[str, ...] | None = None
    when: str = ""
    every: tuple[float, float] | None = None
    event: str = ""


@dataclass(frozen=True, slots=True)
class ActionTerm:
    """One term of an environment's actions: what an action becomes at the joints that it is for.

    Attributes:
        name: Its key: `joint_pos`.
        cls: Its class, as written; "" where a base that is not read has it.
        joints: Patterns of `joint_names`, or mjlab's `actuator_names`; None: they are not known.
        command: What it commands: `position`, `velocity` or `effort`; None: no multiple of the action.
        why: Why `command` is None.
        scale: Command per unit of action, a number or by pattern; None: the base that is not read has it.
        zero: Command at zero action, a number or by pattern; None: the joint's default position, and no speed.
        clip: Pattern to the ends between which the command stays; None without.
        span: Where it is made.
        ordered: Whether its actions are in the order of `joints`, by `preserve_order`, and not in the robot's.
    """

    name: str
    cls: str
    joints: tuple[str, ...] | None
    command: str | None
    why: str
    scale: Setting | None
    zero: Setting | None
    clip: Setting | None
    span: Span
    ordered: bool = False

    @property
    def place(self) -> Span:
        """Where its scale is written; where it is made without one."""
        return self.span if self.scale is None else self.scale.span

    @property
    def said(self) -> tuple[object, ...]:
        """What it says, wherever it is written."""
        settings = (self.scale and self.scale.unrolled, self.zero, self.clip)
        values = (None if one is None else one.unknown or one.value for one in settings)
        return (self.joints, self.command, self.why, *values)


@dataclass(frozen=True, slots=True)
class NamelessList:
    """A list of a deploy file whose joints nobody names.

    Attributes:
        key: As written: `kps`.
        entries: How many it has.
        span: Where it is written.
    """

    key: str
    entries: int
    span: Span


@dataclass(frozen=True, slots=True)
class Motors:
    """Lists of a deploy file by the numbers of the robot's motors, which it does not name.

    Attributes:
        count: How many numbers there are, gaps too.
        groups: A motor each, in the order of the numbers, called by its number.
        actions: Terms whose joints are such numbers.
        span: Where the policy's joints have their numbers.
        order: The motor of each joint of the policy; None: it has none of its own.
        selected: An action to the patterns of its `joint_names`, at the place of the `joint_ids` that are beside them.
    """

    count: int
    groups: tuple[ActuatorGroup, ...]
    actions: tuple[ActionTerm, ...]
    span: Span
    order: tuple[str | None, ...] = ()
    selected: Mapping[str, Setting] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class RobotConfig:
    """A robot as a training or deploy configuration has it.

    Attributes:
        framework: Whose conventions.
        name: Constant or class that defines it: `UNITREE_GO2_CFG`, `G1RoughCfg`; the file's stem for YAML.
        span: Where that is.
        groups: Its actuator groups, in the author's order.
        settings: Robot-wide settings by actspec's name: `physics_dt`, `decimation`, `control_dt`, `action_scale` (of
            all joints; that of an environment's terms is in `actions`),
            `default_position` (by pattern), `soft_joint_pos_limit_factor`, `joint_order` (tuple of names),
            `sdk_order` (the robot's numbering, of a deploy file that actspec wrote: names and None; empty: not stated),
            `model` (path of the asset that it names).
        randomize: Its ranges.
        actions: The terms of its actions, in the author's order.
        notes: What could not be folded, each with its place and reason.
        elsewhere: Of these the ones (`where`) whose reason is a name of a file that is not read, to that name.
        written_for: What its groups are for, where actspec wrote them: names of `case.Versions`' fields.
        nameless: `kp` and `kd` to the entries of lists whose joints nobody names.
        nameless_lists: Field to its list, of all such lists, also of equal entries.
        motors: What lists of a deploy file that go by the robot's numbering say, whoever names the numbers.
        entries: Numbers that no figure is made from and that may be of a joint, by where they stand: those of lists and
            maps (`entry 3 of kps`), and what is assigned to a robot that is not read.
        others: Other values that no figure is made from, likewise.
        looped: Settings that a loop of the file fills, for import: the audit's figures are without them.
        edited: What its program calls and sets before the simulator has the model: names of methods and attributes of
            the function that loads it (`add_equality`, `damping`), whatever they are of.
        by_call: Whether it is what a function of the file makes without arguments, whose name it has.
        robot_missing: Where an environment leaves its robot to a class that is derived from it (`MISSING`); None: it
            does not.
        stands_up: Whether the only gains of a deploy file are of getting up and lying down.
        by_motor: Whether its joints are called after their motors' numbers, which no policy's order is.
        by_name: Whether what runs it looks each joint up by its name, so that the order of its names tells nothing.
        reordered: Whether its file has its joints in another order, too, or their places there.
        mapped: Whether its joints are in a policy's order, and what runs it knows the place of each in the robot's.
    """

    framework: Framework
    name: str
    span: Span
    groups: tuple[ActuatorGroup, ...]
    settings: Mapping[str, Setting]
    randomize: tuple[RandomizedRange, ...] = ()
    actions: tuple[ActionTerm, ...] = ()
    notes: tuple[Diagnostic, ...] = ()
    elsewhere: Mapping[str, str] = field(default_factory=dict)
    written_for: Mapping[str, str] = field(default_factory=dict)
    nameless: Mapping[str, tuple[Setting, ...]] = field(default_factory=dict)
    nameless_lists: Mapping[str, NamelessList] = field(default_factory=dict)
    motors: Motors | None = None
    entries: Mapping[str, Setting] = field(default_factory=dict)
    others: Mapping[str, Setting] = field(default_factory=dict)
    looped: Mapping[str, Setting] = field(default_factory=dict)
    edited: frozenset[str] = frozenset()
    by_call: bool = False
    robot_missing: Span | None = None
    stands_up: bool = False
    by_motor: bool = False
    by_name: bool = False
    reordered: bool = False
    mapped: bool = False

    @property
    def unrolled(self) -> RobotConfig:
        """It with what loops fill, for import; what is known then is no note any more."""
        scales = [term.scale for term in self.actions if term.scale is not None]
        known = {one.span for one in (*self.settings.values(), *scales) if one.looped is not None}
        settings = {name: one.unrolled for name, one in self.settings.items()}
        actions = tuple(replace(term, scale=term.scale and term.scale.unrolled) for term in self.actions)
        notes = tuple(note for note in self.notes if note.code != "CFG001" or note.span not in known)
        return replace(self, settings={**settings, **self.looped}, actions=actions, notes=notes)

    @property
    def physics_dt(self) -> float | None:
        """The simulation's step [s]; None where the configuration does not say."""
        setting = self.settings.get("physics_dt")
        return None if setting is None else setting.number

    @property
    def model(self) -> str | None:
        """Path of the asset that it names, as it is written; None where it names none, or one that is not known."""
        setting = self.settings.get("model")
        return setting.value if setting is not None and isinstance(setting.value, str) else None


_OF_A_WORLD = (b"<option", b"<statistic", b"<keyframe", b'type="plane"', b'type="skybox"')
"""What is in no hand, base or arm that is to be mounted. Chosen: of the 249 MJCFs of 123 repositories that have joints
or drives and no `<compiler>`, none of robosuite's robots, grippers and bases has one of these. The walkers of
dm_control bring a light that follows them into its arenas, which have the angle."""


_ITS_OWN = re.compile(
    r"unrecognized attribute|bad format in attribute|number is too large in attribute|must be a number"
)
"""Reasons of MuJoCo, and of actspec, to refuse a part of a model that nothing which includes it mends."""


@dataclass(frozen=True, slots=True)
class Artifact:
    """One robot as one file has it; exactly one of `robot`, `config` and `spec` is set.

    Attributes:
        path: The file as the user named it.
        kind: What the file is.
        name: The robot's name there.
        robot: MJCF or URDF, read; its inertia matrices may have been dropped after `inertia` was taken.
        config: Configuration, read.
        spec: Spec, resolved.
        networks: Networks that a spec names, each once; those of a configuration are in its groups.
        text_only: Why the numbers come from the text alone (MuJoCo refuses the file, with its reason); None: compiled.
        model: The model of a variant of a spec that is there for files of that model alone.
        variants: Other variants of a spec with the same joints, resolved, by name: where a file departs from the spec,
            it may be of one of them.
    """

    path: str
    kind: FileKind
    name: str
    robot: RobotView | None = None
    config: RobotConfig | None = None
    spec: ActuatorSet | None = None
    networks: tuple[NetworkReading, ...] = ()
    text_only: str | None = None
    model: str | None = None
    variants: tuple[tuple[str, ActuatorSet], ...] = ()

    @property
    def refused_at(self) -> Span | None:
        """Where MuJoCo met the reason of `text_only`; None: it does not say."""
        return None if self.robot is None else self.robot.refused_at

    @property
    def is_refused(self) -> bool:
        """Whether MuJoCo refuses it, a model of MuJoCo's own, for what no file that includes it mends."""
        reason = self.text_only if self.kind is FileKind.MJCF else None
        return reason is not None and (not self.is_part or _ITS_OWN.search(reason) is not None)

    @property
    def is_part(self) -> bool:
        """Whether it is an MJCF for others to include or mount: a `<mujocoinclude>`, or without `<compiler>`.

        Whether its angles are degrees, and what it is integrated with, is then in a file that is not here. A robot with
        its drives is no part where it includes what it is made of, or has what only a whole model has.
        """
        return self.may_be_part and not self._is_whole

    @property
    def may_be_part(self) -> bool:
        """Whether a file that includes it can have the compiler that it lacks."""
        known = self.kind is FileKind.MJCF and self.robot is not None
        if not known or not self.states(b"<compiler") or self._is_included:
            return known
        # Options and contacts of bodies that another file has are part of it, whatever compiler they bring; a misspelt
        # world is none.
        whole = any(map(self.states, (b"<worldbody", b"<actuator"))) or self.text_only is None
        return not whole and "unrecognized element" not in (self.text_only or "")

    @property
    def _is_whole(self) -> bool:
        """Whether MuJoCo takes it, with joints and drives, in a world of its own."""
        robot = self.robot
        if robot is None or self._is_included or self.text_only is not None:
            return False
        driven = bool(robot.joints) and bool(robot.actuators)
        return driven and (any(file.include for file in robot.files) or any(map(self.states, _OF_A_WORLD)))

    @property
    def _is_included(self) -> bool:
        """Whether the root is one that MuJoCo takes in an include alone."""
        return self.robot is not None and b"<mujocoinclude" in self.robot.files[0].data

    def states(self, tag: bytes) -> bool:
        """Whether a robot file or one of its includes has an element; what is in a comment does not count."""
        files = () if self.robot is None else self.robot.files
        return any(tag in file.data and tag in without_comments(file.data) for file in files)


PHYSX, NETWORK = "PhysX", "actuator_net"
"""What stands for a class in a legged_gym configuration whose drive is PhysX's own, or a network."""

NAMES_NOTHING = ("AUD014", "AUD016")
"""Codes of names that stand for no file."""

NOT_FOUND = "ROBOT006"
"""Code of a file that a model includes or attaches and that cannot be read."""

STEP_OF_WHAT = "DEPLOY005"
"""Code of the remark on a `dt` of which nobody knows what it is a step of."""

NOT_TAKEN = frozenset(
    {
        "CFG003",
        "CFG004",
        "DEPLOY001",
        "DEPLOY003",
        "DEPLOY004",
        "DEPLOY006",
        "DEPLOY007",
        "DEPLOY008",
        "DEPLOY010",
        "ROBOT009",
        "ROBOT123",
        "ROBOT124",
    }
)
"""Warnings of readers that the file contradicts itself, so that something of it is not taken as it is written.

The others tell no fault of the file: MuJoCo's own warnings, which its releases add to (ROBOT112), a mesh that is not
there (ROBOT114), a URDF that MuJoCo refuses and other programs take (AUD013), where actspec stops reading (CFG001).
Limits of 0 are a rule's (ROBOT125).
"""


_OF_THE_TEXT = frozenset({"angle", "lags"})
"""What programs write over that the text cannot be read without: its figures are no figures before, and a lag that is
held from one reset to the next is held for the program that sets it.
"""


@dataclass(frozen=True, slots=True)
class FileReading:
    """One file that the user named, read or not.

    Attributes:
        path: As the user named it.
        kind: What it is; None when nobody can tell.
        reason: Why it could not be read, without the place; None when it was.
        artifacts: The robots in it, in order.
        files: Its bytes and those of its includes, for excerpts, inline remarks and fixes.
        diagnostics: What the reader says about it.
        in_folder: Whether it was found in a folder that was named, and was not named itself.
        put_aside: Whether it was, and it or a folder below that one calls itself a copy or old.
        included: Whether another file of the audit includes it, which can be read or not.
        whole: Of a model that MuJoCo refuses alone, a file beside those of the audit that includes it and compiles; of
            one whose include cannot be followed alone, one that includes it and can be read.
        refused_by: Of a model that MuJoCo refuses, the release that is installed; None: not known.
        asked: Of such a model, what its project asks for that this release is too new for.
        refused: The place that `reason` is about; None: the file as a whole.
        without_gains: Whether it is a whole file of data in which no joint has gains: a folder has many.
        unnamed: Of a model in a folder whose programs name models there: whether neither they nor a model that they
            name name it.
        run: Of a model in a folder, whether a program there writes out its name, or a model that one does.
        written: Figures of models that programs of its folder write over when they have loaded one; `urdf_effort` where
            they ask no URDF for it, `urdf_limit` where none is of a trainer that takes a URDF's for the drive's,
            `compiled` where none is of MuJoCo or each attaches it, `integrator` where they set another, `angle` where
            one sets radians, `step` where step or inertia are theirs or another simulator's, `dynamics` where none is
            of MuJoCo or Gazebo, `drive` where they leave a configuration's gains to a simulator of their own.
        idle: Configurations in a folder that no program there imports, where one imports others.
        record: Whether it is what a training wrote of itself: it says what was, and is not for editing.
        unread: Of a robot file that is not read where it is found in a folder, what it is: `xacro`, `template`.
    """

    path: str
    kind: FileKind | None
    reason: str | None
    artifacts: tuple[Artifact, ...] = ()
    files: tuple[ModelFile, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()
    in_folder: bool = False
    put_aside: bool = False
    included: bool = False
    whole: str | None = None
    refused_by: Release | None = None
    asked: Asked | None = None
    refused: Span | None = None
    without_gains: bool = False
    unnamed: bool = False
    run: bool = False
    written: frozenset[str] = frozenset()
    idle: frozenset[str] = frozenset()
    record: bool = False
    unread: str = ""

    def as_named(self) -> FileReading:
        """The same file as if it was named, whatever its folder says of it save what its text is not read without."""
        return replace(
            self,
            in_folder=False,
            put_aside=False,
            unnamed=False,
            written=self.written & _OF_THE_TEXT,
            idle=frozenset(),
        )

    @property
    def is_named(self) -> bool:
        """Whether somebody named it, or a program of the folder that it was found in runs it."""
        return not self.in_folder or (self.run and not self.put_aside)

    @property
    def refused_models(self) -> tuple[Artifact, ...]:
        """Models in it that MuJoCo refuses, of a file that somebody or a program names and that no other includes."""
        if not self.is_named or self.included:
            return ()
        return tuple(artifact for artifact in self.artifacts if artifact.is_refused)

    @property
    def compiles(self) -> bool:
        """Whether it is a robot file that MuJoCo takes."""
        return bool(self.artifacts) and all(one.robot and one.text_only is None for one in self.artifacts)

    @property
    def said(self) -> tuple[Diagnostic, ...]:
        """What readers have to say of it, each remark once."""
        # A deploy file has the notes of its configurations among its own.
        notes = (note for artifact in self.artifacts if artifact.config for note in artifact.config.notes)
        return tuple(dict.fromkeys((*self.diagnostics, *notes)))

    @property
    def not_taken(self) -> tuple[Diagnostic, ...]:
        """What is not taken as it is written, of a file that somebody or a program names."""
        if not self.is_named or not self.readable:
            return ()
        return tuple(
            item for item in self.said if item.code in NOT_TAKEN and item.severity is Severity.WARNING
        )

    @property
    def names_nothing(self) -> bool:
        """Whether there is no such file, or nothing to audit in the folder: a wrong name, and no finding."""
        return any(item.code in NAMES_NOTHING for item in self.diagnostics)

    @property
    def readable(self) -> bool:
        """Whether it was read."""
        return self.reason is None

    @property
    def place(self) -> Span:
        """Where it is refused."""
        return self.refused or Span(self.path)

    @property
    def help(self) -> str | None:
        """What to do where it could not be read, if the reader says that."""
        return next((item.help for item in self.diagnostics if item.severity is Severity.ERROR), None)

    @property
    def told(self) -> str:
        """Why it could not be read, with the place ahead where that is less than the file."""
        place = "" if self.refused is None else f"{self.refused}: "
        return f"{place}{self.reason}"


@dataclass(frozen=True, slots=True)
class Robot:
    """Artifacts that describe the same robot.

    Attributes:
        name: The most telling name among them.
        artifacts: Indices into `Case.artifacts`, in the order of the files.
    """

    name: str
    artifacts: tuple[int, ...]
