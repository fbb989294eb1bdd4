"""SRC: limits on which files of one robot do not agree."""

from __future__ import annotations

from actspec.audit.case import Case
from actspec.audit.finding import Finding
from actspec.audit.rule import Rule
from actspec.audit.rules.gears import HiddenGear
from actspec.audit.rules.source_pairs import Disagreement, hidden_gear, stated_figure, unit_slip
from actspec.audit.rules.source_rule import SourceRule

PLACEHOLDER = 1e5
"""From here on a limit is none. Source: rule LIM102."""

_TIMES = 3.0
"""From here a ratio is told as a factor. Chosen: 200 % more is read as a factor of 2 as often as of 3."""


class EffortLimit(SourceRule):
    """Files of one robot give a joint different effort limits.

    ## What it does
    Compares the effort limits that the files of one robot state: a training configuration with the URDF and MJCF, an
    MJCF with the URDF, a deploy file with the training configuration. A file that agrees with one of them is right.

    ## Why it matters
    The policy learns with the torque of one file and runs with that of another. Where it trained with more than the
    motor has, it falls; where with less, the machine is weaker than it could be. Action scales of 0.25 times effort
    over stiffness move with the limit.

    ## Example
    ```xml leg.urdf
    <robot name="leg">
      <link name="base"/>
      <link name="shank"/>
      <joint name="knee" type="revolute">
        <parent link="base"/>
        <child link="shank"/>
        <axis xyz="0 1 0"/>
        <limit lower="-2" upper="0" effort="139" velocity="20"/>
      </joint>
    </robot>
    ```
    ```python leg_cfg.py
    from isaaclab.actuators import ImplicitActuatorCfg
    from isaaclab.assets import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": ImplicitActuatorCfg(
                joint_names_expr=["knee"], effort_limit_sim=300.0, velocity_limit_sim=20.0, stiffness=150.0, damping=4.0
            )
        }
    )
    ```

    ## Use instead
    ```python leg_cfg.py
    from isaaclab.actuators import ImplicitActuatorCfg
    from isaaclab.assets import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": ImplicitActuatorCfg(
                joint_names_expr=["knee"], effort_limit_sim=139.0, velocity_limit_sim=20.0, stiffness=150.0, damping=4.0
            )
        }
    )
    ```

    ## Limits
    Which file is right nobody here knows. Limits of 0 and placeholders are for the LIM rules, effort and speed that
    differ by one gear, and efforts that lack a reduction, for GEA101, degrees and rpm for UNT. Variants of a robot
    (other joints, or two files of one kind) get a remark. Figures that no file states, an engine's defaults, are not
    compared.

    ## Source
    Reports of such files: unitreerobotics/unitree_rl_lab#9 (300 and 139 N*m), amazon-far/holosoma#47 (50 and 35),
    NVlabs/GR00T-WholeBodyControl#266. Chosen: equal within 1 %, the rounding of published limits.
    """

    code = "SRC101"
    name = "effort-limit-disagrees"
    groups = (("effort_limit",),)
    lacks = "an effort limit of one joint"

    def is_explained(self, case: Case, found: Disagreement, tolerance: float) -> bool:
        """A placeholder, or the other half of a gear."""
        if _is_no_limit(found):
            return True
        return hidden_gear(found.ratio, _ratio(found, "velocity_limit", "no_load_speed"))

    def without_told(self, case: Case, findings: list[Finding]) -> list[Finding]:
        """A forgotten reduction says more than that the figures differ."""
        gears = {(item.span, item.joint) for item in HiddenGear().check(case) if isinstance(item, Finding)}
        return [item for item in findings if (item.span, item.joint) not in gears]

    def consequence(self, case: Case, found: Disagreement) -> str:
        """How much torque."""
        assert found.ratio is not None
        if found.ratio >= _TIMES:
            return f"the joint has {found.ratio:.3g} times the torque here"
        share = abs(found.ratio - 1.0) * 100.0
        return f"the joint has {share:.3g} % {'more' if found.ratio > 1.0 else 'less'} torque here"


class VelocityLimit(SourceRule):
    """Files of one robot give a joint different speed limits.

    ## What it does
    Compares the velocity limits that the files of one robot state; where a configuration has a torque-speed line in
    place of a limit, its no-load speed. Which file is held to which is as in SRC101.

    ## Why it matters
    A simulator brakes a joint above its limit, or gives it no torque. A policy that trained with a faster joint asks
    the machine for steps that it cannot take.

    ## Example
    ```xml leg.urdf
    <robot name="leg">
      <link name="base"/>
      <link name="shank"/>
      <joint name="knee" type="revolute">
        <parent link="base"/>
        <child link="shank"/>
        <axis xyz="0 1 0"/>
        <limit lower="-2" upper="0" effort="139" velocity="20"/>
      </joint>
    </robot>
    ```
    ```python leg_cfg.py
    from isaaclab.actuators import ImplicitActuatorCfg
    from isaaclab.assets import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": ImplicitActuatorCfg(
                joint_names_expr=["knee"], effort_limit_sim=139.0, velocity_limit_sim=99.0, stiffness=150.0, damping=4.0
            )
        }
    )
    ```

    ## Use instead
    ```python leg_cfg.py
    from isaaclab.actuators import ImplicitActuatorCfg
    from isaaclab.assets import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": ImplicitActuatorCfg(
                joint_names_expr=["knee"], effort_limit_sim=139.0, velocity_limit_sim=20.0, stiffness=150.0, damping=4.0
            )
        }
    )
    ```

    ## Limits
    As SRC101. `velocity_limit` of an implicit Isaac Lab actuator is ignored there, and here.

    ## Source
    Reports of such files: unitreerobotics/unitree_rl_lab#9 (100 and 20 rad/s), amazon-far/holosoma#47 (37 and 30).
    Chosen: equal within 1 %.
    """

    code = "SRC102"
    name = "velocity-limit-disagrees"
    groups = (("velocity_limit", "no_load_speed"),)
    lacks = "a speed limit of one joint"

    def is_explained(self, case: Case, found: Disagreement, tolerance: float) -> bool:
        """A placeholder, a gear, or degrees."""
        if _is_no_limit(found) or unit_slip(found.ratio, tolerance):
            return True
        return hidden_gear(_ratio(found, "effort_limit"), found.ratio)

    def consequence(self, case: Case, found: Disagreement) -> str:
        """How much speed."""
        assert found.ratio is not None
        if found.ratio >= _TIMES:
            return f"the joint is {found.ratio:.3g} times as fast here"
        share = abs(found.ratio - 1.0) * 100.0
        return f"the joint is {share:.3g} % {'faster' if found.ratio > 1.0 else 'slower'} here"


def _is_no_limit(found: Disagreement) -> bool:
    """Whether one of two limits is a placeholder or 0, which the LIM rules report."""
    values = [found.mine.value or 0.0, found.theirs.value or 0.0]
    return min(values) <= 0.0 or max(values) >= PLACEHOLDER


def _ratio(found: Disagreement, *fields: str) -> float | None:
    """The ratio of another figure of the same two files; None where one does not state it."""
    mine, theirs = stated_figure(found.rows, fields), stated_figure(found.others, fields)
    if mine is None or theirs is None or not mine.value or not theirs.value:
        return None
    return mine.value / theirs.value


RULES: tuple[type[Rule], ...] = (EffortLimit, VelocityLimit)
