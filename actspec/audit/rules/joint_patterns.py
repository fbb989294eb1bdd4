"""ORD: which joints the patterns of a configuration select."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from difflib import SequenceMatcher
from os.path import basename
from typing import ClassVar

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.ledger import LedgerRow
from actspec.audit.rule import Rule
from actspec.diagnostics import Severity, shortened
from actspec.patterns import PatternError, compile_pattern, suggest_pattern
from actspec.readings.artifact import ActuatorGroup, Artifact, FileKind, Framework
from actspec.readings.pair import joint_names, matching
from actspec.readings.versions import release

_SURE = (Severity.ERROR, Confidence.HIGH)
_NEAR = (Severity.WARNING, Confidence.MEDIUM)
_UNSURE = (Severity.INFO, Confidence.LOW)

_ALIKE = 0.9
"""How alike a pattern and the nearest one that matches are, where it is misspelt and not that of another joint.
Chosen: `wrist_pitch_joint` and `wrist_roll_joint` are 0.77, one letter more or less is above 0.9."""

_FRAMEWORKS = {Framework.ISAACLAB: "Isaac Lab", Framework.MJLAB: "mjlab"}


class JointInTwoGroups(Rule):
    """A joint is in two actuator groups.

    ## What it does
    Reports joints that the patterns of two groups of one Isaac Lab or mjlab configuration select. A warning where
    the two groups are the same class with the same numbers for it.

    ## Why it matters
    In Isaac Lab 2.x both groups write to the joint, and the one that comes last in the dictionary wins, without a word
    as long as the numbers of joints add up; 3.0 and mjlab raise an error. Which kp the joint has depends on the order
    of two lines.

    ## Example
    ```python robot_cfg.py
    from isaaclab.actuators import IdealPDActuatorCfg
    from isaaclab.assets.articulation import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": IdealPDActuatorCfg(joint_names_expr=[".*"], effort_limit=23.7, stiffness=25.0, damping=0.5),
            "knees": IdealPDActuatorCfg(joint_names_expr=[".*_knee"], effort_limit=45.4, stiffness=40.0, damping=1.0),
        }
    )
    ```
    ```xml robot.xml
    <mujoco model="leg">
      <worldbody>
        <body>
          <joint name="left_hip"/>
          <geom size="0.1"/>
          <body>
            <joint name="left_knee"/>
            <geom size="0.1"/>
          </body>
        </body>
      </worldbody>
    </mujoco>
    ```

    ## Use instead
    ```python robot_cfg.py
    from isaaclab.actuators import IdealPDActuatorCfg
    from isaaclab.assets.articulation import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={
            "hips": IdealPDActuatorCfg(joint_names_expr=[".*_hip"], effort_limit=23.7, stiffness=25.0, damping=0.5),
            "knees": IdealPDActuatorCfg(joint_names_expr=[".*_knee"], effort_limit=45.4, stiffness=40.0, damping=1.0),
        }
    )
    ```

    ## Limits
    Without a model of the robot only patterns that are written alike are known to select the same joints.

    ## Source
    Isaac Lab 2.3.2, `articulation.py` (`_process_actuators_cfg`), and the documentation of 3.0; mjlab 1.6.0, measured:
    ValueError "repeated name".
    """

    code = "ORD103"
    name = "joint-in-two-groups"
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    paired = True

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Count the groups of each joint."""
        looked = False
        named = case.versions.isaaclab
        for index, artifact in case.of_kind(FileKind.CFG):
            config = artifact.config
            if config is None or config.framework not in _FRAMEWORKS or len(config.groups) < 2:
                continue
            looked = True
            seen: dict[str, LedgerRow] = {}
            # The ledger is in the joints' order; what counts is the order of the groups.
            order = {group.span: place for place, group in enumerate(config.groups)}
            rows = sorted(case.rows_of(index), key=lambda row: order.get(row.span, len(order)))
            for row in rows:
                first = seen.setdefault(row.joint, row)
                if first.span == row.span:
                    continue
                raises = config.framework is Framework.MJLAB or (named is not None and release(named) >= (3,))
                then = (
                    "the cfg raises an error"
                    if raises
                    else "in Isaac Lab 2.x the last group wins, 3.0 raises an error"
                )
                yield Finding(
                    self.code,
                    f"group {row.actuator} selects a joint that group {first.actuator} has already: {then}",
                    row.span,
                    row.joint,
                    help="let the patterns of the groups exclude each other",
                    related=(first.span,),
                    severity=Severity.WARNING if not raises and _alike(first, row) else self.severity,
                )
        if not looked:
            yield Skipped(self.code, "no configuration with several actuator groups among the files")


def _alike(one: LedgerRow, other: LedgerRow) -> bool:
    """Whether it does not matter which of the two counts."""
    fields = (
        "control",
        "kp",
        "kd",
        "effort_limit",
        "velocity_limit",
        "armature",
        "stall_torque",
        "no_load_speed",
    )
    return all(getattr(one, field) == getattr(other, field) for field in fields)


class PatternMatchesNothing(Rule):
    """A pattern of joint names matches no joint.

    ## What it does
    Reports keys of values by joint (`stiffness={".*_hip": 25.0}`) that match none of their group's joints: an error
    where they match others of the robot. Where they match none, and at least `share` (default 0.5) of the keys beside
    them match, and for patterns of groups that match no joint of the model, where the configuration carries the model's
    name and `share` of its patterns match: a warning where a near pattern matches, else a remark.

    ## Why it matters
    Isaac Lab and mjlab raise a ValueError for it when the robot is made: "Not all regular expressions are matched". A
    pattern that was right for another variant of the robot leaves its joints without a drive.

    ## Example
    ```python robot_cfg.py
    from isaaclab.actuators import IdealPDActuatorCfg
    from isaaclab.assets.articulation import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": IdealPDActuatorCfg(
                joint_names_expr=[".*_hip", ".*_knee"],
                effort_limit=23.7,
                stiffness={".*_hip": 25.0, ".*_kne": 40.0},
                damping=0.5,
            )
        }
    )
    ```
    ```xml robot.xml
    <mujoco model="leg">
      <worldbody>
        <body>
          <joint name="left_hip"/>
          <geom size="0.1"/>
          <body>
            <joint name="left_knee"/>
            <geom size="0.1"/>
          </body>
        </body>
      </worldbody>
    </mujoco>
    ```

    ## Use instead
    ```python robot_cfg.py
    from isaaclab.actuators import IdealPDActuatorCfg
    from isaaclab.assets.articulation import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": IdealPDActuatorCfg(
                joint_names_expr=[".*_hip", ".*_knee"],
                effort_limit=23.7,
                stiffness={".*_hip": 25.0, ".*_knee": 40.0},
                damping=0.5,
            )
        }
    )
    ```

    ## Limits
    The USD that a configuration names is not read; a URDF or MJCF of another variant may lack joints that it has.

    ## Source
    Isaac Lab 2.3.2, `string.py` (`resolve_matching_names`, `resolve_matching_names_values`), measured; mjlab 1.6.0,
    the same functions.
    """

    code = "ORD104"
    name = "pattern-matches-nothing"
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    paired = True
    options: ClassVar[dict[str, float]] = {"share": 0.5}

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Match every pattern that has joints to be held against."""
        looked = False
        for index, artifact in case.of_kind(FileKind.CFG):
            config = artifact.config
            if config is None or config.framework not in _FRAMEWORKS:
                continue
            model = _model(case, index)
            if model is not None:
                looked = True
                for group in config.groups:
                    yield from self._keys(case, index, config.framework, group, model)
                yield from self._patterns(case, index, config.framework, model)
        if not looked:
            yield Skipped(self.code, "no configuration with a model of its robot among the files")

    def _keys(
        self, case: Case, index: int, framework: Framework, group: ActuatorGroup, model: Artifact
    ) -> Iterator[Finding]:
        joints = [row.joint for row in case.rows_of(index) if row.span == group.span]
        everywhere = joint_names(model) or ()
        for name, setting in group.settings.items():
            if not joints or not isinstance(setting.value, Mapping):
                continue
            keys = [key for key, value in setting.value.items() if isinstance(value, int | float)]
            missing = [key for key in keys if _selects_nothing(framework, key, joints)]
            fitting = len(keys) - len(missing) >= self.option(case, "share") * len(keys)
            for key in missing:
                outside = not _selects_nothing(framework, key, everywhere)
                # A group of `.*` fits any model: if few of its keys do, the model is another robot's.
                if not (fitting or outside):
                    continue
                near = _misspelt(key, joints)
                severity, confidence = _SURE if outside else _NEAR if near else _UNSURE
                yield Finding(
                    self.code,
                    f"the key '{shortened(key)}' of {name} matches no joint of group {group.name} in "
                    f"{basename(model.path)}: the cfg raises a ValueError",
                    setting.span,
                    help=f"did you mean '{near}'?"
                    if near
                    else "leave it out, or add its joints to the group",
                    severity=severity,
                    confidence=confidence,
                )

    def _patterns(self, case: Case, index: int, framework: Framework, model: Artifact) -> Iterator[Finding]:
        config = case.artifacts[index].config
        members = (case.artifacts[other] for other in case.robot_of(index).artifacts)
        # A pattern that one variant of the robot has a joint for is right.
        names = tuple(dict.fromkeys(name for member in members for name in joint_names(member) or ()))
        groups = config.groups if config is not None else ()
        every = [(group, pattern) for group in groups for pattern in group.joints or ()]
        missing = [item for item in every if _selects_nothing(framework, item[1], names)]
        if not every or len(every) - len(missing) < self.option(case, "share") * len(every):
            return
        for group, pattern in missing:
            near = _misspelt(pattern, names)
            severity, confidence = _NEAR if near else _UNSURE
            yield Finding(
                self.code,
                f"the pattern '{shortened(pattern)}' matches no joint of {basename(model.path)}: with these joint "
                f"names {_FRAMEWORKS[framework]} raises a ValueError",
                group.span,
                help=f"did you mean '{near}'?" if near else "is it a model of another variant of the robot?",
                severity=severity,
                confidence=confidence,
            )


def _model(case: Case, index: int) -> Artifact | None:
    """The model of the configuration's robot."""
    members = (case.artifacts[other] for other in case.robot_of(index).artifacts)
    return next((member for member in members if member.robot is not None), None)


def _misspelt(pattern: str, names: list[str] | tuple[str, ...]) -> str | None:
    """The pattern that was meant; None where none is near enough to say so."""
    near = suggest_pattern(pattern, names)
    return near if near and SequenceMatcher(None, pattern, near).ratio() >= _ALIKE else None


def _selects_nothing(framework: Framework, pattern: str, names: list[str] | tuple[str, ...]) -> bool:
    """Whether a pattern that can be judged selects no joint."""
    try:
        compile_pattern(pattern)
    except PatternError:
        return False
    return not matching(framework, pattern, names)


RULES: tuple[type[Rule], ...] = (JointInTwoGroups, PatternMatchesNothing)
