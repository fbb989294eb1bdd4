"""Which joints follow a law, and what engines are asked of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from actspec.diagnostics import Collector, shortened
from actspec.ir import ActuatorSet, JointActuator, Level, Network
from actspec.laws import TorqueLaw, law_of
from actspec.laws.network import NetworkDrive
from actspec.simulate.excitation import COURSES, HeldMotion, held_motions, network_courses
from actspec.targets.kit.network import network_clip, onnx_of, read_network
from actspec.verify.agreement import Skip, TargetFiles


@dataclass(frozen=True, slots=True)
class JointLaws:
    """The joints whose torque follows a law.

    Attributes:
        joints: Those with a law or a network, in the robot's order.
        laws: Joint to its law.
        networks: Joint to its network's, of level actuator_net.
        skipped: Why the others have none, by group, and what would change that.
    """

    joints: tuple[JointActuator, ...]
    laws: Mapping[str, TorqueLaw]
    networks: Mapping[str, NetworkDrive]
    skipped: Mapping[str, tuple[str, str | None]]

    @property
    def columns(self) -> Mapping[str, int]:
        """Joint to its column in the motions."""
        return {actuator.joint: i for i, actuator in enumerate(self.joints)}

    def without_networks(self, reason: str, help: str | None) -> JointLaws:
        """The same without the networks, which are skipped for a reason."""
        left = tuple(actuator for actuator in self.joints if actuator.joint in self.laws)
        gone = {a.group: (reason, help) for a in self.joints if a.joint in self.networks}
        return replace(self, joints=left, networks={}, skipped={**self.skipped, **gone})


def laws_of(actuators: ActuatorSet) -> JointLaws:
    """The law of every joint that has one; networks are read as data, and run nowhere."""
    step = actuators.physics_dt.require()
    found: dict[str, TorqueLaw] = {}
    drives: dict[str, NetworkDrive] = {}
    skipped: dict[str, tuple[str, str | None]] = {}
    read: dict[Network | None, NetworkDrive | tuple[str, str | None]] = {}
    for actuator in actuators.joints:
        try:
            if actuator.level is not Level.ACTUATOR_NET:
                found[actuator.joint] = law_of(actuator)
                continue
            clip = law_of(network_clip(actuator))
        except ValueError as err:
            skipped[actuator.group] = shortened(str(err), 200), None
            continue
        if actuator.network not in read:
            read[actuator.network] = _drive(actuator, clip, step)
        drive = read[actuator.network]
        if isinstance(drive, NetworkDrive):
            drives[actuator.joint] = replace(drive, clip=clip)
        else:
            skipped[actuator.group] = drive
    known = tuple(a for a in actuators.joints if a.joint in found or a.joint in drives)
    return JointLaws(known, found, drives, skipped)


def _drive(actuator: JointActuator, clip: TorqueLaw, step: float) -> NetworkDrive | tuple[str, str | None]:
    """The network of a joint, or why it is not known and what would change that."""
    named = onnx_of(actuator)
    if named is None:
        help = "`actspec net convert` writes all files of a network; name its manifest"
        return "its network has no ONNX file, of which alone the law is read", help
    said = Collector()
    found = read_network(named, "onnx", said)
    law = None if found is None else found.law(step)
    if found is None or law is None:
        first = next(iter(said.sorted()), None)
        reason = "its network cannot be read" if first is None else first.message
        return shortened(reason, 200), None if first is None else first.help
    ends = found.manifest.range
    most = None if ends is None else (ends.error.largest, ends.velocity.largest)
    return NetworkDrive(law, clip, most)


def motions_of(laws: JointLaws, step: float) -> dict[str, HeldMotion]:
    """What engines are asked of the joints: each law its grid and histories, each network its courses.

    A joint that is not asked in a motion is held at 0.

    Args:
        laws: Of the joints.
        step: Physics step [s].
    """
    import numpy as np

    found: dict[str, HeldMotion] = {}
    width = len(laws.joints)

    def add(motions: Mapping[str, HeldMotion], columns: list[int]) -> None:
        for name, motion in motions.items():
            parts = []
            for part in motion.arrays:
                whole = np.zeros((*part.shape[:2], width))
                whole[:, :, columns] = part
                parts.append(whole)
            found[name] = HeldMotion(*parts)

    mine = [(i, a) for i, a in enumerate(laws.joints) if a.joint in laws.laws]
    if mine:
        joints = [actuator for _, actuator in mine]
        add(held_motions([laws.laws[a.joint] for a in joints], joints, step), [i for i, _ in mine])
    learned = [(i, a) for i, a in enumerate(laws.joints) if a.joint in laws.networks]
    if learned:
        drives = [laws.networks[actuator.joint] for _, actuator in learned]
        add({COURSES: network_courses(drives, step)}, [i for i, _ in learned])
    return found


def law_skips(target: TargetFiles, laws: JointLaws) -> Iterator[Skip]:
    """Groups without a law, and networks, which are let go nowhere, for one target."""
    for group, (reason, help) in laws.skipped.items():
        yield Skip(target.name, group, "torque", reason, help)
    for group in dict.fromkeys(a.group for a in laws.joints if a.joint in laws.networks):
        yield Skip(target.name, group, "responses", "of a network torques along courses are compared")
