"""DRN: randomisation ranges against the values that they randomise."""

from __future__ import annotations

import math
from collections.abc import Iterator

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.rule import Rule
from actspec.audit.rules.randomized import ends, nominal, range_unit, ranges, rows_in, whose, written
from actspec.diagnostics import Severity
from actspec.readings.artifact import RandomizedRange, RobotConfig
from actspec.units import format_quantity

_AROUND_ZERO = ("encoder_bias", "joint_default_pos")
"""Fields whose nominal value is 0."""

_PASSIVE = ("friction", "joint_damping", "armature")
"""Fields that are often 0 in a model, and supplied by an add range alone."""


class RangeExcludesNominal(Rule):
    """A range does not contain the nominal value.

    ## What it does
    Reports scale ranges without 1, add ranges without 0, and absolute ranges without the value that the same
    configuration gives the joint (for an encoder bias: without 0). Of a normal distribution three deviations count.

    ## Why it matters
    No environment has the robot of the configuration. A policy is trained on other gains or friction throughout than
    those that it is deployed with, and its mean is off by as much as the middle of the range is.

    ## Example
    ```python cfg.py
    import isaaclab.envs.mdp as mdp
    from isaaclab.managers import EventTermCfg, SceneEntityCfg
    from isaaclab.utils import configclass


    @configclass
    class EventCfg:
        gains = EventTermCfg(
            func=mdp.randomize_actuator_gains,
            mode="reset",
            params={
                "asset_cfg": SceneEntityCfg("robot", joint_names=".*"),
                "stiffness_distribution_params": (1.1, 1.5),
                "operation": "scale",
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
        gains = EventTermCfg(
            func=mdp.randomize_actuator_gains,
            mode="reset",
            params={
                "asset_cfg": SceneEntityCfg("robot", joint_names=".*"),
                "stiffness_distribution_params": (0.8, 1.25),
                "operation": "scale",
            },
        )
    ```

    ## Limits
    An absolute range of a field that neither the configuration nor, where it has no actuators, another file of its
    robot states is not judged; nor is friction, damping or armature that is added to a model: many have none.

    ## Source
    Chosen. Ranges of published configurations contain the nominal value: walk-these-ways (motor strength 0.9 to 1.1),
    Isaac Lab's tasks, MuJoCo Playground's Go1.
    """

    code = "DRN101"
    name = "range-excludes-nominal"
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Hold each range against what it surrounds."""
        looked = False
        for index, config, one in ranges(case):
            looked = True
            low, high = ends(one)
            if one.operation in ("scale", "add"):
                neutral = 1.0 if one.operation == "scale" else 0.0
                supplied = one.operation == "add" and one.field in _PASSIVE and low > 0.0
                if not low <= neutral <= high and not supplied:
                    yield Finding(
                        self.code,
                        f"{one.field} is randomised by {one.operation} {written(low, high)}, which leaves out "
                        f"{neutral:g}: no environment has the nominal value",
                        one.span,
                    )
            elif one.operation == "abs" and one.field in _AROUND_ZERO and not low <= 0.0 <= high:
                yield Finding(
                    self.code,
                    f"{one.field} is randomised from {written(low, high)}, which leaves out 0: no environment has the "
                    "nominal value",
                    one.span,
                )
            elif one.operation == "abs":
                yield from self._absolute(case, index, config, one)
        if not looked:
            yield Skipped(self.code, "no configuration randomises actuators")

    def _absolute(
        self, case: Case, index: int, config: RobotConfig, one: RandomizedRange
    ) -> Iterator[Finding]:
        low, high = ends(one)
        for row in rows_in(case, index, one):
            value = nominal(case, config, row, one)
            if value is None or not math.isfinite(value) or low <= value <= high:
                continue
            unit = range_unit(config, row, one)
            yield Finding(
                self.code,
                f"{one.field} is randomised from {written(low, high, unit)}, which leaves out "
                f"{whose(row, index)} {format_quantity(value, unit, 3)}: no environment has the nominal value",
                one.span,
                row.joint,
                value,
                unit,
                related=(row.span,),
            )


class ScalesZero(Rule):
    """A range scales a value that is 0: nothing is randomised.

    ## What it does
    Reports scale ranges over joints whose value in the configuration (in mjlab: in the MJCF) is 0.

    ## Why it matters
    Any multiple of 0 is 0. The log shows a randomisation, and every environment has the same joint.

    ## Example
    ```python cfg.py
    from mjlab.actuator import BuiltinPositionActuatorCfg
    from mjlab.entity import EntityArticulationInfoCfg, EntityCfg
    from mjlab.envs import ManagerBasedRlEnvCfg
    from mjlab.envs.mdp import dr
    from mjlab.managers.event_manager import EventTermCfg
    from mjlab.managers.scene_entity_config import SceneEntityCfg
    from mjlab.scene import SceneCfg

    LEGS = BuiltinPositionActuatorCfg(
        target_names_expr=(".*",), stiffness=20.0, damping=1.0, effort_limit=23.7, frictionloss=0.0
    )
    ROBOT = EntityCfg(articulation=EntityArticulationInfoCfg(actuators=(LEGS,)))


    def make_env_cfg() -> ManagerBasedRlEnvCfg:
        return ManagerBasedRlEnvCfg(
            scene=SceneCfg(entities={"robot": ROBOT}),
            events={
                "friction": EventTermCfg(
                    func=dr.joint_friction,
                    params={"ranges": (0.8, 1.2), "operation": "scale", "asset_cfg": SceneEntityCfg("robot")},
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

    LEGS = BuiltinPositionActuatorCfg(
        target_names_expr=(".*",), stiffness=20.0, damping=1.0, effort_limit=23.7, frictionloss=0.0
    )
    ROBOT = EntityCfg(articulation=EntityArticulationInfoCfg(actuators=(LEGS,)))


    def make_env_cfg() -> ManagerBasedRlEnvCfg:
        return ManagerBasedRlEnvCfg(
            scene=SceneCfg(entities={"robot": ROBOT}),
            events={
                "friction": EventTermCfg(
                    func=dr.joint_friction,
                    params={"ranges": (0.0, 0.3), "operation": "add", "asset_cfg": SceneEntityCfg("robot")},
                )
            },
        )
    ```

    ## Limits
    What a USD has where the configuration is silent is not known.

    ## Source
    Isaac Lab 2.3.2, envs/mdp/events.py, and mjlab 1.6.0, envs/mdp/dr: scale multiplies the default.
    """

    code = "DRN102"
    name = "range-scales-a-zero"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    paired = True

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find scaled zeros."""
        looked = False
        for index, config, one in ranges(case):
            for row in rows_in(case, index, one):
                value = nominal(case, config, row, one)
                looked = looked or value is not None
                if value == 0.0 and one.operation == "scale":
                    yield Finding(
                        self.code,
                        f"{one.field} is scaled by {written(*ends(one))} and is 0: nothing is randomised",
                        one.span,
                        row.joint,
                        help="give it a value, or randomise by add",
                        related=(row.span,),
                    )
        if not looked:
            yield Skipped(self.code, "no configuration randomises a value that it states")


RULES: tuple[type[Rule], ...] = (RangeExcludesNominal, ScalesZero)
