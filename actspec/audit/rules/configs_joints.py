"""CFG: joints that a configuration leaves without a value, or without a drive."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from os.path import basename, splitext
from typing import ClassVar

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.rule import Rule
from actspec.audit.rules.cfg_groups import Group, groups_of
from actspec.diagnostics import Severity, shortened
from actspec.ir import JointKind
from actspec.readings.artifact import ActuatorGroup, Artifact, FileKind, Framework, RobotConfig, Setting
from actspec.readings.pair import joint_names, matching
from actspec.readings.versions import release
from actspec.robot.view import RobotView

_DEAD = "the drive gives no torque"

_ZERO = {
    "effort_limit": _DEAD,
    "effort_limit_sim": _DEAD,
    "velocity_limit": "its torque-speed line ends at standstill",
    "velocity_limit_sim": "the solver holds it at standstill",
    "stiffness": "the drive does not follow its target",
    "damping": "the drive does not damp it",
    "armature": "the USD's value is lost",
    "friction": "the USD's value is lost",
    "dynamic_friction": "the USD's value is lost",
    "viscous_friction": "the USD's value is lost",
}
"""Field of Isaac Lab 2.x to what 0 does there."""

_PLAIN = re.compile(r"[A-Za-z0-9_/:-]*")


class DictMissesJoint(Rule):
    """A dict of an actuator group has no key for one of its joints.

    ## What it does
    Reports joints of an Isaac Lab group that no key of a dict matches (`stiffness={".*_hip_joint": 25}` for a group
    with knees), and joints of a legged_gym robot whose name holds no key of `stiffness`. Joints come from the robot's
    model; without one, patterns are reported that no key can share a joint with.

    ## Why it matters
    Isaac Lab 2.x gives such a joint 0, not the USD's value, and says nothing: a limit of 0 is a dead joint, a stiffness
    of 0 one that hangs. legged_gym prints a line and sets both gains to 0.

    ## Example
    ```python robot_cfg.py
    from isaaclab.actuators import IdealPDActuatorCfg
    from isaaclab.assets.articulation import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": IdealPDActuatorCfg(
                joint_names_expr=[".*_hip_joint", ".*_thigh_joint", ".*_calf_joint"],
                effort_limit={".*_hip_joint": 23.7, ".*_thigh_joint": 23.7},
                stiffness=25.0,
                damping=0.5,
            )
        }
    )
    ```

    ## Use instead
    ```python robot_cfg.py
    from isaaclab.actuators import IdealPDActuatorCfg
    from isaaclab.assets.articulation import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": IdealPDActuatorCfg(
                joint_names_expr=[".*_hip_joint", ".*_thigh_joint", ".*_calf_joint"],
                effort_limit={".*_hip_joint": 23.7, ".*_thigh_joint": 23.7, ".*_calf_joint": 45.4},
                stiffness=25.0,
                damping=0.5,
            )
        }
    )
    ```

    ## Limits
    Without a model, patterns with more than names and `.*` are not judged. Isaac Lab 3.0 was not measured.

    ## Source
    Isaac Lab 2.3.2 classes, measured: 25 for the hips of `{".*_hip_joint": 25}`, 0 for the other joints. legged_gym,
    `legged_robot.py`, `_init_buffers`.
    """

    code = "CFG101"
    name = "dict-misses-a-joint"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    paired = True

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find joints without a key."""
        looked = False
        named = case.versions.isaaclab
        if named is None or release(named) < (3,):
            for group in groups_of(case, Framework.ISAACLAB):
                for name in _ZERO:
                    keys = _keys(group.cfg.settings.get(name))
                    looked = looked or keys is not None
                    if keys is not None:
                        yield from self._missed(group, name, keys)
        for index, artifact in case.of_kind(FileKind.CFG):
            config = artifact.config
            if config is None or config.framework is not Framework.LEGGED_GYM:
                continue
            model = _model(case, index, config)
            if model is None:
                continue
            for cfg in config.groups:
                keys = _keys(cfg.settings.get("stiffness"))
                if keys is not None and cfg.cls in ("P", "V"):
                    looked = True
                    yield from self._legged_gym(model, cfg, keys)
        if not looked:
            yield Skipped(self.code, "no Isaac Lab 2.x or legged_gym configuration with values by joint")

    def _missed(self, group: Group, name: str, keys: Sequence[str]) -> Iterator[Finding]:
        setting = group.cfg.settings[name]
        for row in group.rows:
            if any(_may_match(group.framework, key, row.joint) for key in keys):
                continue
            yield Finding(
                self.code,
                f"no key of {name} matches this joint of group {shortened(group.cfg.name)!r}: Isaac Lab 2.x gives it "
                f"0, and {_ZERO[name]}",
                setting.span,
                row.joint,
                0.0,
                "1",
                help=f"add a key for it, or {{'.*': ...}}; keys: {', '.join(map(repr, keys[:8]))}",
                severity=Severity.ERROR if name in ("effort_limit", "effort_limit_sim") else None,
            )

    def _legged_gym(self, model: Artifact, cfg: ActuatorGroup, keys: Sequence[str]) -> Iterator[Finding]:
        for joint in joint_names(model) or ():
            if not any(key in joint for key in keys):
                yield Finding(
                    self.code,
                    f"no key of stiffness is part of the name of this joint of {basename(model.path)}: legged_gym "
                    "gives it kp 0 and kd 0",
                    cfg.settings["stiffness"].span,
                    joint,
                    help=f"keys: {', '.join(map(repr, keys[:8]))}",
                )


def _keys(setting: Setting | None) -> Sequence[str] | None:
    """Keys of a dict by joint; None for anything else."""
    if setting is None or setting.unknown is not None or not isinstance(setting.value, Mapping):
        return None
    return tuple(map(str, setting.value))


def _may_match(framework: Framework, key: str, joint: str) -> bool:
    """Whether a key matches a joint, or may match one that the pattern in its place stands for."""
    if key == joint or matching(framework, key, (joint,)):
        return True
    return _PLAIN.fullmatch(joint) is None and overlap(key, joint)


def overlap(one: str, other: str) -> bool:
    """Whether a name could match both patterns; True where a pattern has more than plain text and `.*`."""
    tokens = [_tokens(one), _tokens(other)]
    first, second = tokens
    if first is None or second is None:
        return True
    # Row by row from the ends: whether what is left of both can be the same text.
    below = [all(token is None for token in second[j:]) for j in range(len(second) + 1)]
    for token in reversed(first):
        row = [False] * (len(second) + 1)
        row[-1] = token is None and below[-1]
        for j in range(len(second) - 1, -1, -1):
            if token is None or second[j] is None:
                row[j] = below[j] or row[j + 1]
            else:
                row[j] = token == second[j] and below[j + 1]
        below = row
    return below[0]


def _tokens(pattern: str) -> list[str | None] | None:
    """Characters, None for `.*`; None where there is more than that."""
    parts = pattern.split(".*")
    if not all(map(_PLAIN.fullmatch, parts)):
        return None
    found: list[str | None] = list(parts[0])
    for part in parts[1:]:
        found += [None, *part]
    return found


class JointNotCovered(Rule):
    """A driven joint of the robot is in no actuator group.

    ## What it does
    Compares the groups of a configuration with the robot's MJCF. For mjlab: joints of the MJCF that neither a group, an
    actuator of the MJCF, an equality nor a tendon moves. For Isaac Lab: joints that the MJCF drives and no group
    selects, as a remark, because the USD may lack them. Only where the groups cover `share` of these joints (default
    0.6): with fewer the others are meant to be free.

    ## Why it matters
    A joint without a drive swings freely. A policy learns with it hanging, and meets it held, or the other way round.

    ## Example
    ```xml dog.xml
    <mujoco model="dog">
      <worldbody>
        <body>
          <joint name="hip_joint"/>
          <geom size="0.1"/>
          <body pos="0 0 -0.2">
            <joint name="knee_joint"/>
            <geom size="0.1"/>
            <body pos="0 0 -0.2">
              <joint name="ankle_joint"/>
              <geom size="0.1"/>
            </body>
          </body>
        </body>
      </worldbody>
    </mujoco>
    ```
    ```python dog_constants.py
    from pathlib import Path

    import mujoco
    from mjlab.actuator import BuiltinPositionActuatorCfg
    from mjlab.entity import EntityArticulationInfoCfg, EntityCfg


    def get_spec() -> mujoco.MjSpec:
        return mujoco.MjSpec.from_file(str(Path(__file__).parent / "dog.xml"))


    LEG = BuiltinPositionActuatorCfg(
        target_names_expr=("hip_joint", "knee_joint"), stiffness=20.0, damping=1.0, effort_limit=23.7
    )
    DOG_ARTICULATION = EntityArticulationInfoCfg(actuators=(LEG,))


    def get_dog_cfg() -> EntityCfg:
        return EntityCfg(spec_fn=get_spec, articulation=DOG_ARTICULATION)
    ```

    ## Use instead
    ```python dog_constants.py
    from pathlib import Path

    import mujoco
    from mjlab.actuator import BuiltinPositionActuatorCfg
    from mjlab.entity import EntityArticulationInfoCfg, EntityCfg


    def get_spec() -> mujoco.MjSpec:
        return mujoco.MjSpec.from_file(str(Path(__file__).parent / "dog.xml"))


    LEG = BuiltinPositionActuatorCfg(
        target_names_expr=(".*_joint",), stiffness=20.0, damping=1.0, effort_limit=23.7
    )
    DOG_ARTICULATION = EntityArticulationInfoCfg(actuators=(LEG,))


    def get_dog_cfg() -> EntityCfg:
        return EntityCfg(spec_fn=get_spec, articulation=DOG_ARTICULATION)
    ```

    ## Limits
    Passive joints on purpose (springs, casters) look the same: those with a stiffness in the MJCF are left out.

    ## Source
    mjlab 1.6.0 makes actuators for the joints of its cfgs alone. Isaac Lab 2.3.2, articulation.py: a line in the log
    when fewer joints are in groups than the robot has.
    """

    code = "CFG102"
    name = "joint-not-covered"
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    paired = True
    options: ClassVar[dict[str, float]] = {"share": 0.6}

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find joints that are in no group."""
        looked = False
        for index, artifact in case.of_kind(FileKind.CFG):
            config = artifact.config
            if config is None or config.framework not in (Framework.MJLAB, Framework.ISAACLAB):
                continue
            if not _whole(config):
                continue
            covered = {row.joint for row in case.rows_of(index)}
            for other in case.robot_of(index).artifacts:
                model = case.artifacts[other]
                if model.kind is not FileKind.MJCF or model.robot is None:
                    continue
                own = config.framework is Framework.MJLAB
                if own and not _names(config, model):
                    continue
                looked = True
                driven = {row.joint for row in case.rows_of(other) if row.joint and row.control != "none"}
                loose = _loose(model.robot) - driven if own else driven
                if len(loose & covered) >= self.option(case, "share") * len(loose):
                    yield from self._uncovered(config, model.robot, loose - covered, own)
        if not looked:
            yield Skipped(
                self.code, "no whole configuration of Isaac Lab or mjlab beside an MJCF of its robot"
            )

    def _uncovered(
        self, config: RobotConfig, robot: RobotView, joints: set[str], own: bool
    ) -> Iterator[Finding]:
        file = basename(robot.path)
        for joint in robot.joints:
            if joint.name in joints:
                yield Finding(
                    self.code,
                    f"this joint of {file} is in no actuator group, and nothing else moves it: it swings freely"
                    if own
                    else f"{file} drives this joint, and no actuator group selects it: where the USD has it, it swings "
                    "freely",
                    config.span,
                    joint.name,
                    help="add it to a group",
                    related=(joint.span,),
                    severity=None if own else Severity.INFO,
                )


def _whole(config: RobotConfig) -> bool:
    """Whether the groups are a robot's, and all of them are known."""
    if not config.groups or any(group.joints is None for group in config.groups):
        return False
    if any(note.where.startswith("actuators") for note in config.notes):
        return False
    return len(config.groups) > 1 or config.groups[0].name != config.name


def _names(config: RobotConfig, model: Artifact) -> bool:
    """Whether a configuration names this model, or none."""
    setting = config.settings.get("model")
    if setting is None or not isinstance(setting.value, str):
        return True
    return splitext(basename(setting.value))[0] == splitext(basename(model.path))[0]


def _model(case: Case, index: int, config: RobotConfig) -> Artifact | None:
    """The URDF or MJCF of a configuration's robot that it names, or any where it names none."""
    artifacts = (case.artifacts[other] for other in case.robot_of(index).artifacts)
    return next((one for one in artifacts if one.robot is not None and _names(config, one)), None)


def _loose(robot: RobotView) -> set[str]:
    """Joints that no spring, equality or tendon of an MJCF holds."""
    held = {
        found.decode("utf-8", "replace")
        for file in robot.files
        for found in re.findall(rb"""(?:joint[12]|<joint\s+joint)\s*=\s*["']([^"']+)""", file.data)
    }
    return {
        joint.name
        for joint in robot.joints
        if joint.kind in (JointKind.HINGE, JointKind.SLIDE)
        and joint.name not in held
        and joint.stiffness == 0.0
    }


RULES: tuple[type[Rule], ...] = (DictMissesJoint, JointNotCovered)
