"""CFG: fields that an actuator class does not have, must have, or does not take in this form."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.rule import Rule
from actspec.audit.rules.config_classes import CLASSES, stock_groups
from actspec.diagnostics import Severity, listed, nearest, shortened
from actspec.readings.artifact import ActuatorGroup, Framework, RobotConfig
from actspec.readings.versions import release

_SKIPPED = "no configuration with stock classes of Isaac Lab or mjlab among the files"


class UnknownField(Rule):
    """An actuator class is given a field that it does not have.

    ## What it does
    Reports fields of stock classes of Isaac Lab and mjlab that no version of the class has, and classes that one of the
    two has under another spelling. For named versions, fields that came later.

    ## Why it matters
    Most often the class refuses the field when it is made, minutes after the start of a run. Where fields are
    assigned later (`cfg.actuators["legs"].stifness = 40`), nothing refuses it and the old value stays.

    ## Example
    ```python robot_cfg.py
    from isaaclab.actuators import DCMotorCfg
    from isaaclab.assets.articulation import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": DCMotorCfg(
                joint_names_expr=[".*"],
                effort_limit=23.7,
                saturation_torque=23.7,
                saturation_effort=23.7,
                velocity_limit=30.1,
                stiffness=25.0,
                damping=0.5,
            )
        }
    )
    ```

    ## Use instead
    ```python robot_cfg.py
    from isaaclab.actuators import DCMotorCfg
    from isaaclab.assets.articulation import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": DCMotorCfg(
                joint_names_expr=[".*"],
                effort_limit=23.7,
                saturation_effort=23.7,
                velocity_limit=30.1,
                stiffness=25.0,
                damping=0.5,
            )
        }
    )
    ```

    ## Limits
    Classes of one's own are not judged. Limits in the names of another version of Isaac Lab are VER103's.

    ## Source
    Isaac Lab 2.2.0 and 2.3.2, isaaclab/actuators; mjlab 1.0.0 to 1.6.0, mjlab/actuator. Case: RoboVerse#808.
    """

    code = "CFG103"
    name = "unknown-field-or-class"
    severity = Severity.ERROR
    confidence = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Hold fields against the classes."""
        looked = False
        for _, config, group, stock in stock_groups(case):
            looked = True
            for name, setting in group.settings.items():
                if name not in stock.fields:
                    yield Finding(
                        self.code,
                        f"{group.cls} has no field {shortened(name)!r}",
                        setting.span,
                        help=_nearest(name, stock.fields),
                    )
                elif _later(case, config, group, name):
                    yield Finding(
                        self.code,
                        f"mjlab {case.versions.mjlab} has no {name} in {group.cls}: it came with 1.3",
                        setting.span,
                    )
        for found in self._misspelt(case):
            looked = True
            yield found
        if not looked:
            yield Skipped(self.code, _SKIPPED)

    def _misspelt(self, case: Case) -> Iterator[Finding]:
        """Names of one framework's class in the other's spelling."""
        for artifact in case.artifacts:
            config = artifact.config
            if config is None or config.framework not in CLASSES:
                continue
            known = CLASSES[config.framework]
            spelt = {name.lower(): name for name in known}
            for group in config.groups:
                right = spelt.get(group.cls.lower())
                if right is not None and right != group.cls and not group.bases:
                    yield Finding(
                        self.code,
                        f"{_NAMES[config.framework]} has no class {group.cls}",
                        group.span,
                        help=f"did you mean {right}?",
                    )


_NAMES = {Framework.ISAACLAB: "Isaac Lab", Framework.MJLAB: "mjlab"}

_SINCE_1_3 = frozenset(
    {
        "viscous_damping",
        "delay_min_lag",
        "delay_max_lag",
        "delay_hold_prob",
        "delay_update_period",
        "delay_per_env_phase",
    }
)
"""Fields that every actuator of mjlab has from 1.3 on. Source: mjlab 1.2.0 and 1.3.0, actuator/actuator.py."""


def _later(case: Case, config: RobotConfig, group: ActuatorGroup, name: str) -> bool:
    named = case.versions.mjlab
    if config.framework is not Framework.MJLAB or named is None or "base_cfg" in group.settings:
        return False
    return name in _SINCE_1_3 and release(named)[:2] < (1, 3)


def _nearest(name: str, fields: frozenset[str]) -> str:
    near = nearest(name, sorted(fields))
    return f"did you mean {near!r}?" if near else f"it has {listed(sorted(fields), 30)}"


class RequiredFieldMissing(Rule):
    """An actuator class lacks a field that has no default.

    ## What it does
    Reports groups of stock classes of Isaac Lab and mjlab, in a robot, without a field that they must have: stiffness
    and damping of a PD, the scales of a network. In Isaac Lab `None` is a value: it takes the USD's.

    ## Why it matters
    The class raises an error when it is made (mjlab), or when the robot is (Isaac Lab), after the simulator has
    started.

    ## Example
    ```python robot_cfg.py
    from isaaclab.actuators import ImplicitActuatorCfg
    from isaaclab.assets.articulation import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": ImplicitActuatorCfg(joint_names_expr=[".*"], effort_limit_sim=23.7, stiffness=25.0)
        }
    )
    ```

    ## Use instead
    ```python robot_cfg.py
    from isaaclab.actuators import ImplicitActuatorCfg
    from isaaclab.assets.articulation import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": ImplicitActuatorCfg(
                joint_names_expr=[".*"], effort_limit_sim=23.7, stiffness=25.0, damping=0.5
            )
        }
    )
    ```

    ## Limits
    An actuator cfg alone may be filled in by another file, and is not judged. Half a torque-speed line is LIM110's.

    ## Source
    Isaac Lab 2.3.2, measured: TypeError for a field that is `MISSING`. mjlab 1.6.0: fields without a default.
    """

    code = "CFG104"
    name = "required-field-missing"
    severity = Severity.ERROR
    confidence = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find what is missing."""
        looked = False
        for _, config, group, stock in stock_groups(case):
            looked = True
            told = any(note.where in (group.name, f"actuators.{group.name}") for note in config.notes)
            alone = len(config.groups) == 1 and group.name == config.name
            missing = sorted(stock.required - set(group.settings))
            if missing and not told and not alone:
                yield Finding(
                    self.code,
                    f"this {group.cls} has no {' and no '.join(missing)}: it cannot be made",
                    group.span,
                    help="None takes the USD's value" if _takes_none(config, missing) else None,
                )
        if not looked:
            yield Skipped(self.code, _SKIPPED)


def _takes_none(config: RobotConfig, missing: list[str]) -> bool:
    return config.framework is Framework.ISAACLAB and set(missing) <= {"stiffness", "damping"}


class ScalarGivenDict(Rule):
    """A field that takes one number is given one for each joint.

    ## What it does
    Reports dicts in fields that take a number for the whole group: `saturation_effort` of Isaac Lab 2.x, delays,
    scales of networks; in mjlab every field.

    ## Why it matters
    Isaac Lab 2.x raises a TypeError when the robot is made; mjlab when the model is compiled. Joints with different
    motors need groups of their own.

    ## Example
    ```python robot_cfg.py
    from isaaclab.actuators import DCMotorCfg
    from isaaclab.assets.articulation import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": DCMotorCfg(
                joint_names_expr=[".*_hip", ".*_knee"],
                effort_limit={".*_hip": 23.7, ".*_knee": 35.5},
                saturation_effort={".*_hip": 23.7, ".*_knee": 35.5},
                velocity_limit={".*_hip": 30.1, ".*_knee": 20.1},
                stiffness=25.0,
                damping=0.5,
            )
        }
    )
    ```

    ## Use instead
    ```python robot_cfg.py
    from isaaclab.actuators import DCMotorCfg
    from isaaclab.assets.articulation import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={
            "hips": DCMotorCfg(
                joint_names_expr=[".*_hip"],
                effort_limit=23.7,
                saturation_effort=23.7,
                velocity_limit=30.1,
                stiffness=25.0,
                damping=0.5,
            ),
            "knees": DCMotorCfg(
                joint_names_expr=[".*_knee"],
                effort_limit=35.5,
                saturation_effort=35.5,
                velocity_limit=20.1,
                stiffness=25.0,
                damping=0.5,
            ),
        }
    )
    ```

    ## Limits
    Isaac Lab 3.0 takes a dict for `saturation_effort`; without a named version that one field is a warning.

    ## Source
    Isaac Lab 2.3.2 and mjlab 1.6.0 classes, measured.
    """

    code = "CFG105"
    name = "scalar-field-given-a-dict"
    severity = Severity.ERROR
    confidence = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find dicts."""
        looked = False
        named = case.versions.isaaclab
        for _, config, group, stock in stock_groups(case):
            looked = True
            for name, setting in group.settings.items():
                if not isinstance(setting.value, Mapping) or name not in stock.fields - stock.mappable:
                    continue
                if name == "motor_params":
                    continue
                isaac = config.framework is Framework.ISAACLAB
                later = isaac and name == "saturation_effort"
                if later and named is not None and release(named) >= (3,):
                    continue
                where = "Isaac Lab 2.x" if later else _NAMES[config.framework]
                yield Finding(
                    self.code,
                    f"{name} of {group.cls} is one number for the whole group in {where}, and is given "
                    f"{len(setting.value)} by joint: it cannot be made",
                    setting.span,
                    help="make a group for each value",
                    severity=Severity.WARNING if later and named is None else None,
                )
        if not looked:
            yield Skipped(self.code, _SKIPPED)


RULES: tuple[type[Rule], ...] = (UnknownField, RequiredFieldMissing, ScalarGivenDict)
