"""Actuator groups of configurations by their stock class, and what is written in them.

Subclasses are left out: their defaults are not in the file.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from os.path import basename, splitext

from actspec.audit.case import Case
from actspec.readings.artifact import ActuatorGroup, Artifact, FileKind, Framework, RobotConfig, Setting
from actspec.readings.ledger import LedgerRow
from actspec.readings.pair import matching

FRAMEWORKS = {Framework.ISAACLAB: "Isaac Lab", Framework.MJLAB: "mjlab"}

IMPLICIT = frozenset({"ImplicitActuatorCfg"})
"""Isaac Lab's class whose drive the solver integrates."""

WITH_LINE = frozenset({"DCMotorCfg", "ActuatorNetMLPCfg", "ActuatorNetLSTMCfg"})
"""Isaac Lab's classes that clip to a torque-speed line. Source: 2.3.2, actuator_pd.py and actuator_net.py."""

EXPLICIT = WITH_LINE | {"IdealPDActuatorCfg", "DelayedPDActuatorCfg"}
"""Isaac Lab's classes that compute the torque themselves; RemotizedPD has its limit in a table."""

MJLAB_WITH_LINE = frozenset({"DcMotorActuatorCfg", "LearnedMlpActuatorCfg"})
"""mjlab's classes likewise. Source: mjlab 1.6.0, actuator/dc_actuator.py, actuator/learned_actuator.py."""


@dataclass(frozen=True, slots=True)
class Group:
    """One actuator group and its joints.

    Attributes:
        cfg: As written.
        framework: Whose class it is.
        artifact: Index into `Case.artifacts`.
        rows: Ledger rows of its joints.
        complete: Whether what is not written is not set: all of it could be folded, and it is in a robot, where no
            other file fills it in.
    """

    cfg: ActuatorGroup
    framework: Framework
    artifact: int
    rows: tuple[LedgerRow, ...]
    complete: bool

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of its joints; one empty name when nobody knows them."""
        return tuple(row.joint for row in self.rows) or ("",)

    def written(self, *names: str) -> Setting | None:
        """The first of the settings that is written and not None; one that could not be folded counts."""
        for name in names:
            setting = self.cfg.settings.get(name)
            if setting is not None and (setting.value is not None or setting.unknown is not None):
                return setting
        return None

    def number(self, setting: Setting | None, joint: str) -> float | None:
        """A setting's value for one joint; None where it is unknown or does not cover the joint."""
        value: object = setting.value if setting is not None and setting.unknown is None else None
        if isinstance(value, Mapping):
            keys = (key for key in value if key == joint or matching(self.framework, str(key), (joint,)))
            value = value.get(next(keys, ""))
        return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else None


def groups_of(case: Case, framework: Framework, classes: frozenset[str] | None = None) -> Iterator[Group]:
    """Groups of a framework's configurations.

    Args:
        case: The case.
        framework: Whose configurations.
        classes: Names of stock classes; None: of any class.
    """
    for index, artifact in case.of_kind(FileKind.CFG):
        config = artifact.config
        if config is None or config.framework is not framework:
            continue
        rows = case.rows_of(index)
        starts = sorted(group.span for group in config.groups)
        gaps = [note.span for note in config.notes if note.span is not None]
        alone = len(config.groups) == 1 and config.groups[0].name == config.name
        for group in config.groups:
            if classes is None or group.cls in classes:
                own = tuple(row for row in rows if row.actuator == group.name and row.span == group.span)
                after = next((start for start in starts if start > group.span), None)
                complete = not alone and not any(
                    group.span <= gap and (after is None or gap < after) for gap in gaps
                )
                yield Group(group, framework, index, own, complete)


def names_model(config: RobotConfig, model: Artifact) -> bool:
    """Whether a configuration names this model, or none."""
    setting = config.settings.get("model")
    if setting is None or not isinstance(setting.value, str):
        return True
    return splitext(basename(setting.value))[0] == splitext(basename(model.path))[0]


def major_version(version: str | None) -> int:
    return 2 if version is None else int(version.split(".")[0])
