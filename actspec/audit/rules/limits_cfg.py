"""LIM: limits of drives in Isaac Lab and mjlab configurations."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.rule import Rule
from actspec.audit.rules.cfg_groups import EXPLICIT, IMPLICIT, MJLAB_WITH_LINE, WITH_LINE, Group, groups_of
from actspec.audit.rules.joint_units import shown, unit
from actspec.audit.rules.partners import partner_rows
from actspec.diagnostics import Severity
from actspec.readings.artifact import FileKind, Framework, Setting

_MJLAB_EXPLICIT = MJLAB_WITH_LINE | {"IdealPdActuatorCfg"}


class ExplicitWithoutLimit(Rule):
    """An explicit drive has no effort limit of its own.

    ## What it does
    Reports groups of Isaac Lab's and mjlab's explicit classes (ideal PD, DC motor, delayed PD, networks) that set no
    `effort_limit` (3.0: `actuator_effort_limit`). Silent where the version is named and takes the USD's limit, and
    in mjlab where the joint of the MJCF has an `actuatorfrcrange`.

    ## Why it matters
    Isaac Lab 2.2 and 2.3.0 then clip at 1e9 N*m, which is nowhere; from 2.3.1 on the USD's limit counts. The same
    file trains another robot after an update. mjlab takes no limit.

    ## Example
    ```python robot_cfg.py
    from isaaclab.actuators import IdealPDActuatorCfg
    from isaaclab.assets.articulation import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={"legs": IdealPDActuatorCfg(joint_names_expr=[".*"], stiffness=25.0, damping=0.5)}
    )
    ```

    ## Use instead
    ```python robot_cfg.py
    from isaaclab.actuators import IdealPDActuatorCfg
    from isaaclab.assets.articulation import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": IdealPDActuatorCfg(joint_names_expr=[".*"], effort_limit=23.7, stiffness=25.0, damping=0.5)
        }
    )
    ```

    ## Limits
    Subclasses are not judged: their defaults are not in the file. Neither is `RemotizedPDActuatorCfg`, whose limit is
    a table.

    ## Source
    Isaac Lab 2.2.0, 2.3.0 and 2.3.2 classes, measured; isaac-sim/IsaacLab#2054. mjlab 1.6.0: `effort_limit=inf`.
    """

    code = "LIM105"
    name = "explicit-drive-without-effort-limit"
    severity = Severity.WARNING
    confidence = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find explicit groups without a limit."""
        looked = False
        for group in (
            *groups_of(case, Framework.ISAACLAB, EXPLICIT),
            *groups_of(case, Framework.MJLAB, _MJLAB_EXPLICIT),
        ):
            looked = True
            if not group.complete or group.written("effort_limit", "actuator_effort_limit") is not None:
                continue
            isaac = group.framework is Framework.ISAACLAB
            told = _isaac_default(case.versions.isaaclab, group) if isaac else "mjlab then takes none"
            if told is None:
                continue
            limited = set() if isaac else _limited_in_mjcf(case, group)
            for joint in group.joints:
                if joint not in limited:
                    name = "actuator_effort_limit" if _major(case.versions.isaaclab) >= 3 else "effort_limit"
                    yield Finding(
                        self.code,
                        f"this {group.cfg.cls} sets no effort limit: {told}",
                        group.cfg.span,
                        joint,
                        help=f"set {name if isaac else 'effort_limit'} to what the motor and its drive can give",
                    )
        if not looked:
            yield Skipped(self.code, "no Isaac Lab or mjlab cfg with an explicit drive among the files")


def _isaac_default(version: str | None, group: Group) -> str | None:
    """What counts in place of the missing limit; None where that is the USD's, or the solver's clamp."""
    numbers = [int(part) for part in version.split(".")] if version is not None else []
    if numbers >= [2, 3, 1]:
        return None
    solver = group.written("effort_limit_sim")
    if numbers and (numbers < [2, 3] or numbers == [2, 3, 0]):
        return (
            None
            if solver is not None
            else f"Isaac Lab {version} then clips at 1e+09 N*m, which no joint reaches"
        )
    first = "at its effort_limit_sim" if solver is not None else "at 1e+09 N*m, which no joint reaches"
    return f"Isaac Lab 2.2 and 2.3.0 then clip {first}; later versions at the limit that the USD has"


def _major(version: str | None) -> int:
    return 2 if version is None else int(version.split(".")[0])


def _limited_in_mjcf(case: Case, group: Group) -> set[str]:
    """Joints of the group that an MJCF of the robot limits."""
    return {
        row.joint
        for row in group.rows
        for other in partner_rows(case, row, FileKind.MJCF)
        if other.effort_limit is not None and other.effort_limit < math.inf
    }


class TwoLimits(Rule):
    """A drive's own limit and the solver's disagree.

    ## What it does
    Reports Isaac Lab groups in which the limit of the actuator model and that of the solver (`effort_limit` and
    `effort_limit_sim`; 3.0: `actuator_effort_limit` and `joint_effort_limit`) cannot both count: an implicit group
    that sets both, differently, or an explicit group whose solver limit is the lower one.

    ## Why it matters
    Isaac Lab 2.x refuses to build such an implicit group. An explicit drive is clipped twice: the model believes it
    gives its limit (`applied_torque`, and rewards on it), and the solver lets only the lower one through.

    ## Example
    ```python robot_cfg.py
    from isaaclab.actuators import IdealPDActuatorCfg
    from isaaclab.assets.articulation import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": IdealPDActuatorCfg(
                joint_names_expr=[".*"], effort_limit=45.0, effort_limit_sim=23.7, stiffness=25.0, damping=0.5
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
                joint_names_expr=[".*"], effort_limit=45.0, effort_limit_sim=45.0, stiffness=25.0, damping=0.5
            )
        }
    )
    ```

    ## Source
    Isaac Lab 2.3.2 classes, measured: an implicit group with different values is a ValueError, for effort and for
    velocity. Isaac Lab 3.0, documentation of the actuators: the output is clipped again by `joint_effort_limit`.
    """

    code = "LIM106"
    name = "model-and-solver-limit-disagree"
    severity = Severity.WARNING
    confidence = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Compare the two limits of each group."""
        looked = False
        for group in groups_of(case, Framework.ISAACLAB, IMPLICIT):
            looked = True
            # In 3.0 both names are aliases of one field.
            for quantity in ("effort", "velocity") if _major(case.versions.isaaclab) < 3 else ():
                yield from self._implicit(group, f"{quantity}_limit", f"{quantity}_limit_sim")
        for group in groups_of(case, Framework.ISAACLAB, EXPLICIT):
            looked = True
            yield from self._explicit(group, "effort_limit", "effort_limit_sim")
            yield from self._explicit(group, "actuator_effort_limit", "joint_effort_limit")
        if not looked:
            yield Skipped(self.code, "no Isaac Lab cfg with a stock actuator class among the files")

    def _implicit(self, group: Group, first: str, second: str) -> Iterator[Finding]:
        one, two = group.written(first), group.written(second)
        if one is None or two is None or one.unknown is not None or two.unknown is not None:
            return
        if one.value == two.value:
            return
        for joint in group.joints:
            yield Finding(
                self.code,
                f"{first} ({_text(one)}) and {second} ({_text(two)}) are both set and differ: Isaac Lab 2.x raises "
                "ValueError when it builds this implicit group",
                two.span,
                joint,
                help=f"leave {first} out: the solver's limit is the one that an implicit drive has",
                related=(one.span,),
                severity=Severity.ERROR,
            )

    def _explicit(self, group: Group, own: str, solver: str) -> Iterator[Finding]:
        one, two = group.written(own), group.written(solver)
        if one is None or two is None:
            return
        for row in group.rows:
            limit, clamp = group.number(one, row.joint), group.number(two, row.joint)
            if limit is None or clamp is None or clamp >= limit:
                continue
            least = shown(row, "effort_limit", clamp)
            yield Finding(
                self.code,
                f"the model clips at {shown(row, 'effort_limit', limit)} and the solver again at {least}: the joint "
                f"never gets more than {least}, and the model reports what it does not get",
                two.span,
                row.joint,
                clamp,
                unit(row, "effort_limit"),
                limit,
                f"set {solver} to {own} or more",
                (one.span,),
            )


def _text(setting: Setting) -> str:
    value = setting.value
    if isinstance(value, Mapping):
        numbers = sorted(
            {f"{number:g}" for number in value.values() if isinstance(number, int | float)}, key=float
        )
        return f"by pattern: {', '.join(numbers)}"
    return f"{value:g}" if isinstance(value, int | float) else str(value)


class NoLine(Rule):
    """A DC motor or network class lacks a figure of its torque-speed line.

    ## What it does
    Reports groups of the classes that clip to a torque-speed line (DC motor, MLP and LSTM networks; in mjlab the DC
    motor and the learned MLP) that set no `velocity_limit` (Isaac Lab 3.0: `actuator_velocity_limit`) or no
    `saturation_effort`.

    ## Why it matters
    The line runs from `saturation_effort` at standstill to nothing at `velocity_limit`; without one of them there is
    no line, and the class refuses to be built: after the simulator has started, minutes into a run.

    ## Example
    ```python robot_cfg.py
    from isaaclab.actuators import DCMotorCfg
    from isaaclab.assets.articulation import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": DCMotorCfg(
                joint_names_expr=[".*"], effort_limit=23.7, saturation_effort=23.7, stiffness=25.0, damping=0.5
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
    Subclasses are not judged: their defaults are not in the file.

    ## Source
    Isaac Lab 2.3.2, actuator_pd.py: ValueError without either. mjlab 1.6.0: both are fields without a default.
    """

    code = "LIM110"
    name = "torque-speed-line-without-a-figure"
    severity = Severity.ERROR
    confidence = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find classes with half a line."""
        looked = False
        for group in (
            *groups_of(case, Framework.ISAACLAB, WITH_LINE),
            *groups_of(case, Framework.MJLAB, MJLAB_WITH_LINE),
        ):
            looked = True
            if not group.complete:
                continue
            missing = []
            if group.written("velocity_limit", "actuator_velocity_limit") is None:
                missing.append("velocity_limit")
            if group.written("saturation_effort") is None:
                missing.append("saturation_effort")
            for joint in group.joints if missing else ():
                yield Finding(
                    self.code,
                    f"this {group.cfg.cls} sets no {' and no '.join(missing)}: it cannot be built without its "
                    "torque-speed line",
                    group.cfg.span,
                    joint,
                    help="velocity_limit is the speed at which no torque is left, saturation_effort the torque at "
                    "standstill",
                )
        if not looked:
            yield Skipped(self.code, "no Isaac Lab or mjlab cfg with a torque-speed line among the files")


RULES: tuple[type[Rule], ...] = (ExplicitWithoutLimit, TwoLimits, NoLine)
