"""FRC: what Isaac Lab's friction fields mean, by version."""

from __future__ import annotations

import math
from collections.abc import Iterator
from os.path import basename
from typing import ClassVar

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.ledger import LedgerRow
from actspec.audit.rule import Rule
from actspec.audit.rules.cfg_groups import Group, groups_of
from actspec.audit.rules.joint_units import shown, unit
from actspec.audit.rules.partners import partner_rows
from actspec.diagnostics import Severity, Span
from actspec.readings.artifact import FileKind, Framework
from actspec.readings.versions import Versions, friction_unit_of, has_dynamic, isaaclab_row
from actspec.simulators.isaaclab import FrictionUnit as SolverUnit

SAME = 0.01
"""Relative difference up to which two frictions are one figure. Chosen: rounding of published figures."""


def _place(versions: Versions) -> str:
    """`Isaac Lab 2.3 on Isaac Sim 5.1`."""
    lab = f"Isaac Lab {versions.isaaclab}" if versions.isaaclab else ""
    under = f"Isaac Sim {versions.isaac_sim}" if versions.isaac_sim else ""
    if versions.backend and not under:
        under = {"physx": "PhysX", "ovphysx": "OVPhysX", "newton": "Newton"}.get(versions.backend, "")
    return " on ".join(filter(None, (lab, under)))


class FrictionUnit(Rule):
    """What Isaac Lab's friction means depends on versions, and the figure fits another one.

    ## What it does
    Looks at `friction` above 0 in Isaac Lab configurations. On Isaac Sim 4.5 and OVPhysX it is a dimensionless
    coefficient: reported where an MJCF, URDF or spec of the robot has the same figure in N*m. From Isaac Lab 2.3 on
    Isaac Sim 5 it is a torque in N*m: remarked where those files have `ratio` times as much (default 10), as is usual
    for a coefficient that was taken over. In Isaac Lab 2.2.0 on Isaac Sim 5 it does nothing. The versions
    are the named ones, else those in the head of a file that actspec wrote; without any it is a remark that the meaning
    is open.

    ## Why it matters
    A coefficient multiplies the load of the joint's bearing. 0.2 N*m read as a coefficient is 20 N*m at a knee that
    carries 100 N, and nearly nothing in an arm that hangs; 0.01 read as N*m is no friction at all.

    ## Example
    ```sh
    actspec audit leg.xml leg_cfg.py --target isaaclab==2.3 --target isaac_sim==4.5
    ```
    ```xml leg.xml
    <mujoco model="leg">
      <worldbody>
        <body>
          <joint name="knee_joint" frictionloss="0.2"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
    </mujoco>
    ```
    ```python leg_cfg.py
    from isaaclab.actuators import ImplicitActuatorCfg
    from isaaclab.assets.articulation import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": ImplicitActuatorCfg(
                joint_names_expr=[".*_joint"], effort_limit_sim=30.0, stiffness=25.0, damping=0.5, friction=0.2
            )
        }
    )
    ```

    ## Use instead
    ```sh
    actspec audit leg.xml leg_cfg.py --target isaaclab==2.3 --target isaac_sim==5.1
    ```
    ```python leg_cfg.py
    from isaaclab.actuators import ImplicitActuatorCfg
    from isaaclab.assets.articulation import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": ImplicitActuatorCfg(
                joint_names_expr=[".*_joint"],
                effort_limit_sim=30.0,
                stiffness=25.0,
                damping=0.5,
                friction=0.2,
                dynamic_friction=0.2,
            )
        }
    )
    ```

    ## Limits
    A coefficient that suits the robot's load cannot be told from a bad one: that takes a measurement.

    ## Source
    Isaac Lab 2.2.0 and 2.3.2, articulation.py and actuator_base_cfg.py; 3.0, docs/source/concepts/actuators.rst;
    isaac-sim/IsaacLab#3461, #3222 (2.2.0 never writes it).
    """

    code = "FRC102"
    name = "friction-unit-by-backend"
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    paired = True
    options: ClassVar[dict[str, float]] = {"ratio": 10.0}

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Hold friction against what the named versions make of it."""
        looked = False
        for group in groups_of(case, Framework.ISAACLAB):
            setting = group.written("friction")
            for row in group.rows:
                friction = group.number(setting, row.joint)
                if setting is not None and friction is not None and friction > 0.0:
                    looked = True
                    yield from self._judge(case, row, friction, setting.span)
        if not looked:
            yield Skipped(self.code, "no Isaac Lab configuration with friction among the files")

    def _judge(self, case: Case, row: LedgerRow, friction: float, span: Span) -> Iterator[Finding]:
        versions = case.versions_of(row.artifact)
        found, place = friction_unit_of(versions), _place(versions)
        if found is None:
            lab = isaaclab_row(versions)
            by_backend = lab is not None and lab.native
            named = "backend" if by_backend else "version"
            yield Finding(
                self.code,
                "this friction is a dimensionless coefficient on Isaac Sim 4.5 and OVPhysX, and a torque in "
                f"{unit(row, 'frictionloss')} from Isaac Lab 2.3 on Isaac Sim 5: no {named} is named that tells which",
                span,
                row.joint,
                help="name it: --target backend==physx (or ovphysx, newton)"
                if by_backend
                else "name them: --target isaaclab==2.3 --target isaac_sim==5.1",
                severity=Severity.INFO,
                confidence=Confidence.HIGH,
            )
            return
        if found is SolverUnit.DEAD:
            yield Finding(
                self.code,
                f"this friction does nothing: {place} never writes it to the solver",
                span,
                row.joint,
                help="go to Isaac Lab 2.3, and give dynamic_friction too",
                confidence=Confidence.HIGH,
            )
            return
        for other in partner_rows(case, row, FileKind.MJCF, FileKind.URDF, FileKind.SPEC):
            torque = other.frictionloss
            if torque is None or torque <= 0.0:
                continue
            told, file = shown(row, "frictionloss", torque), basename(other.file)
            if found.coefficient and math.isclose(friction, torque, rel_tol=SAME):
                yield Finding(
                    self.code,
                    f"on {place} friction is a dimensionless coefficient, and {file} has the same figure as a torque, "
                    f"{told}: the joint gets {friction:.3g} times its load instead",
                    span,
                    row.joint,
                    friction,
                    "1",
                    help="find the coefficient that gives this torque under the joint's load, or go to Isaac Lab 2.3 "
                    "on Isaac Sim 5",
                    related=(other.place("frictionloss"),),
                )
                return
            if found.torque and torque >= self.option(case, "ratio") * friction:
                yield Finding(
                    self.code,
                    f"on {place} friction is a torque, here {shown(row, 'frictionloss', friction)}, and {file} has "
                    f"{told}: is this a coefficient from Isaac Sim 4.5?",
                    span,
                    row.joint,
                    friction,
                    unit(row, "frictionloss"),
                    torque,
                    f"friction={torque:.3g}, dynamic_friction={torque:.3g}",
                    (other.place("frictionloss"),),
                    severity=Severity.INFO,
                )
                return


class DynamicAboveStatic(Rule):
    """Kinetic friction is above static friction.

    ## What it does
    Reports Isaac Lab groups whose `dynamic_friction` is above their `friction`. Silent where the named version or
    backend has no dynamic part.

    ## Why it matters
    PhysX asks for dynamic friction at or below static friction. A joint would be harder to keep moving than to start.

    ## Example
    ```python robot_cfg.py
    from isaaclab.actuators import ImplicitActuatorCfg
    from isaaclab.assets.articulation import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": ImplicitActuatorCfg(
                joint_names_expr=[".*"], stiffness=25.0, damping=0.5, friction=0.1, dynamic_friction=0.2
            )
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
                joint_names_expr=[".*"], stiffness=25.0, damping=0.5, friction=0.2, dynamic_friction=0.1
            )
        }
    )
    ```

    ## Limits
    Where one of the two is left to the USD, nothing is compared.

    ## Source
    PhysX 5.6, PxJointFrictionParams: dynamic friction effort at most the static one; isaac-sim/IsaacLab#3318.
    """

    code = "FRC103"
    name = "dynamic-above-static-friction"
    severity = Severity.ERROR
    confidence = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Compare the two."""
        looked = False
        for group in groups_of(case, Framework.ISAACLAB):
            versions = case.versions_of(group.artifact)
            silent = friction_unit_of(versions) is not None and not has_dynamic(versions)
            static, dynamic = group.written("friction"), group.written("dynamic_friction")
            if static is None or dynamic is None or silent:
                continue
            for row in group.rows:
                still, moving = group.number(static, row.joint), group.number(dynamic, row.joint)
                if still is None or moving is None:
                    continue
                looked = True
                if moving > still:
                    yield Finding(
                        self.code,
                        f"dynamic_friction {moving:.3g} is above friction {still:.3g}, the static part: PhysX asks "
                        "for the opposite",
                        dynamic.span,
                        row.joint,
                        moving,
                        _unit(row, versions),
                        still,
                        help=f"friction={moving:.3g} and dynamic_friction={still:.3g}, or both alike for plain "
                        "Coulomb friction",
                        related=(static.span,),
                    )
        if not looked:
            yield Skipped(self.code, "no Isaac Lab configuration with friction and dynamic_friction in force")


class StaticFrictionAlone(Rule):
    """Only static friction is set: it is gone as soon as the joint moves.

    ## What it does
    Reports, for versions on which friction has a static and a dynamic part (Isaac Sim 5 and later), groups that set
    `friction` above 0 and no `dynamic_friction`.

    ## Why it matters
    The joint sticks until the drive exceeds the static friction, then runs without any: dry friction as MuJoCo's
    `frictionloss`, or as Isaac Sim 4.5 has it, is both values alike.

    ## Example
    ```sh
    actspec audit robot_cfg.py --target isaaclab==2.3 --target isaac_sim==5.1
    ```
    ```python robot_cfg.py
    from isaaclab.actuators import ImplicitActuatorCfg
    from isaaclab.assets.articulation import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": ImplicitActuatorCfg(joint_names_expr=[".*"], stiffness=25.0, damping=0.5, friction=0.2)
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
                joint_names_expr=[".*"], stiffness=25.0, damping=0.5, friction=0.2, dynamic_friction=0.2
            )
        }
    )
    ```

    ## Limits
    A USD may have a dynamic part of its own; importers write none.

    ## Source
    Isaac Lab 2.3.2, articulation.py: `dynamic_friction=None` keeps the USD's; leggedrobotics/pace-sim2real#14.
    """

    code = "FRC104"
    name = "static-friction-alone"
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find groups with a static part alone."""
        looked = False
        for group in groups_of(case, Framework.ISAACLAB):
            static = group.written("friction")
            if static is None or not has_dynamic(case.versions_of(group.artifact)):
                continue
            looked = True
            if group.complete and group.written("dynamic_friction") is None:
                yield from self._alone(case, group)
        if not looked:
            yield Skipped(
                self.code, "no Isaac Lab configuration with friction for a named Isaac Sim 5 or later"
            )

    def _alone(self, case: Case, group: Group) -> Iterator[Finding]:
        static = group.written("friction")
        for row in group.rows:
            value = group.number(static, row.joint)
            if static is None or value is None or value <= 0.0:
                continue
            dimension = _unit(row, case.versions_of(row.artifact))
            yield Finding(
                self.code,
                f"the friction of {value:.3g}{'' if dimension == '1' else ' ' + dimension} is static alone: without "
                "dynamic_friction it is gone as soon as the joint moves",
                static.span,
                row.joint,
                value,
                dimension,
                help=f"add dynamic_friction={value:.3g}",
            )


def _unit(row: LedgerRow, versions: Versions) -> str:
    found = friction_unit_of(versions)
    return "1" if found is not None and found.coefficient else unit(row, "frictionloss")


RULES: tuple[type[Rule], ...] = (FrictionUnit, DynamicAboveStatic, StaticFrictionAlone)
