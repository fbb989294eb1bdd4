"""SRC: what a policy was trained with and what runs it, where the two do not agree."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from actspec.audit.case import Case
from actspec.audit.dynamics import settings_of
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.rule import Rule
from actspec.audit.rules.source_pairs import Disagreement, compared, disagreements
from actspec.audit.rules.source_rule import SourceRule, shown
from actspec.diagnostics import Severity, Span
from actspec.readings.artifact import FileKind

POSE = 0.01
"""Chosen: rad or m up to which two default positions are one, half a degree."""


class ActionOrPose(SourceRule):
    """A deploy file turns actions into commands in another way than training did.

    ## What it does
    Compares the action scale and the default position of each joint in a deploy file with those of the training
    configuration.

    ## Why it matters
    The command is default position + scale * action. With another scale each action moves the joint further or less
    far than the policy learnt, with another default position every command is off by the difference.

    ## Example
    ```yaml a1/train_deploy.yaml
    joint_names: [waist_joint]
    kp: [40]
    action_scale: [0.25]
    ```
    ```python a1/waist_cfg.py
    from legged_gym.envs.base.legged_robot_config import LeggedRobotCfg

    class A1WaistCfg(LeggedRobotCfg):
        class init_state(LeggedRobotCfg.init_state):
            default_joint_angles = {"waist_joint": 0.0}

        class control(LeggedRobotCfg.control):
            control_type = "P"
            stiffness = {"waist": 40.0}
            damping = {"waist": 2.0}
            action_scale = 0.5
            decimation = 4
    ```

    ## Use instead
    ```yaml a1/train_deploy.yaml
    joint_names: [waist_joint]
    kp: [40]
    action_scale: [0.5]
    ```

    ## Limits
    A scale that is computed (0.25 times effort over stiffness) is compared only where it can be folded.

    ## Source
    unitreerobotics/unitree_rl_mjlab#32: waist action scale 0.35 in the deploy file, 0.55 in training. Chosen: equal
    within 1 %, and default positions within 0.01 rad.
    """

    code = "SRC106"
    name = "action-or-pose-disagrees"
    confidence = Confidence.HIGH
    groups = (("action_scale",), ("default_position",))
    lacks = "an action scale or default position of one joint"

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Compare deploy files with the training configuration."""
        tolerance = self.option(case, "tolerance")
        for fields, absolute in zip(self.groups, (0.0, POSE), strict=True):
            for found in disagreements(case, fields, tolerance, absolute):
                kinds = {case.artifacts[rows[0].artifact].kind for rows in (found.rows, found.others)}
                if kinds == {FileKind.DEPLOY, FileKind.CFG}:
                    yield self.finding(case, found)
        if not any(compared(case, fields, FileKind.DEPLOY) for fields in self.groups):
            yield Skipped(self.code, f"no deploy file and configuration of one robot state {self.lacks}")

    def consequence(self, case: Case, found: Disagreement) -> str:
        """How far the joint goes."""
        mine, theirs = found.mine, found.theirs
        assert mine.value is not None and theirs.value is not None
        if found.field == "action_scale":
            times = "0" if found.ratio is None else f"{abs(found.ratio):.3g}"
            sign = ", the other way" if found.ratio is not None and found.ratio < 0.0 else ""
            return f"the same action moves the command {times} times as far as in training{sign}"
        return f"every command is {shown(mine.value - theirs.value, mine.unit)} off"


class Timing(SourceRule):
    """A deploy file runs the policy at another rate than training did.

    ## What it does
    Compares the control period of a deploy file, as stated or as physics step times decimation, with that of the
    robot's training configuration. Where the periods agree and only the physics steps differ, it remarks that.

    ## Why it matters
    A policy knows the world at its own rate: histories, velocities by difference, delays in steps and gaits all
    stretch with the period. At another physics step the same explicit drive has another damping.

    ## Example
    ```yaml a1/train_deploy.yaml
    joint_names: [waist_joint]
    kp: [40]
    control_dt: 0.03
    ```
    ```python a1/waist_cfg.py
    from legged_gym.envs.base.legged_robot_config import LeggedRobotCfg

    class A1WaistCfg(LeggedRobotCfg):
        class control(LeggedRobotCfg.control):
            control_type = "P"
            stiffness = {"waist": 40.0}
            damping = {"waist": 2.0}
            decimation = 4

        class sim(LeggedRobotCfg.sim):
            dt = 0.005
    ```

    ## Use instead
    ```yaml a1/train_deploy.yaml
    joint_names: [waist_joint]
    kp: [40]
    control_dt: 0.02
    ```

    ## Limits
    A deploy file whose loop runs faster than the policy (a drive loop at 500 Hz) states its own rate: set it aside
    with the reason.

    ## Source
    mujocolab/mjlab#1001, google-deepmind/mujoco_playground#109. Chosen: equal within 1 %.
    """

    code = "SRC107"
    name = "timing-disagrees"
    confidence = Confidence.HIGH
    options: ClassVar[dict[str, float]] = {"tolerance": 0.01}

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Compare the periods of each robot's deploy files."""
        looked = False
        tolerance = self.option(case, "tolerance")
        for robot in case.robots:
            trained = [i for i in robot.artifacts if case.artifacts[i].kind is FileKind.CFG]
            for index in robot.artifacts:
                if case.artifacts[index].kind is not FileKind.DEPLOY:
                    continue
                for name in ("control_dt", "physics_dt"):
                    mine = self._period(case, index, name)
                    theirs = [
                        (i, found) for i in trained if (found := self._period(case, i, name)) is not None
                    ]
                    if mine is None or not theirs:
                        continue
                    looked = True
                    if any(abs(mine / other - 1.0) <= tolerance for _, other in theirs):
                        continue
                    yield self._told(case, index, name, mine, *theirs[0])
                    break
        if not looked:
            yield Skipped(self.code, "no deploy file and configuration of one robot state a control period")

    def _period(self, case: Case, index: int, name: str) -> float | None:
        value = settings_of(case.artifacts[index]).get(name)
        return value if isinstance(value, float) and value > 0.0 else None

    def _told(self, case: Case, index: int, name: str, mine: float, other: int, theirs: float) -> Finding:
        file = case.artifacts[other].path
        ratio = mine / theirs
        if name == "control_dt":
            what = (
                f"the policy runs every {mine * 1e3:.3g} ms here and every {theirs * 1e3:.3g} ms in {file} "
                f"(x{ratio:.3g}): what it takes for one step of time is another"
            )
        else:
            what = (
                f"the physics step is {mine * 1e3:.3g} ms here and {theirs * 1e3:.3g} ms in {file} (x{ratio:.3g}), "
                "at the same control period: explicit drives and contacts act otherwise"
            )
        rare = name == "physics_dt"
        return Finding(
            self.code,
            what,
            _place(case, index, name),
            value=mine,
            unit="s",
            expected=theirs,
            help="run the policy at the rate that it was trained with",
            related=(_place(case, other, name),),
            severity=Severity.INFO if rare else None,
            confidence=Confidence.LOW if rare else None,
        )


def _place(case: Case, index: int, name: str) -> Span:
    """Where a period is written, or what it is computed from."""
    artifact = case.artifacts[index]
    settings = artifact.config.settings if artifact.config is not None else {}
    found = next((settings[key] for key in (name, "decimation", "physics_dt") if key in settings), None)
    return found.span if found is not None else Span(artifact.path)


RULES: tuple[type[Rule], ...] = (ActionOrPose, Timing)
