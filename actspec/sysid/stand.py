"""Where the joints are that a fit does not move: as read, as the log's sidecar, the spec or the model's file has them.

They carry the joints that are fitted, or are carried by them: a bent knee makes another thigh.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, TypeVar

from actspec.diagnostics import Collector, Span, listed
from actspec.fields import units_of
from actspec.ir import ActuatorSet, Origin
from actspec.joints import JointKind
from actspec.logs import JointLog, Log
from actspec.robot.view import JointView, RobotView
from actspec.sysid.links import links_along
from actspec.sysid.spoilt import EXCITED
from actspec.units import format_quantity

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

T = TypeVar("T")

STANDS = {JointKind.HINGE: 0.05, JointKind.SLIDE: 0.005}
"""Movement of a joint that is not fitted, from end to end, up to which it counts as standing [rad or m]. Chosen:
it turns gravity by a twentieth, and a path by its readings would add their noise as accelerations."""
MATTERS = 0.03
"""Change of the links' inertia, or share of their greatest load, that a joint's pose must make over its range. Chosen:
masses of a model are no better."""
REACH = {JointKind.HINGE: 0.5, JointKind.SLIDE: 0.05}
"""Half the range of a joint without one, for that [rad or m]. Chosen."""
STATED, SIDECAR, KEYFRAME = "by robot.default_pose", "by the log's sidecar", "by the model's first keyframe"
REFERENCE = "as the model's file draws it"


def idle(joint: JointLog) -> bool:
    """Whether no command of a log moves a joint: there is none, or it does not change."""
    import numpy as np

    for command in (joint.command, joint.velocity_command):
        told = None if command is None else command[np.isfinite(command)]
        if told is not None and (not len(told) or np.ptp(told) > EXCITED):
            return False
    return True


def by_log(parts: Mapping[str, Sequence[tuple[Log, T]]]) -> Iterator[tuple[Log, dict[str, T]]]:
    """Each log, and what every joint has in it."""
    for key, log in {id(log): log for mine in parts.values() for log, _ in mine}.items():
        yield log, {name: part for name, mine in parts.items() for one, part in mine if id(one) == key}


@dataclass(frozen=True, slots=True)
class Stand:
    """A robot on its stand.

    Attributes:
        robot: Its model.
        actuators: The spec, resolved: its default pose and its encoders' biases count.
    """

    robot: RobotView
    actuators: ActuatorSet

    def beside(self, log: Log, names: Sequence[str]) -> tuple[RobotView, dict[str, Array]]:
        """The robot with the other joints as they stand in a log, and how those move that do.

        Args:
            log: With its sidecar.
            names: Joints that a fit moves.

        Returns: The robot in that pose; other joint to its position at the log's rows [rad or m], NaN where unknown.
        """
        held: dict[str, float] = {}
        moving: dict[str, Array] = {}
        for joint in self.others(names):
            read = self._read(log, joint)
            if read is None:
                held[joint.name] = self.stated(log, joint)[0]
            elif isinstance(read, float):
                held[joint.name] = read
            else:
                moving[joint.name] = read
        return replace(self.robot, pose=held), moving

    def tell(self, fitted: Mapping[str, Sequence[tuple[Log, Array]]], out: Collector) -> None:
        """Say where those joints are that no column tells and that matter.

        Args:
            fitted: Joint that is fitted to each of its logs, and its position there.
            out: Takes it.

        Raises:
            RobotError: the model does not tell the links' inertia.
        """
        said: set[tuple[str, ...]] = set()
        for log, here in by_log(fitted):
            groups: dict[str, list[JointView]] = {}
            for joint in self.others(list(here)):
                if self._read(log, joint) is None:
                    groups.setdefault(self.stated(log, joint)[1], []).append(joint)
            share = self._shares(log, here, [joint for group in groups.values() for joint in group])
            for source, group in groups.items():
                mattering = [joint for joint in group if max(share[joint.name].values()) > MATTERS]
                shown = [self._shown(joint, self.stated(log, joint)[0]) for joint in mattering]
                if not mattering or (source, *shown) in said:
                    continue
                said.add((source, *shown))
                message = f"not in the log, held {source}: {listed(shown)}"
                if source is not REFERENCE or self.actuators.default_pose:
                    out.info("SYS038", message, span=Span(log.path))
                    continue
                most, whose = max((s, name) for joint in mattering for name, s in share[joint.name].items())
                message += (
                    f"; nothing says that it is there, and over its range the links at {whose} change by "
                    f"up to {min(most, 9.99):.0%}"
                )
                first, unit = mattering[0], units_of(mattering[0].kind).position
                help = (
                    f"log {first.name}.position, or state it: `pose: {{{first.name}: ... {unit}}}` in the "
                    "sidecar, or robot.default_pose in the spec"
                )
                out.warning("SYS038", message, span=Span(log.path), help=help)

    def check(self, logs: Sequence[Log], out: Collector) -> None:
        """Poses of sidecars that are of no joint."""
        from actspec.patterns import match_names

        names = [joint.name for joint in self.others(())]
        for log in logs:
            for text in log.sidecar.pose:
                if text not in names and not match_names(text, names):
                    message = f"the model has no joint '{text}'"
                    out.error(
                        "SYS021", message, where="pose", span=Span(log.path), help=f"joints: {listed(names)}"
                    )

    def tell_left_out(
        self, log: Log, here: Container[str], out: Collector, fitted: Container[str] = ()
    ) -> None:
        """Say which joints of a log have no figures, why, and where they are.

        Args:
            log: With its columns.
            here: Joints that have figures.
            out: Takes it.
            fitted: Others whose fit says how they moved.
        """
        shown: dict[str, list[str]] = {}
        for name in log.joints:
            joint = self.robot.joint(name)
            if name in here or joint is None or self.actuators.joint(name) is None:
                continue
            read = self._read(log, joint)
            why = "no command moves them" if idle(log.joints[name]) else "--joint does not name them"
            if name in fitted:
                at = f"{name} moves by a fit of its own"
            elif isinstance(read, float):
                at = f"{name} stands at {format_quantity(read, units_of(joint.kind).position, 4)}"
            else:
                at = f"{name} has no position" if read is None else f"{name} moves as read"
            shown.setdefault(why, []).append(at)
        for why, mine in shown.items():
            out.info("SYS037", f"no figures, as {why}: {listed(mine)}", span=Span(log.path))

    def others(self, names: Sequence[str]) -> list[JointView]:
        return [joint for joint in self.robot.joints if joint.kind in STANDS and joint.name not in names]

    def _read(self, log: Log, joint: JointView) -> float | Array | None:
        """Where a log has a joint: one position where it stands, one of every row where it moves, else None."""
        import numpy as np

        column = log.joints[joint.name].position if joint.name in log.joints else None
        if column is None or np.isfinite(column).mean() < 0.5:
            return None
        actuator = self.actuators.joint(joint.name)
        q = column - (0.0 if actuator is None else actuator.encoder_bias.value or 0.0)
        low, middle, high = np.nanquantile(q, [0.01, 0.5, 0.99])
        return float(middle) if high - low <= STANDS[joint.kind] else np.asarray(q)

    def stated(self, log: Log, joint: JointView) -> tuple[float, str]:
        """Where a joint is that a log does not have, and who says so."""
        sidecar, (position, source) = log.sidecar.pose_of(joint.name), self.default(joint)
        return (position, source) if sidecar is None else (sidecar, SIDECAR)

    def default(self, joint: JointView) -> tuple[float, str]:
        """Where a joint is without a log, and who says so."""
        actuator = self.actuators.joint(joint.name)
        pose = None if actuator is None else actuator.default_position
        if pose is not None and pose.value is not None and pose.origin is not Origin.DEFAULT:
            return pose.value, STATED
        return joint.reference_position, KEYFRAME if self.robot.keyframes else REFERENCE

    def _shown(self, joint: JointView, position: float) -> str:
        return f"{joint.name} {format_quantity(position, units_of(joint.kind).position, 4)}"

    def _shares(
        self, log: Log, here: Mapping[str, Array], others: Sequence[JointView]
    ) -> dict[str, dict[str, float]]:
        """Other joint to fitted joint to how much of the links' inertia or load its pose changes over its range."""
        import numpy as np

        if not others:
            return {}
        n, names = len(here), [*here, *(joint.name for joint in others)]
        robot, _ = self.beside(log, names)
        first = np.stack([np.nanquantile(q, [0.05, 0.5, 0.95]) for q in here.values()], axis=1)
        rest = np.tile([self.stated(log, joint)[0] for joint in others], (len(first), 1))
        poses = [np.hstack([first, rest])]
        for j, joint in enumerate(others):
            low, high = joint.range or (rest[0, j] - REACH[joint.kind], rest[0, j] + REACH[joint.kind])
            for position in (low, 0.5 * (low + high), high):
                poses.append(poses[0].copy())
                poses[-1][:, n + j] = position
        path = np.concatenate(poses)
        base = log.sidecar.base
        links = links_along(
            robot, names, path, 0.0 * path, None if base is None else base.orientation, every=len(path)
        )
        inertia = np.diagonal(links.inertia, axis1=1, axis2=2)[:, :n].reshape(len(poses), -1, n)
        load = links.load[:, :n].reshape(len(poses), -1, n)
        own = [self.actuators.joint(name) for name in here]
        armature = np.array([0.0 if a is None else a.armature.value or 0.0 for a in own])
        # A load is none where it is less than what turns the links by 1 rad/s^2.
        most = np.maximum(np.abs(load).max(axis=(0, 1)), inertia[0].max(axis=0) + armature)
        changed = np.maximum(
            (np.abs(inertia - inertia[0]) / (inertia[0] + armature)).max(axis=1),
            (np.abs(load - load[0]) / most).max(axis=1),
        )
        shares = changed[1:].reshape(len(others), 3, n).max(axis=1)
        return {
            joint.name: dict(zip(here, map(float, row), strict=True))
            for joint, row in zip(others, shares, strict=True)
        }


def standing(robot: RobotView, actuators: ActuatorSet, log: Log | None = None) -> RobotView:
    """The robot with every joint at the pose that a log's sidecar, the spec or the model's file states."""
    stand = Stand(robot, actuators)
    joints = stand.others(())
    found = {j.name: (stand.default(j) if log is None else stand.stated(log, j))[0] for j in joints}
    return replace(robot, pose=found)
