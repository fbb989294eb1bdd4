"""Actuator groups of configurations: those of stock classes, and what is written in them.

Subclasses are left out: their defaults are not in the file.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from os.path import basename, splitext

from actspec.audit.case import Case
from actspec.diagnostics import nearest
from actspec.readings.artifact import ActuatorGroup, Artifact, FileKind, Framework, RobotConfig, Setting
from actspec.readings.called import agreement
from actspec.readings.joint_names import matching
from actspec.readings.ledger import LedgerRow
from actspec.simulators.classes import ISAACLAB, MJLAB, StockClass

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


def is_whole_robot(config: RobotConfig) -> bool:
    """Whether the groups are a robot's, and all of them are known."""
    if not config.groups or any(group.joints is None for group in config.groups):
        return False
    if any(note.where.startswith("actuators") for note in config.notes):
        return False
    return len(config.groups) > 1 or config.groups[0].name != config.name


def posed(config: RobotConfig, names: Sequence[str]) -> tuple[str, ...]:
    """Joints whose position a configuration sets by a key that not every joint has: its own robot has them, then."""
    setting = config.settings.get("default_position")
    value = setting.value if setting is not None else None
    keys = [str(key) for key in value] if isinstance(value, Mapping) else []
    meant = [found for key in keys if 0 < len(found := matching(config.framework, key, names)) < len(names)]
    return tuple(name for name in names if any(name in found for found in meant))


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
            if classes is None or (group.cls in classes and group.is_stock):
                own = tuple(row for row in rows if row.actuator == group.name and row.span == group.span)
                after = next((start for start in starts if start > group.span), None)
                complete = not alone and not any(
                    group.span <= gap and (after is None or gap < after) for gap in gaps
                )
                yield Group(group, framework, index, own, complete)


def names_model(case: Case, config: RobotConfig, model: Artifact) -> bool:
    """Whether a configuration names this model, or none.

    Of several models of the name it is the one whose folders agree farthest: `d1_wheel/urdf/robot.urdf` is not
    `d1/urdf/robot.urdf`, where both are there.
    """
    if config.model is None:
        return True
    found = agreement(config.model, model.path)
    paths = case.once(_models_by_stem).get(_stem(config.model), ())
    return found > 0 and found == max(agreement(config.model, path) for path in paths)


_MOUNTS = frozenset({"attach", "attach_body", "delete", "detach_body", "add_joint", "add_body"})


def is_as_written(config: RobotConfig, *edits: str) -> bool:
    """Whether no program changes the joints of a configuration's model, nor calls or sets one of these of it."""
    return config.edited.isdisjoint(_MOUNTS.union(edits))


def _models_by_stem(case: Case) -> dict[str, list[str]]:
    """Paths of all models, by the names of their files."""
    found: dict[str, list[str]] = {}
    for artifact in case.artifacts:
        if artifact.robot is not None:
            found.setdefault(_stem(artifact.path), []).append(artifact.path)
    return found


def _stem(path: str) -> str:
    return splitext(basename(path.replace("\\", "/")))[0]


def major_version(version: str | None) -> int:
    return 2 if version is None else int(version.split(".")[0])


NO_STOCK_CLASSES = "no configuration with stock classes of Isaac Lab or mjlab among the files"


CLASSES = {Framework.ISAACLAB: ISAACLAB, Framework.MJLAB: MJLAB}


def stock_groups(case: Case) -> Iterator[tuple[int, RobotConfig, ActuatorGroup, StockClass]]:
    """Groups of stock classes: artifact, configuration, group, class. A class of the user's own is none."""
    for index, artifact in case.of_kind(FileKind.CFG):
        config = artifact.config
        if config is None:
            continue
        for group in config.groups:
            stock = CLASSES.get(config.framework, {}).get(group.cls)
            if stock is not None and group.is_stock:
                yield index, config, group, stock


def misspelt(framework: Framework, group: ActuatorGroup) -> dict[str, str | None]:
    """Fields of a group that its stock class does not have, each with the one that is meant, if one is near."""
    stock = CLASSES.get(framework, {}).get(group.cls)
    if stock is None or not group.is_stock:
        return {}
    known = sorted(stock.fields)
    return {name: nearest(name, known) for name in group.settings if name not in stock.fields}


LAGS = {
    Framework.ISAACLAB: ("min_delay", "max_delay"),
    Framework.MJLAB: ("delay_min_lag", "delay_max_lag"),
}
"""Least and greatest delay of an actuator group [physics steps]."""


def lags(framework: Framework, group: ActuatorGroup) -> Iterator[tuple[str, Setting]]:
    """The ends of a group's delay that are written, by name."""
    for name in LAGS.get(framework, ()):
        setting = group.settings.get(name)
        if setting is not None:
            yield name, setting


def is_whole(steps: float) -> bool:
    """Whether a number of steps is a whole one, but for the last digits of a quotient."""
    return math.isclose(steps, round(steps), rel_tol=1e-6, abs_tol=0.0) if math.isfinite(steps) else False
