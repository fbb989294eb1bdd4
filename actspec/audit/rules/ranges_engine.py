"""DRN: what Isaac Lab and mjlab make of a range beyond what it says."""

from __future__ import annotations

import math
from collections.abc import Iterator

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.rule import Rule
from actspec.audit.rules.joint_units import shown
from actspec.audit.rules.randomized import ends, ranges, rows_in, written
from actspec.diagnostics import Severity
from actspec.readings.artifact import Framework, RobotConfig
from actspec.readings.pair import matching
from actspec.readings.versions import friction_unit_of

SPEED = 10.0
"""Joint speed at which a consequence is told [rad/s]. Chosen: a leg's joint in a trot."""


class FrictionRangeSetsViscous(Rule):
    """A friction range of Isaac Lab is drawn for viscous friction too.

    ## What it does
    Reports friction ranges of `randomize_joint_parameters` with operation abs or add: from Isaac Lab 2.3 on Isaac Sim 5
    a warning where these are named, a remark where no version is.

    ## Why it matters
    On these versions the one range is drawn three times, for static, dynamic and viscous friction. A dry friction of
    0.1 to 0.3 N*m brings a viscous one of 0.1 to 0.3 N*m*s/rad: 1 to 3 N*m at 10 rad/s, as much as the dry part
    tenfold.

    ## Example
    ```sh
    actspec audit cfg.py --target isaaclab==2.3 --target isaac_sim==5.1
    ```
    ```python cfg.py
    import isaaclab.envs.mdp as mdp
    from isaaclab.managers import EventTermCfg, SceneEntityCfg
    from isaaclab.utils import configclass


    @configclass
    class EventCfg:
        friction = EventTermCfg(
            func=mdp.randomize_joint_parameters,
            mode="startup",
            params={
                "asset_cfg": SceneEntityCfg("robot", joint_names=".*"),
                "friction_distribution_params": (0.1, 0.3),
                "operation": "abs",
            },
        )
    ```

    ## Use instead
    ```python cfg.py
    import isaaclab.envs.mdp as mdp
    from isaaclab.managers import EventTermCfg, SceneEntityCfg
    from isaaclab.utils import configclass


    @configclass
    class EventCfg:
        friction = EventTermCfg(
            func=mdp.randomize_joint_parameters,
            mode="startup",
            params={
                "asset_cfg": SceneEntityCfg("robot", joint_names=".*"),
                "friction_distribution_params": (0.5, 1.5),
                "operation": "scale",
            },
        )
    ```

    ## Limits
    Scale keeps the three apart: each is multiplied by its own draw.

    ## Source
    Isaac Lab 2.3.2, envs/mdp/events.py, measured with Isaac Sim 5.1: `abs (0.1, 0.3)` set a viscous friction of 0.18
    N*m*s/rad where it had been 0.01.
    """

    code = "DRN104"
    name = "friction-range-sets-viscous"
    severity = Severity.WARNING
    confidence = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find ranges of friction that are not scales."""
        looked = False
        for index, config, one in ranges(case):
            unit = friction_unit_of(case.versions_of(index))
            if one.field != "friction" or config.framework is not Framework.ISAACLAB:
                continue
            looked = True
            if one.operation == "scale" or (unit is not None and not unit.torque):
                continue
            low, high = ends(one)
            low = max(low, 0.0)
            told = f"{written(low, high, 'N*m*s/rad')}, {written(SPEED * low, SPEED * high, 'N*m')} at {SPEED:g} rad/s"
            if one.operation == "add":
                told = f"{written(low, high, 'N*m*s/rad')} more"
            yield Finding(
                self.code,
                f"{'on Isaac Sim 5 and later ' if unit is None else ''}this friction range is drawn for viscous "
                f"friction as well: {told}",
                one.span,
                help='use operation "scale", with friction, dynamic_friction and viscous_friction in the actuator cfg',
                severity=Severity.INFO if unit is None else None,
            )
        if not looked:
            yield Skipped(self.code, "no Isaac Lab configuration randomises joint friction")


class EffortRangeCapped(Rule):
    """A range raises an effort limit that stays where it was compiled.

    ## What it does
    Reports ranges of `dr.effort_limits` above the limit for mjlab's classes that compute the torque themselves
    (`IdealPdActuatorCfg`, `DcMotorActuatorCfg`, `LearnedMlpActuatorCfg`).

    ## Why it matters
    These classes act through a `<motor>` whose force range is set when the model is compiled. The range moves the clamp
    in Python alone: draws above the limit are cut at it, and half of a symmetric range is no randomisation.

    ## Example
    ```python cfg.py
    from mjlab.actuator import IdealPdActuatorCfg
    from mjlab.entity import EntityArticulationInfoCfg, EntityCfg
    from mjlab.envs import ManagerBasedRlEnvCfg
    from mjlab.envs.mdp import dr
    from mjlab.managers.event_manager import EventTermCfg
    from mjlab.managers.scene_entity_config import SceneEntityCfg
    from mjlab.scene import SceneCfg

    LEGS = IdealPdActuatorCfg(target_names_expr=(".*",), stiffness=20.0, damping=1.0, effort_limit=20.0)
    ROBOT = EntityCfg(articulation=EntityArticulationInfoCfg(actuators=(LEGS,)))


    def make_env_cfg() -> ManagerBasedRlEnvCfg:
        return ManagerBasedRlEnvCfg(
            scene=SceneCfg(entities={"robot": ROBOT}),
            events={
                "limits": EventTermCfg(
                    func=dr.effort_limits,
                    params={"effort_limit_range": (0.8, 1.2), "asset_cfg": SceneEntityCfg("robot")},
                )
            },
        )
    ```

    ## Use instead
    ```python cfg.py
    from mjlab.actuator import BuiltinPositionActuatorCfg
    from mjlab.entity import EntityArticulationInfoCfg, EntityCfg
    from mjlab.envs import ManagerBasedRlEnvCfg
    from mjlab.envs.mdp import dr
    from mjlab.managers.event_manager import EventTermCfg
    from mjlab.managers.scene_entity_config import SceneEntityCfg
    from mjlab.scene import SceneCfg

    LEGS = BuiltinPositionActuatorCfg(target_names_expr=(".*",), stiffness=20.0, damping=1.0, effort_limit=20.0)
    ROBOT = EntityCfg(articulation=EntityArticulationInfoCfg(actuators=(LEGS,)))


    def make_env_cfg() -> ManagerBasedRlEnvCfg:
        return ManagerBasedRlEnvCfg(
            scene=SceneCfg(entities={"robot": ROBOT}),
            events={
                "limits": EventTermCfg(
                    func=dr.effort_limits,
                    params={"effort_limit_range": (0.8, 1.2), "asset_cfg": SceneEntityCfg("robot")},
                )
            },
        )
    ```

    ## Source
    mjlab 1.6.0, actuator/pd_actuator.py, measured: with `effort_limit=20` and a drawn limit of 30 the control is 30 and
    the force 20 N*m.
    """

    code = "DRN105"
    name = "effort-range-above-one-is-capped"
    severity = Severity.WARNING
    confidence = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find ranges that raise a compiled limit."""
        looked = False
        for index, config, one in ranges(case):
            if one.field != "effort_limit" or config.framework is not Framework.MJLAB:
                continue
            for row in rows_in(case, index, one):
                limit = row.effort_limit
                if limit is None or math.isinf(limit):
                    continue
                looked = True
                high = ends(one)[1] * limit if one.operation == "scale" else ends(one)[1]
                if row.control in ("ideal_pd", "dc_motor", "network") and high > limit:
                    yield Finding(
                        self.code,
                        f"the effort limit is drawn up to {shown(row, 'effort_limit', high)}, and the compiled model "
                        f"caps it at {shown(row, 'effort_limit', limit)}",
                        one.span,
                        row.joint,
                        help="set effort_limit to the highest value, and scale down from there",
                        related=(row.place("effort_limit"),),
                    )
        if not looked:
            yield Skipped(self.code, "no mjlab configuration randomises an effort limit that it states")


class WrongGroupIndex(Rule):
    """Numbers of actuators are taken for numbers of groups.

    ## What it does
    Reports `dr.pd_gains` and `dr.effort_limits` with `actuator_names` that select some of the joints, and with
    `joint_names`, which they do not look at.

    ## Why it matters
    The names resolve to numbers of joints' actuators, and these are used as numbers of cfg groups: the range lands on
    another group, or the run stops with an IndexError. With `joint_names` it lands on all.

    ## Example
    ```python cfg.py
    from mjlab.envs.mdp import dr
    from mjlab.managers.event_manager import EventTermCfg
    from mjlab.managers.scene_entity_config import SceneEntityCfg

    EVENTS = {
        "gains": EventTermCfg(
            func=dr.pd_gains,
            params={
                "kp_range": (0.8, 1.2),
                "kd_range": (0.8, 1.2),
                "asset_cfg": SceneEntityCfg("robot", actuator_names=(".*calf.*",)),
            },
        )
    }
    ```

    ## Use instead
    ```python cfg.py
    from mjlab.envs.mdp import dr
    from mjlab.managers.event_manager import EventTermCfg
    from mjlab.managers.scene_entity_config import SceneEntityCfg

    EVENTS = {
        "gains": EventTermCfg(
            func=dr.pd_gains,
            params={
                "kp_range": (0.8, 1.2),
                "kd_range": (0.8, 1.2),
                "asset_cfg": SceneEntityCfg("robot", actuator_ids=[1]),
            },
        )
    }
    ```

    ## Limits
    With one joint a group, in the model's order, the two numbers are the same; without a model that is not known.

    ## Source
    mjlab 1.6.0, envs/mdp/dr/actuator.py, measured: three joints in two groups, `.*calf.*` is number 2.
    """

    code = "DRN107"
    name = "actuator-names-index-groups"
    severity = Severity.WARNING
    confidence = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find selections that mjlab reads otherwise."""
        looked = False
        for index, config, one in ranges(case):
            if config.framework is not Framework.MJLAB or one.field not in ("kp", "kd", "effort_limit"):
                continue
            looked = True
            function = "dr.effort_limits" if one.field == "effort_limit" else "dr.pd_gains"
            if one.actuators is not None and not _selects_all(case, index, config, one.actuators):
                yield Finding(
                    self.code,
                    f"{function} takes the numbers of the joints that actuator_names selects for numbers of actuator "
                    "cfgs: another group is randomised, or none",
                    one.span,
                    help="leave actuator_names out, or give actuator_ids=[number of the cfg]",
                )
            elif one.joints is not None and one.actuators is None and set(one.joints) != {".*"}:
                yield Finding(
                    self.code,
                    f"{function} does not look at joint_names: all actuators are randomised",
                    one.span,
                    help="give actuator_ids=[number of the cfg]",
                )
        if not looked:
            yield Skipped(self.code, "no mjlab configuration randomises gains or limits")


def _selects_all(case: Case, index: int, config: RobotConfig, patterns: tuple[str, ...]) -> bool:
    """Whether names select every joint, or each joint is a group of its own in the joints' order."""
    if ".*" in patterns:
        return True
    joints = [row.joint for row in case.rows_of(index)]
    known = bool(set(joints) - {name for group in config.groups for name in group.joints or ()})
    if not known:
        return False
    inside = {name for pattern in patterns for name in matching(config.framework, pattern, joints)}
    groups = [row.actuator for row in case.rows_of(index)]
    return inside == set(joints) or groups == [group.name for group in config.groups]


class OneDrawForAll(Rule):
    """A normal distribution of mjlab is drawn once for all joints and environments.

    ## What it does
    Reports ranges of mjlab's `dr` functions with `distribution="gaussian"`.

    ## Why it matters
    mjlab passes mean and deviation as tensors of one element, and its sampler then draws one number: every joint of
    every environment of the call gets the same. A policy sees one robot, not a range of them.

    ## Example
    ```python cfg.py
    from mjlab.envs.mdp import dr
    from mjlab.managers.event_manager import EventTermCfg
    from mjlab.managers.scene_entity_config import SceneEntityCfg

    EVENTS = {
        "armature": EventTermCfg(
            func=dr.joint_armature,
            params={
                "ranges": (1.0, 0.1),
                "operation": "scale",
                "distribution": "gaussian",
                "asset_cfg": SceneEntityCfg("robot"),
            },
        )
    }
    ```

    ## Use instead
    ```python cfg.py
    from mjlab.envs.mdp import dr
    from mjlab.managers.event_manager import EventTermCfg
    from mjlab.managers.scene_entity_config import SceneEntityCfg

    EVENTS = {
        "armature": EventTermCfg(
            func=dr.joint_armature,
            params={
                "ranges": (0.8, 1.25),
                "operation": "scale",
                "distribution": "log_uniform",
                "asset_cfg": SceneEntityCfg("robot"),
            },
        )
    }
    ```

    ## Source
    mjlab 1.6.0, envs/mdp/dr, measured: asked for 4 environments and 3 joints, `gaussian` gives 1 number, `uniform` 12.
    """

    code = "DRN108"
    name = "one-gaussian-draw-for-all"
    severity = Severity.WARNING
    confidence = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find normal distributions."""
        looked = False
        for _, config, one in ranges(case):
            if config.framework is not Framework.MJLAB:
                continue
            looked = True
            if one.distribution == "gaussian":
                yield Finding(
                    self.code,
                    f"{one.field} is drawn from a normal distribution: mjlab draws one number for all joints and "
                    "environments of a call",
                    one.span,
                    help="use uniform or log_uniform",
                )
        if not looked:
            yield Skipped(self.code, "no mjlab configuration randomises actuators")


RULES: tuple[type[Rule], ...] = (
    FrictionRangeSetsViscous,
    EffortRangeCapped,
    WrongGroupIndex,
    OneDrawForAll,
)
