"""ORD: orders of joints, in which commands and measurements are laid out."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from os.path import basename

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.rule import Rule
from actspec.diagnostics import Severity, Span
from actspec.ir import JointKind
from actspec.readings.artifact import Artifact, FileKind, Setting
from actspec.robot.joint_order import isaac_order
from actspec.robot.view import ActuatorView, RobotView

_SCALAR = (JointKind.HINGE, JointKind.SLIDE)

_SHARED = 0.8
"""Share of an order's names that a model must have to be compared. Chosen: as for pairing files."""


class ActuatorsNotInJointOrder(Rule):
    """The actuators stand in another order than the joints.

    ## What it does
    Reports an MJCF whose actuators drive the joints in another order than the joints have in the tree. A remark; a
    warning where a deploy file or configuration of the robot has an order of its own that is not the actuators'.

    ## Why it matters
    `ctrl`, and the sensors of actuators, are in the actuators' order; `qpos` and `qvel` in the joints'. Code that
    indexes both alike holds the right legs with the left ones' targets. It is the commonest question about running a
    policy in MuJoCo.

    ## Example
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <freejoint/>
          <geom size="0.1"/>
          <body>
            <joint name="FL_hip_joint"/>
            <geom size="0.1"/>
          </body>
          <body>
            <joint name="FR_hip_joint"/>
            <geom size="0.1"/>
          </body>
        </body>
      </worldbody>
      <actuator>
        <motor joint="FR_hip_joint" ctrlrange="-24 24"/>
        <motor joint="FL_hip_joint" ctrlrange="-24 24"/>
      </actuator>
    </mujoco>
    ```

    ## Use instead
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <freejoint/>
          <geom size="0.1"/>
          <body>
            <joint name="FL_hip_joint"/>
            <geom size="0.1"/>
          </body>
          <body>
            <joint name="FR_hip_joint"/>
            <geom size="0.1"/>
          </body>
        </body>
      </worldbody>
      <actuator>
        <motor joint="FL_hip_joint" ctrlrange="-24 24"/>
        <motor joint="FR_hip_joint" ctrlrange="-24 24"/>
      </actuator>
    </mujoco>
    ```

    ## Limits
    The order is often the vendor's SDK's, and right. Policies and deploy code depend on it: do not reorder a model that
    is in use; map by name, or set the finding aside with that reason.

    ## Source
    MuJoCo documentation: `ctrl` is in the order of actuators. Of 110 surveyed MJCF, 36 do this. The question:
    unitree_rl_gym#94, unitree_rl_lab#145, mujoco_menagerie#148, isaac-sim/IsaacLab#4383, fan-ziqi/rl_sar#80.
    """

    code = "ORD101"
    name = "actuator-order-is-not-joint-order"
    severity = Severity.INFO
    confidence = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Compare both orders of each MJCF."""
        looked = False
        for index, artifact in case.of_kind(FileKind.MJCF):
            robot = artifact.robot
            drives = _drives(robot) if robot is not None else ()
            if robot is None or len(drives) < 2:
                continue
            looked = True
            driven = tuple(drive.target for drive in drives)
            joints = _kept(_joints(robot), driven)
            places = _differing(driven, joints)
            if not places:
                continue
            other = _other_order(case, index, driven)
            text = (
                f"{len(places)} of {len(driven)} actuators do not stand where their joints do: place {places[0]} is "
                f"{driven[places[0]]} in ctrl and {joints[places[0]]} in qpos"
            )
            if other is not None:
                text += f"; the joint order of {basename(other[0])} is not that of ctrl"
            yield Finding(
                self.code,
                text,
                drives[places[0]].span,
                help="map by name between ctrl and qpos; a policy's order is that of the simulator that it was "
                "trained in",
                related=(other[1].span,) if other is not None else (),
                severity=self.severity if other is None else Severity.WARNING,
            )
        if not looked:
            yield Skipped(self.code, "no MJCF with several actuators on joints among the files")


class DeployOrder(Rule):
    """A joint order for the robot is not that of the model.

    ## What it does
    Compares the order of joint names in a deploy file (or `joint_sdk_names` of a configuration) with the robot's
    models. Says which order it is, where it is known and is not that of the actuators: the joints of an MJCF or URDF,
    or Isaac Lab's breadth-first order. Warns where it is none of them.

    ## Why it matters
    A policy's outputs are in the order of the simulator that it was trained in; the model that checks it and the robot
    have orders of their own. One of them taken for another sends every target to a wrong joint, and gains with it.

    ## Example
    ```xml robot.xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="left_hip"/>
          <geom size="0.1"/>
          <body>
            <joint name="left_knee"/>
            <geom size="0.1"/>
          </body>
        </body>
        <body>
          <joint name="right_hip"/>
          <geom size="0.1"/>
          <body>
            <joint name="right_knee"/>
            <geom size="0.1"/>
          </body>
        </body>
      </worldbody>
      <actuator>
        <motor joint="left_hip"/>
        <motor joint="left_knee"/>
        <motor joint="right_hip"/>
        <motor joint="right_knee"/>
      </actuator>
    </mujoco>
    ```
    ```yaml deploy.yaml
    joint_names: [left_hip, right_hip, left_knee, right_knee]
    kp: [100, 100, 150, 150]
    kd: [2, 2, 4, 4]
    ```

    ## Use instead
    ```yaml deploy.yaml
    joint_names: [left_hip, left_knee, right_hip, right_knee]
    kp: [100, 150, 100, 150]
    kd: [2, 4, 2, 4]
    ```

    ## Limits
    An order that is none of these may be the SDK's of the robot; then say so in a remark that sets the finding aside.

    ## Source
    Isaac Lab's order: isaac-sim/IsaacLab#37, and the joints of its shipped A1, Go2 and ANYmal. Issues about it:
    NVlabs/GR00T-WholeBodyControl#78, Open-X-Humanoid/TienKung-Lab#26, isaac-sim/IsaacLab#1586.
    """

    code = "ORD102"
    name = "deploy-order-against-model"
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    paired = True

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find out which order each is."""
        looked = False
        for index, artifact in enumerate(case.artifacts):
            order = _order(artifact)
            if order is None:
                continue
            names, setting = order
            models = [
                case.artifacts[other]
                for other in case.robot_of(index).artifacts
                if case.artifacts[other].robot is not None
            ]
            known = [item for model in models for item in _known_orders(model, names)]
            if not known:
                continue
            looked = True
            commands = [item for item in known if item[0].startswith("the actuators")]
            silent = commands or [item for item in known if item[0].startswith("the joints")]
            if not any(_differing(_kept(names, own), _kept(own, names)) for _, own in silent[:1]):
                continue
            finding = self._finding(artifact, names, setting.span, known, silent[0])
            if finding is not None:
                yield finding
        if not looked:
            yield Skipped(self.code, "no joint order and model of one robot among the files")

    def _finding(
        self,
        artifact: Artifact,
        names: Sequence[str],
        span: Span,
        known: Sequence[tuple[str, tuple[str, ...]]],
        first: tuple[str, tuple[str, ...]],
    ) -> Finding | None:
        ours, theirs = _kept(names, first[1]), _kept(first[1], names)
        places = _differing(ours, theirs)
        same = next(
            (text for text, own in known if not _differing(_kept(names, own), _kept(own, names))), None
        )
        differ = f"{len(places)} of {len(ours)} joints stand elsewhere than in the order of {first[0]}"
        if same is not None and same.startswith("the actuators"):
            return None
        text = (
            f"this is the order of {same}: {differ}"
            if same
            else f"this order is none of the robot's: {differ}"
        )
        others = "; ".join(text for text, _ in known)
        stated = artifact.kind is FileKind.CFG
        return Finding(
            self.code,
            f"{text}, place {places[0]} is {ours[places[0]]} and not {theirs[places[0]]}",
            span,
            help="map by name where the orders meet"
            if same
            else f"compared: {others}; if it is the SDK's, say so, and map by name where the orders meet",
            severity=Severity.INFO if same or stated else self.severity,
            confidence=Confidence.HIGH if same else Confidence.LOW if stated else self.confidence,
        )


def _drives(robot: RobotView) -> tuple[ActuatorView, ...]:
    """The first actuator of each joint that has one, in the actuators' order."""
    scalar = {joint.name for joint in robot.joints if joint.kind in _SCALAR}
    found: dict[str, ActuatorView] = {}
    for actuator in robot.actuators:
        if actuator.transmission in ("joint", "jointinparent") and actuator.target in scalar:
            found.setdefault(actuator.target, actuator)
    return tuple(found.values())


def _joints(robot: RobotView) -> tuple[str, ...]:
    return tuple(joint.name for joint in robot.joints if joint.kind in _SCALAR)


def _order(artifact: Artifact) -> tuple[tuple[str, ...], Setting] | None:
    """An order of joints that a file states, and where."""
    setting = artifact.config.settings.get("joint_order") if artifact.config is not None else None
    if setting is None or not isinstance(setting.value, tuple) or len(setting.value) < 2:
        return None
    return tuple(str(name) for name in setting.value), setting


def _other_order(case: Case, index: int, driven: Sequence[str]) -> tuple[str, Setting] | None:
    """A file of the robot with a joint order that is not the actuators'."""
    for other in case.robot_of(index).artifacts:
        order = _order(case.artifacts[other])
        if order is not None and _differing(_kept(order[0], driven), _kept(driven, order[0])):
            return case.artifacts[other].path, order[1]
    return None


def _known_orders(artifact: Artifact, names: Sequence[str]) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Orders of a model that has enough of the names, each with what it is."""
    robot = artifact.robot
    if robot is None:
        return
    joints = _joints(robot)
    shared = _kept(joints, names)
    if len(shared) < max(2.0, _SHARED * len(names)):
        return
    file = basename(artifact.path)
    driven = tuple(drive.target for drive in _drives(robot))
    if len(_kept(driven, names)) == len(shared):
        yield f"the actuators of {file}", driven
    yield f"the joints of {file}", joints
    isaac = isaac_order(robot, shared)
    if isaac is not None:
        yield f"Isaac Lab (breadth-first over {file})", isaac


def _kept(order: Sequence[str], names: Sequence[str]) -> tuple[str, ...]:
    """The names of one order that another has too."""
    kept = set(names)
    return tuple(name for name in order if name in kept)


def _differing(one: Sequence[str], other: Sequence[str]) -> list[int]:
    """Places at which two orders of the same names differ."""
    return [place for place, (a, b) in enumerate(zip(one, other, strict=True)) if a != b]


RULES: tuple[type[Rule], ...] = (ActuatorsNotInJointOrder, DeployOrder)
