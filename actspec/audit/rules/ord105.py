from __future__ import annotations

from collections.abc import Iterator, Sequence

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.diagnostics import shortened
from actspec.readings.artifact import FileKind, Framework, RobotConfig, Setting
from actspec.readings.dict_keys import PLAIN, POSE, again
from actspec.readings.joint_names import joint_names
from actspec.simulators.classes import ISAACLAB

_BY_JOINT = ISAACLAB["ImplicitActuatorCfg"].mappable


class JointHasTwoKeys(RuleOver[tuple[int, RobotConfig]]):
    code = "ORD105"
    name = "joint-has-two-keys"
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    paired = True
    needs = "no Isaac Lab configuration with values by joint among the files that were named"

    def subjects(self, case: Case) -> Iterator[tuple[int, RobotConfig]]:
        for index, artifact in case.of_kind(FileKind.CFG):
            config = artifact.config
            # In a stranger's folder a model that is not this robot's would make two keys of one joint.
            if config is not None and config.framework is Framework.ISAACLAB and not case.is_met(index):
                yield index, config

    def judge(self, case: Case, subject: tuple[int, RobotConfig]) -> Iterator[Finding]:
        """Match every key of every dict."""
        index, config = subject
        members = (case.artifacts[other] for other in case.robot_of(index).artifacts)
        robot = next((member for member in members if member.robot is not None), None)
        every = (joint_names(robot) if robot is not None else None) or ()
        dicts = [("joint_pos", POSE, config.settings.get(POSE), every)]
        for group in config.groups:
            own = tuple(row.joint for row in case.rows_of(index) if row.span == group.span)
            named = own if robot is not None or all(map(PLAIN.fullmatch, own)) else ()
            for name in sorted(_BY_JOINT & group.settings.keys()):
                dicts.append((f"{name} of group {shortened(group.name)}", name, group.settings[name], named))
        for owner, name, setting, joints in dicts:
            if setting is None:
                continue
            for key, taken in again(config.framework, name, setting, joints or setting.keys or ()):
                for other, found in taken.items():
                    if joints or _certain(key, other, found):
                        yield from self._told(key, other, owner, setting, found if joints else [""])

    def _told(
        self, key: str, other: str, owner: str, setting: Setting, joints: Sequence[str]
    ) -> Iterator[Finding]:
        """One finding a joint; an empty name where nobody knows the joints."""
        for joint in joints:
            yield Finding(
                self.code,
                f"the keys '{shortened(other)}' and '{shortened(key)}' of {owner} both match "
                f"{'it' if joint else 'a joint'}: the cfg raises a ValueError",
                setting.place(key),
                joint,
                help="let one key match each joint",
                about=f"{key} {other} {owner}",
            )


def _certain(key: str, other: str, samples: Sequence[str]) -> bool:
    """Whether two keys that match a text both match a joint, where that is all that is known of the joints.

    A key that is a name, or any beside `.*`, matches none or one that the other does; for none the cfg is refused too.
    """
    return ".*" in (key, other) or any(map(PLAIN.fullmatch, samples))
