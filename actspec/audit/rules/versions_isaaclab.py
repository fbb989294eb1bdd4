"""VER: fields of Isaac Lab's actuators whose name or meaning a release changed."""

from __future__ import annotations

import math
from collections.abc import Iterator

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Safety, Skipped
from actspec.audit.rule import Rule
from actspec.audit.rules.cfg_groups import IMPLICIT, Group, groups_of
from actspec.audit.rules.joint_units import shown
from actspec.audit.rules.keywords import renaming
from actspec.diagnostics import Severity
from actspec.readings.artifact import ActuatorGroup, FileKind, Framework, Setting
from actspec.readings.config_figures import control_of
from actspec.readings.versions import Release, release

_NEW = {
    "effort_limit": "actuator_effort_limit",
    "velocity_limit": "actuator_velocity_limit",
    "effort_limit_sim": "joint_effort_limit",
    "velocity_limit_sim": "joint_velocity_limit",
}
"""Name in 2.x to the name in 3.0. Source: Isaac Lab 3.0, actuator_base_cfg.py."""
_OLD = {new: old for old, new in _NEW.items()}


class NamesByVersion(Rule):
    """Limits have the names of another Isaac Lab.

    ## What it does
    Reports `actuator_effort_limit`, `actuator_velocity_limit`, `joint_effort_limit` and `joint_velocity_limit` in a
    configuration that is meant for 2.x, `effort_limit`, `velocity_limit` and their `_sim` forms in one for 3.0 and
    later, and, where no version is named, a file that has both.

    ## Why it matters
    2.x has no fields of the new names: the configuration raises a TypeError when it is made. 3.0 takes the old names
    with a deprecation warning, and 4.0 does not have them.

    ## Example
    ```sh
    actspec audit robot_cfg.py --target isaaclab==2.3
    ```
    ```python robot_cfg.py
    from isaaclab.actuators import IdealPDActuatorCfg
    from isaaclab.assets.articulation import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": IdealPDActuatorCfg(
                joint_names_expr=[".*"], actuator_effort_limit=23.7, stiffness=25.0, damping=0.5
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
            "legs": IdealPDActuatorCfg(joint_names_expr=[".*"], effort_limit=23.7, stiffness=25.0, damping=0.5)
        }
    )
    ```

    ## Limits
    Classes that are not Isaac Lab's own may have fields of either name; they are judged like the stock class whose name
    theirs contains, and others not at all. Names are mended where they are keywords of the class and mean the same: an
    implicit drive's `effort_limit` and `velocity_limit` are left to you, and so are files with names of both.

    ## Source
    Isaac Lab 3.0, `actuator_base_cfg.py` and its compatibility module (read, not run); 2.2.0 and 2.3.2, run.
    """

    code = "VER103"
    name = "isaaclab-names-by-version"
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    fix = Safety.SAFE

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Compare names with the version, or with each other."""
        named = case.versions.isaaclab
        looked = False
        for path, groups in _groups(case).items():
            looked = True
            old = [(group, name) for group in groups for name in _NEW if name in group.settings]
            new = [(group, name) for group in groups for name in _OLD if name in group.settings]
            if named is not None:
                yield from self._against(case, old, new, release(named), named)
            elif old and new:
                yield self._mixed(path, old, new)
        if not looked:
            yield Skipped(self.code, "no Isaac Lab cfg with actuators among the files")

    def _against(
        self,
        case: Case,
        old: list[tuple[ActuatorGroup, str]],
        new: list[tuple[ActuatorGroup, str]],
        version: Release,
        text: str,
    ) -> Iterator[Finding]:
        if version < (3,):
            for group, name in new:
                yield Finding(
                    self.code,
                    f"Isaac Lab {text} has no {name}: the cfg raises TypeError when it is made",
                    group.settings[name].span,
                    help=f"2.x calls it {_OLD[name]}",
                    fix=renaming(case, group, name, _OLD[name]) if _is_plain(group, name) else None,
                )
            return
        gone = version >= (4,)
        for group, name in old:
            yield Finding(
                self.code,
                f"Isaac Lab {text} has no {name} any more"
                if gone
                else f"{name} is a deprecated name in Isaac Lab {text}, and gone in 4.0",
                group.settings[name].span,
                help=f"3.0 calls it {_new_name(group, name)}",
                fix=renaming(case, group, name, _NEW[name]) if _is_plain(group, name) else None,
                severity=Severity.ERROR if gone else Severity.WARNING,
            )

    def _mixed(
        self, path: str, old: list[tuple[ActuatorGroup, str]], new: list[tuple[ActuatorGroup, str]]
    ) -> Finding:
        (before, old_name), (after, new_name) = old[0], new[0]
        return Finding(
            self.code,
            f"{new_name} is a name of Isaac Lab 3.0 and {old_name} one of 2.x: 2.x does not read this file, and 4.0 "
            "neither",
            after.settings[new_name].span,
            help=f"name the limits as one version does: {old_name} is {_new_name(before, old_name)} in 3.0",
            related=(before.settings[old_name].span,),
            severity=Severity.WARNING,
        )


def _groups(case: Case) -> dict[str, list[ActuatorGroup]]:
    """Groups of Isaac Lab's classes by file."""
    found: dict[str, list[ActuatorGroup]] = {}
    for _, artifact in case.of_kind(FileKind.CFG):
        config = artifact.config
        if config is not None and config.framework is Framework.ISAACLAB:
            known = [group for group in config.groups if control_of(config.framework, group.cls) != "other"]
            found.setdefault(artifact.path, []).extend(known)
    return {path: groups for path, groups in found.items() if groups}


def _new_name(group: ActuatorGroup, name: str) -> str:
    """An implicit drive's limits are the joint's, whatever 2.x called them."""
    if control_of(Framework.ISAACLAB, group.cls) == "implicit":
        return _NEW[name].replace("actuator_", "joint_")
    return _NEW[name]


def _is_plain(group: ActuatorGroup, name: str) -> bool:
    """Whether the field is the same one in both versions; what 2.x makes of an implicit drive's own limits is not."""
    own = name in ("effort_limit", "velocity_limit") or name.startswith("actuator_")
    return not own or control_of(Framework.ISAACLAB, group.cls) != "implicit"


class ImplicitVelocityLimit(Rule):
    """An implicit drive's `velocity_limit` is ignored.

    ## What it does
    Reports groups of `ImplicitActuatorCfg` in Isaac Lab that set a finite `velocity_limit` and no `velocity_limit_sim`.
    Silent where 3.0 or later is named.

    ## Why it matters
    2.x warns in its log, sets the field to None, and the joint keeps the USD's speed limit. The number in the file
    looks like a limit, and the joint moves as fast as it likes: a knee of 20 rad/s swings at the 100 rad/s that an
    importer wrote.

    ## Example
    ```python robot_cfg.py
    from isaaclab.actuators import ImplicitActuatorCfg
    from isaaclab.assets.articulation import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": ImplicitActuatorCfg(
                joint_names_expr=[".*"], effort_limit_sim=139.0, velocity_limit=20.0, stiffness=150.0, damping=4.0
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
                joint_names_expr=[".*"], effort_limit_sim=139.0, velocity_limit_sim=20.0, stiffness=150.0, damping=4.0
            )
        }
    )
    ```

    ## Limits
    `velocity_limit_sim` is enforced by the solver, which brakes hard above it; trainings that ran without a limit may
    behave otherwise with one.

    ## Source
    Isaac Lab 2.2.0 and 2.3.2 classes, measured; since extension 0.34.6; isaac-sim/IsaacLab#1837, #2135, #2952.
    """

    code = "VER104"
    name = "implicit-velocity-limit-ignored"
    severity = Severity.WARNING
    confidence = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find limits without effect."""
        named = case.versions.isaaclab
        if named is not None and release(named) >= (3,):
            yield Skipped(self.code, "Isaac Lab 3.0 reads the limit under another name")
            return
        looked = False
        for group in groups_of(case, Framework.ISAACLAB, IMPLICIT):
            looked = True
            setting = group.written("velocity_limit")
            if setting is None or group.written("velocity_limit_sim", "joint_velocity_limit") is not None:
                continue
            for joint in group.joints:
                if group.number(setting, joint) == math.inf:
                    continue
                yield Finding(
                    self.code,
                    f"{self._limit(group, setting, joint)} is ignored for an implicit drive: the joint keeps the USD's "
                    "speed limit",
                    setting.span,
                    joint,
                    help="write velocity_limit_sim if the solver is to enforce it, or leave it out",
                )
        if not looked:
            yield Skipped(self.code, "no implicit drives of Isaac Lab among the files")

    def _limit(self, group: Group, setting: Setting, joint: str) -> str:
        number = group.number(setting, joint)
        if number is None:
            return (
                f"velocity_limit (which could not be read: {setting.unknown})"
                if setting.unknown
                else "velocity_limit"
            )
        row = next((row for row in group.rows if row.joint == joint), None)
        return f"velocity_limit {shown(row, 'velocity_limit', number) if row else f'{number:.3g}'}"


RULES: tuple[type[Rule], ...] = (NamesByVersion, ImplicitVelocityLimit)
