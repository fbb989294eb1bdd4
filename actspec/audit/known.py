"""Robots whose limits are published, and which of them an artifact is: by its name and by its joints.

The table is `robots/known.json`, made of the specs that ship and of `robots/limits`; a test holds it
to them.
"""

from __future__ import annotations

import json
import os
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from itertools import chain, product
from typing import Any

from actspec.audit.case import MODELS, Case
from actspec.readings.artifact import ActuatorGroup, Artifact, FileKind, RobotConfig
from actspec.readings.called import distinctive, telling
from actspec.readings.config import figures_of, selected
from actspec.readings.dict_keys import of_one_key
from actspec.readings.joint_names import joint_names, last_numbers, matching, written_out
from actspec.readings.ledger import LedgerRow
from actspec.readings.versions import Versions
from actspec.resources import data_path

KNOWN_SHARE = 0.75
"""Share of the known robot's joints that a file must have. Chosen: a G1 of 23 joints has 0.79 of those of 29."""

OWN_SHARE = 0.6
"""Share of a file's joints that must be the known robot's, where it has not all of them. Chosen: a G1 with two hands of
seven joints has 0.67."""

MOUNTED_SHARE = 0.9
"""Share of the known robot's joints that a file must have behind one prefix of its own. Chosen: an arm whose base or
last joint is fixed; what a name ends with tells less than the whole."""

PART = 10
"""Joints from which a part of a known robot is told: its legs. Chosen: two legs of six, less one that another has."""

PART_SHARE = 0.95
"""Share of the joints of such a file that must be the known robot's. Chosen: an H1-2's legs have 0.67 of an H1's."""

SAME = 0.02
"""Relative difference up to which a figure is a published one. Chosen: 23.5 and 23.7 N*m are one motor."""


_BY_KEY = ("effort_limit", "stall_torque", "no_load_speed", "velocity_limit", "armature", "kp", "kd")
"""Figures of a row that are held against what is published, and the gains, which tell that nothing drives a joint."""

GRIPS = re.compile(r"finger|thumb|gripp?er|jaw|claw|hand", re.IGNORECASE)
"""Words of a hand's joints and bodies: many arms have another hand, or theirs in another file, and it closes slowly."""

_SERIES = 4
"""Letters of a name from which it tells a series of robots without its number. Chosen: of `go` and `ur` many begin."""

_FOLDERS = 3
"""Folders above a file that may name its robot: `x30/mjcf/unitree/robot.xml`."""

HANDLES = frozenset({"leader"})
"""What an arm is called that a person moves by hand: it has the joints of the arm that follows, and other motors."""


@dataclass(frozen=True, slots=True)
class KnownJoint:
    """What is published of one joint.

    Attributes:
        effort: Largest torque that its limit, peak or torque-speed line has [N*m].
        armature: [kg*m^2]; None where nobody publishes it.
        velocity: Limit [rad/s]; None where nobody publishes it.
        source: Title of the source of the torque.
        maker: Whether the maker of the robot states torque and velocity.
        also: Torques that the maker states elsewhere for the same joint [N*m].
        top_speed: Largest that any source gives: a limit, or the end of a torque-speed line [rad/s]; None: none does.
        slower: Smaller ones that other sources give [rad/s], to their titles.
        gear: Speed of the motor over that of the joint [-]; None where nobody publishes it.
        sources: Titles of the sources of `armature` and `top_speed`, where they have others.
    """

    effort: float
    armature: float | None
    velocity: float | None
    source: str
    maker: bool
    also: tuple[float, ...] = ()
    top_speed: float | None = None
    slower: Mapping[float, str] = field(default_factory=dict)
    gear: float | None = None
    sources: Mapping[str, str] = field(default_factory=dict)

    @property
    def largest(self) -> float:
        """Largest torque that is stated of it anywhere [N*m]."""
        return max((self.effort, *self.also))

    def source_of(self, name: str) -> str:
        """Title of the source of a figure."""
        return self.sources.get(name, self.source)


@dataclass(frozen=True, slots=True)
class KnownRobot:
    """A robot whose limits are published.

    Attributes:
        name: As its spec has it.
        words: What a file of it is called, any of them.
        prefixes: What the names of its joints may begin with, in place of nothing.
        spelt: Parts of these names that some files spell otherwise, and how.
        variants: Name to joints; one without a name where there are none.
        former: Whether a file that may be of another one too is of that: its maker replaced this one under the same
            name, or the name leaves open which of several it is.
        beside: Words that its name must have beside one of `words`. A file that may be of another robot too is of the
            one with such words.
        armatures: What others give its joints, whichever [kg*m^2], to the titles of their sources.
    """

    name: str
    words: frozenset[str]
    prefixes: tuple[str, ...]
    spelt: Mapping[str, str]
    variants: Mapping[str, Mapping[str, KnownJoint]]
    former: bool = False
    beside: frozenset[str] = frozenset()
    armatures: Mapping[float, str] = field(default_factory=dict)

    @property
    def joints(self) -> tuple[str, ...]:
        """Its joints."""
        return tuple(next(iter(self.variants.values())))

    @property
    def needed(self) -> frozenset[str]:
        """Those by which it is known: not the fingers of an arm, whose gripper stands in a file of its own as often."""
        return frozenset(joint for joint in self.joints if not GRIPS.search(joint))

    @property
    def called(self) -> frozenset[str]:
        """Its words, and those without the number of its size: an `xarm.xml` may be any of three, and no Franka."""
        series = (word.rstrip("0123456789_") for word in self.words if word[-1:].isdigit())
        return self.words.union(one for one in series if len(one) >= _SERIES)

    def efforts(self, joint: str) -> frozenset[float]:
        """Every torque that is published of a joint, of all variants [N*m]."""
        figures = (variant[joint] for variant in self.variants.values())
        return frozenset(effort for one in figures for effort in (one.effort, *one.also))


@cache
def known_robots() -> tuple[KnownRobot, ...]:
    """Every known robot; none where this installation has no table."""
    try:
        table = json.loads(data_path("robots", "known.json").read_bytes())
    except FileNotFoundError:
        return ()
    return tuple(
        KnownRobot(
            name,
            frozenset(entry["words"]),
            tuple(entry.get("prefixes", ("",))),
            entry.get("spelt", {}),
            {
                variant: {
                    joint: KnownJoint(
                        row["effort"],
                        row.get("armature"),
                        row.get("velocity"),
                        row["source"],
                        row.get("maker", False),
                        tuple(row.get("also", ())),
                        max(filter(None, (row.get("velocity"), row.get("speed"))), default=None),
                        {float(speed): title for speed, title in row.get("slower", {}).items()},
                        row.get("gear"),
                        row.get("sources", {}),
                    )
                    for row in rows
                    for joint in row["joints"]
                }
                for variant, rows in entry["variants"].items()
            },
            entry.get("former", False),
            frozenset(entry.get("with", ())),
            {float(figure): title for figure, title in entry.get("armatures", {}).items()},
        )
        for name, entry in table.items()
    )


@cache
def _words() -> frozenset[str]:
    """What files of any known robot are called."""
    return frozenset(word for robot in known_robots() for word in robot.words)


@cache
def _names() -> frozenset[str]:
    """The same, and what they are called without their numbers."""
    return frozenset(name for robot in known_robots() for name in robot.called)


Rows = tuple[tuple[LedgerRow, tuple[str, ...]], ...]
"""Rows of an artifact, each with the joints of a known robot that it is of."""

Parts = tuple[Mapping[str, LedgerRow], ...]
"""For each of such rows, joints that have another row than the others of their pattern."""


@dataclass(frozen=True, slots=True)
class Likeness:
    """A known robot that an artifact is.

    Attributes:
        index: Of the artifact.
        robot: The known robot.
        joints: Each row of the artifact whose joint is known, with the names of the joints that it is of: one for a
            model, those that a pattern means for a configuration.
        parts: For each of these rows that is a pattern's, the joints for which a key of its group's dicts has a figure
            that the pattern does not tell, each with a row of its own.
        variants: The variants that its figures fit; all where none of them does, or nothing tells them apart.
        told: Whether the figures leave out a variant.
        copied: Whether its file is called otherwise than the robot, whose name it has inside: a note in a folder.
    """

    index: int
    robot: KnownRobot
    joints: Rows
    parts: Parts
    variants: tuple[str, ...]
    told: bool
    copied: bool = False

    def read(self, *fields: str) -> Rows:
        """`joints`, less those for which a key has one of these fields, and these one by one."""
        return _read(self.joints, self.parts, *fields)


def likenesses(case: Case) -> tuple[Likeness, ...]:
    """The artifacts that are known robots; those beside a spec are left to it."""
    every = case.once(all_likenesses)
    return tuple(one for one in every if FileKind.SPEC not in case.kinds_by_artifact[one.index])


def all_likenesses(case: Case) -> tuple[Likeness, ...]:
    """The artifacts that are known robots, those beside a spec too."""
    found = []
    for index, artifact in enumerate(case.artifacts):
        if artifact.kind is FileKind.SPEC:
            continue
        words = distinctive(artifact)
        named = [robot for robot in known_robots() if robot.words & words and robot.beside <= words]
        if not named:
            continue
        outside = _outside(artifact)
        copied = {robot.name for robot in named if outside and outside.isdisjoint(robot.called)}
        # A mini_cheetah.urdf of the robot "a1_description" may be either.
        others = any(robot.name in copied and not robot.former for robot in named)
        if words & HANDLES or (others and len(copied) < len(named)):
            continue
        # Of two that its name has the joints tell which it is, if they do: all of an arm's six, or six of another's
        # seven; legs alone are those of the newer G1.
        met = [
            (robot, rows, spelling)
            for robot in named
            for rows, spelling in [_rows(case, index, artifact, robot)]
            if rows and (robot.name not in copied or _is_a_copy(outside, robot, rows))
        ]
        met = [each for each in met if each[0].needed <= _joints_of(each[1])] or met
        met = [each for each in met if not each[0].former] or met
        met = [each for each in met if each[0].beside] or met
        if len(met) == 1:
            robot, rows, spelling = met[0]
            parts = _parts(case, index, rows, spelling)
            found.append(_like(index, robot, rows, parts, copied=robot.name in copied))
    return tuple(found)


def with_other_motors(case: Case) -> frozenset[int]:
    """Configurations that give a known robot the limits of a model of an unknown one there, at each joint.

    Whoever forgets to adapt a template has a known robot's limits at his own; the other way round it is on purpose.
    One limit for all joints tells of no robot.
    """
    known = {one.index for one in case.once(likenesses) if not one.copied}
    limits = {
        index: {joint: rows[0].effort_limit for joint, rows in joints.items() if rows[0].effort_limit}
        for index, joints in case.joints_by_artifact.items()
    }
    others = [
        limits[index]
        for robot in case.robots
        if known.isdisjoint(robot.artifacts)
        for index in robot.artifacts
        if case.artifacts[index].kind in MODELS and index in limits
    ]
    return frozenset(
        index
        for index in known & limits.keys()
        if case.artifacts[index].kind is FileKind.CFG
        # It has two limits or more, and each is the other's.
        if len(set(limits[index].values())) > 1
        and any(
            all(joint in theirs and same(limit, theirs[joint]) for joint, limit in limits[index].items())
            for theirs in others
        )
    )


def _outside(artifact: Artifact) -> frozenset[str]:
    """What the file of a model is called, whatever name it has inside: somebody may have begun with a copy.

    Of a URDF its own words tell, of an MJCF those of its files that name known robots: `ur3e.xml` in a scene of the
    model "ur5e scene" is no UR5e, and `kitchen_xarm.xml` of "franka_kitchen" no Franka. Where they name none, those of
    the nearest folder that names one do: `x30/robot.xml` of the model "lite3" is no Lite3. Of a configuration its
    model's file tells, as far as that names a known robot: `GO2_CFG` of a `b2.usd` is no Go2.
    """
    robot, config = artifact.robot, artifact.config
    if artifact.kind in MODELS and robot is not None:
        paths = [file.path for file in robot.files]
        above = os.path.dirname(os.path.abspath(artifact.path)).replace(os.sep, "/")
    elif config is not None and config.model is not None:
        paths = [config.model.replace("\\", "/")]
        above = paths[0].rpartition("/")[0]
    else:
        return frozenset()
    every = _names()
    stems = [telling(os.path.splitext(path.replace(os.sep, "/").rpartition("/")[2])[0]) for path in paths]
    named = every.intersection(chain.from_iterable(stems))
    own = stems[0] if artifact.kind is FileKind.URDF else named
    if not named:
        folders = above.split("/")[: -_FOLDERS - 1 : -1]
        own |= next((words for folder in folders if (words := telling(folder) & every)), frozenset())
    return own


def _is_a_copy(words: frozenset[str], robot: KnownRobot, rows: Rows) -> bool:
    """Whether a URDF that is called otherwise is the known robot all the same: `ur16e_b.urdf`, or by nearly all limits.

    Chosen: two thirds of the limits, of three figures or more. Whoever began with a copy for a robot of his own has
    motors of his own at most joints; two figures are those of many arms.
    """
    if any(word[-2:-1] == "_" and word[:-2] in robot.words for word in words - _words()):
        return True
    needed = robot.needed
    limits = [
        (row.effort_limit, robot.efforts(name)) for row, names in rows for name in names if name in needed
    ]
    right = [limit for limit, published in limits if limit and any(same(limit, one) for one in published)]
    return 3 * len(right) >= 2 * len(needed) and len(set(right)) > 2


def _rows(case: Case, index: int, artifact: Artifact, robot: KnownRobot) -> tuple[Rows, Mapping[str, str]]:
    """The first row of each known joint, and what the file calls the known joints; none where it has others."""
    by_joint: dict[str, LedgerRow] = {}
    for row in case.rows_of(index):
        if row.joint:
            by_joint.setdefault(row.joint, row)
    names, posed = joint_names(artifact), frozenset(_pose_keys(artifact))
    framework = artifact.config.framework if names is None and artifact.config is not None else None
    # A pattern that writes its joints out is these, `joint[1-7]`; another one may be any number.
    written = frozenset(
        name for pattern in by_joint if framework is not None for name in written_out(framework, pattern)
    )
    needed = robot.needed
    best: Rows = ()
    spelling: Mapping[str, str] = {}
    mounted = _mounted_as(robot, posed | written if names is None else names)
    before = (*((prefix,) for prefix in robot.prefixes), *([mounted] if mounted else ()))
    # Some files leave the ending out.
    for (part, spelt), prefixes, ending in product((("", ""), *robot.spelt.items()), before, ("", "_joint")):
        known = {
            f"{prefix}{joint.replace(part, spelt)}".removesuffix(ending): joint
            for prefix in prefixes
            for joint in robot.joints
        }
        if framework is not None:
            met = [(row, matching(framework, pattern, tuple(known))) for pattern, row in by_joint.items()]
        else:
            met = [
                (row, (name,))
                for joint, row in by_joint.items()
                if (name := joint.rpartition("/")[2]) in known
            ]
        pairs = tuple(
            (row, tuple(dict.fromkeys(known[name] for name in found))) for row, found in met if found
        )
        if names is None and not _has_its_keys(artifact, [row for row, _ in pairs], tuple(known)):
            continue
        count = len(_joints_of(pairs) & needed)
        of_own = len(pairs) / max(len(names or by_joint), 1)
        arm = [name for name, joint in known.items() if joint in needed]
        counted = _counts_alike(arm, written if names is None else names)
        # What is mounted on a robot all of whose joints are there, a hand or a base, may have any number of its own.
        own = of_own >= OWN_SHARE or (
            count == len(needed)
            and (
                names is not None
                or (
                    ((posed | written).issuperset(arm) or _loads(artifact, robot))
                    and _counts_alike(arm, posed)
                )
            )
        )
        whole = count >= KNOWN_SHARE * len(needed) and own
        legs = count >= PART and of_own >= PART_SHARE
        if counted and (whole or legs) and len(pairs) > len(best):
            best, spelling = pairs, {joint: name for name, joint in known.items()}
    return best, spelling


def _joints_of(rows: Iterable[tuple[LedgerRow, tuple[str, ...]]]) -> frozenset[str]:
    """The known joints that rows are of."""
    return frozenset(joint for _, joints in rows for joint in joints)


def _loads(artifact: Artifact, robot: KnownRobot) -> bool:
    """Whether a configuration loads a file of the robot's name and of no other known one's: `spot_arm_camera.usd`."""
    model = (artifact.config.model if artifact.config is not None else None) or ""
    stem = os.path.splitext(model.replace("\\", "/").rpartition("/")[2])[0]
    named = telling(stem) & _words()
    return bool(named) and named <= robot.words


def _mounted_as(robot: KnownRobot, names: Iterable[str]) -> tuple[str, ...]:
    """What a file puts before the names of nearly all joints of the robot, for one or more of it: `left_`, `arm2_`."""
    needed = robot.needed
    before = Counter(
        prefix
        for name in (each.rpartition("/")[2] for each in names)
        for joint in needed
        for prefix in (name.removesuffix(joint),)
        if prefix != name and prefix not in robot.prefixes and not prefix[-1:].isalnum()
    )
    return tuple(prefix for prefix, count in before.items() if count >= MOUNTED_SHARE * len(needed))


def _parts(case: Case, index: int, rows: Rows, spelling: Mapping[str, str]) -> Parts:
    """What the keys of a group's dicts say of joints that one pattern selects, at the keys' own places.

    `.*_wrist_.*` alone does not tell which joints the keys below it are for; the known robot does. What no key is for,
    or more than one, stays unknown, and so does a joint that two patterns select: the later group may be its own.

    Args:
        case: The artifact's.
        index: Of the artifact.
        rows: Of `_rows`.
        spelling: Known joints to their names in the file.
    """
    config = case.artifacts[index].config
    if config is None:
        return ({},) * len(rows)
    groups = {
        (group.span, group.name, joint): (group, pattern)
        for group in config.groups
        if any(isinstance(setting.value, Mapping) for setting in group.settings.values())
        for joint, pattern in selected(config, group, None)
    }
    named, versions = tuple(spelling.values()), case.versions_of(index)
    selections = Counter(joint for _, joints in rows for joint in joints)
    parts: list[Mapping[str, LedgerRow]] = []
    for row, joints in rows:
        own: dict[str, LedgerRow] = {}
        if found := groups.get((row.span, row.actuator, row.joint)):
            for joint in joints:
                part = _of_key(config, *found, row, spelling[joint], named, versions)
                if part is not row and selections[joint] == 1:
                    own[joint] = part
        parts.append(own)
    return tuple(parts)


def _of_key(
    config: RobotConfig,
    group: ActuatorGroup,
    pattern: str,
    row: LedgerRow,
    joint: str,
    named: Sequence[str],
    versions: Versions,
) -> LedgerRow:
    """A pattern's row for one of its joints, with what only the group's keys tell of it; the row where they do not."""
    settings = {
        name: of_one_key(config.framework, name, setting, joint) for name, setting in group.settings.items()
    }
    own = replace(group, settings=settings)
    figures = figures_of(config, own, joint, pattern, named, versions, config.physics_dt)
    more = {
        field: found
        for field, found in figures.items()
        if field in _BY_KEY and getattr(row, field) is None and found.value is not None
    }
    if not more:
        return row
    values: dict[str, Any] = {field: found.value for field, found in more.items()}
    places = {**row.places, **{field: found.span for field, found in more.items()}}
    return replace(row, joint=joint, places=places, stated=row.stated | more.keys(), **values)


def _read(rows: Rows, parts: Parts, *fields: str) -> Rows:
    found: list[tuple[LedgerRow, tuple[str, ...]]] = []
    for (row, joints), own in zip(rows, parts, strict=True):
        apart = {j for j, part in own.items() if any(getattr(part, f) != getattr(row, f) for f in fields)}
        if left := tuple(joint for joint in joints if joint not in apart):
            found.append((row, left))
        found += [(own[joint], (joint,)) for joint in joints if joint in apart]
    return tuple(found)


def _has_its_keys(artifact: Artifact, rows: Sequence[LedgerRow], known: tuple[str, ...]) -> bool:
    """Whether the pose of a configuration that selects all joints by one pattern has joints of the robot.

    `.*` fits any robot, and a Z1 on a B1 has `arm_joint1` where a Z1 has `joint1`.
    """
    config = artifact.config
    if config is None or any(not re.fullmatch(r"\W*", row.joint) for row in rows):
        return True
    telling_keys = [key for key in _pose_keys(artifact) if not re.fullmatch(r"\W*", key)]
    return not telling_keys or any(matching(config.framework, key, known) for key in telling_keys)


def _pose_keys(artifact: Artifact) -> Sequence[str]:
    """The keys of a configuration's default pose; none where it has no dict."""
    setting = None if artifact.config is None else artifact.config.settings.get("default_position")
    return (setting.keys if setting is not None else None) or ()


def _counts_alike(known: Iterable[str], names: Iterable[str]) -> bool:
    """Whether numbered joints go as far as the known robot's: an arm of six or ten `panda_joint` is no Franka."""
    mine, its = last_numbers(names), last_numbers(known)
    return all(mine[series] == last for series, last in its.items() if series in mine)


def _like(index: int, robot: KnownRobot, rows: Rows, parts: Parts, *, copied: bool) -> Likeness:
    read = _read(rows, parts, "effort_limit", "armature")
    by_armature = _has_its_armatures(robot, read)
    fitting = tuple(
        name for name, joints in robot.variants.items() if _fits(robot, joints, read, by_armature)
    )
    told = 0 < len(fitting) < len(robot.variants)
    return Likeness(index, robot, rows, parts, fitting or tuple(robot.variants), told, copied)


def _fits(
    robot: KnownRobot,
    joints: Mapping[str, KnownJoint],
    rows: Sequence[tuple[LedgerRow, tuple[str, ...]]],
    by_armature: bool,
) -> bool:
    """Whether no figure that differs between the variants is another one here; armatures where they tell."""
    for row, names in rows:
        for name in names:
            others = [variant[name] for variant in robot.variants.values()]
            mine = joints[name]
            if len({other.effort for other in others}) > 1 and not same(row.effort_limit, mine.effort):
                return False
            if by_armature and row.armature and not (mine.armature and same(row.armature, mine.armature)):
                return False
    return True


def _has_its_armatures(robot: KnownRobot, rows: Sequence[tuple[LedgerRow, tuple[str, ...]]]) -> bool:
    """Whether each armature of a file is one that is published of its joint, and there are several.

    One round figure for all joints (0.01 of the G1, whose hip has 0.01018) tells nothing.
    """
    found = [(row.armature, name) for row, names in rows for name in names if row.armature]
    return len({armature for armature, _ in found}) > 1 and all(
        any(
            one.armature and same(armature, one.armature)
            for one in (v[name] for v in robot.variants.values())
        )
        for armature, name in found
    )


def same(value: float | None, published: float) -> bool:
    """Whether a figure is a published one; one that is not stated may be any."""
    return value is None or abs(value - published) <= SAME * published
