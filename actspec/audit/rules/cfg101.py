from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence, Set
from dataclasses import replace
from os.path import basename

from actspec.audit.rule import Case, Confidence, Finding, RuleInParts, Severity
from actspec.audit.rules.configs import Group, groups_of, names_model
from actspec.audit.rules.joints import names_undriven
from actspec.diagnostics import shortened
from actspec.readings.artifact import ActuatorGroup, Artifact, FileKind, Framework, RobotConfig
from actspec.readings.dict_keys import dead_keys, is_no_expression, may_match, meant_for
from actspec.readings.dynamics import undriven
from actspec.readings.joint_names import joint_names, matching
from actspec.readings.versions import is_native

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

_SEVERAL = 2
"""Dicts of a group that leave out the same joint, which so is hardly forgotten in each. Chosen."""

_MIMIC = re.compile(rb"mimic[\w ]*joint", re.IGNORECASE)


class DictMissesJoint(RuleInParts):
    code = "CFG101"
    name = "dict-misses-a-joint"
    noted_in_folders = True
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    written_over = frozenset({"actuators", "joints", "gains", "efforts", "speeds", "armatures"})
    paired = True
    needs = "no Isaac Lab 2.x or legged_gym configuration with values by joint"

    def subjects(self, case: Case) -> Iterator[Iterable[Finding]]:
        """Find joints without a key."""
        if not is_native(case.versions):
            for group in groups_of(case, Framework.ISAACLAB):
                mimics = group.artifact in case.once(_with_mimics)
                absent = frozenset() if mimics else _may_be_absent(case, group)
                # A mimic joint follows another one, in the USD, and needs no drive.
                yield from (
                    [
                        replace(one, severity=Severity.INFO) if mimics or one.joint in absent else one
                        for one in some
                    ]
                    for some in self._missed(group)
                )
        for index, artifact in case.of_kind(FileKind.CFG):
            config = artifact.config
            if config is None or config.framework is not Framework.LEGGED_GYM:
                continue
            models = _models(case, index, config)
            for cfg in config.groups if models else ():
                stiffness = cfg.settings.get("stiffness")
                keys = None if stiffness is None else stiffness.keys
                if keys is not None and cfg.cls in ("P", "V"):
                    missed = [tuple(self._legged_gym(model, cfg, keys)) for model in models]
                    # Where several may be meant, it is the one that the keys fit best.
                    yield sorted(missed, key=len)[0]

    def _missed(self, group: Group) -> Iterator[Iterable[Finding]]:
        """For each dict of a group the joints without a key; but of limits, what the first dict lacks is told once."""
        told: set[str] = set()
        for name, effect in _ZERO.items():
            setting, is_limit = group.cfg.settings.get(name), "limit" in name
            if setting is None or (keys := setting.keys) is None:
                continue
            joints = [row.joint for row in group.rows]
            if any(map(is_no_expression, keys)) or dead_keys(group.framework, keys, group.cfg.joints or ()):
                # It raises, and gives nothing 0: CFG004, ORD104.
                yield ()
                continue
            dead = dead_keys(group.framework, keys, joints)
            missed = [
                joint
                for joint in joints
                if not any(may_match(group.framework, key, joint) for key in keys)
                and not any(meant_for(key, (), [joint]) for key in dead)
            ]
            yield [
                Finding(
                    self.code,
                    f"no key of {name} matches this joint of group {shortened(group.cfg.name)!r}: Isaac Lab 2.x gives "
                    f"it 0, and {effect}",
                    setting.span,
                    joint,
                    0.0,
                    "1",
                    help=f"add a key for it, or {{'.*': ...}}; keys: {', '.join(map(repr, keys[:8]))}",
                    severity=Severity.ERROR if name in ("effort_limit", "effort_limit_sim") else None,
                    about=name,
                )
                for joint in missed
                if is_limit or joint not in told
            ]
            if not is_limit:
                told.update(missed)

    def _legged_gym(self, model: Artifact, cfg: ActuatorGroup, keys: Sequence[str]) -> Iterator[Finding]:
        joints = joint_names(model) or ()
        missed = [joint for joint in joints if not any(key in joint for key in keys)]
        passive = _without_drive(model, set(joints).difference(missed))
        for joint in missed:
            yield Finding(
                self.code,
                f"no key of stiffness is part of the name of this joint of {basename(model.path)}: legged_gym gives "
                "it kp 0 and kd 0",
                cfg.settings["stiffness"].span,
                joint,
                help=f"keys: {', '.join(map(repr, keys[:8]))}",
                severity=Severity.INFO if joint in passive else None,
            )


def _without_drive(model: Artifact, driven: Set[str]) -> frozenset[str]:
    """Joints of a model that hang on purpose: their name says so, no actuator of the model drives them, or they are
    those without an effort where each of the driven ones has one.
    """
    robot = model.robot
    if robot is None:
        return frozenset()
    powered = {joint.name for joint in robot.scalar_joints if any(joint.effort_range or ())}
    without = {joint.name for joint in robot.scalar_joints} - powered
    by_effort = without if model.kind is FileKind.URDF and driven and driven <= powered else set()
    return undriven(robot) | by_effort | set(filter(names_undriven, joint_names(model) or ()))


def _with_mimics(case: Case) -> frozenset[int]:
    """Configurations whose file speaks of mimic joints."""
    files = {file.path for file in case.files if any(_MIMIC.search(part.data) for part in file.files)}
    return frozenset(index for index, artifact in case.of_kind(FileKind.CFG) if artifact.path in files)


def _may_be_absent(case: Case, group: Group) -> frozenset[str]:
    """Joints that each dict of a group leaves out, where the robot is another file's than the model that names them.

    A USD of a variant may lack them: nothing of it is read. But each pattern matches a joint there, or Isaac Lab
    raises: what is absent is beside one that has a key.
    """
    config = case.artifacts[group.artifact].config
    if config is None or config.model is None or _models(case, group.artifact, config):
        return frozenset()
    dicts = [setting.keys for setting in group.cfg.settings.values() if setting.keys]
    if len(dicts) < _SEVERAL:
        return frozenset()
    keys, joints = [key for some in dicts for key in some], [row.joint for row in group.rows]
    keyed = {joint for joint in joints if any(may_match(group.framework, key, joint) for key in keys)}
    met = [{*matching(group.framework, pattern, joints)} for pattern in group.cfg.joints or ()]
    return frozenset(joint for some in met if some & keyed for joint in some - keyed)


def _models(case: Case, index: int, config: RobotConfig) -> list[Artifact]:
    """URDFs and MJCFs of a configuration's robot that it names, or all where it does not name one."""
    if (setting := config.settings.get("model")) is not None and setting.unknown is not None:
        # It names one, and nobody can tell which.
        return []
    artifacts = (case.artifacts[other] for other in case.robot_of(index).artifacts)
    return [one for one in artifacts if one.robot is not None and names_model(case, config, one)]
