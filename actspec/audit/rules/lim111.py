from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from actspec.audit.rule import Case, Confidence, Finding, RuleInParts, Severity
from actspec.audit.rules.configs import names_model
from actspec.audit.rules.joints import is_left_at_zero, partner_rows, shown, unit
from actspec.audit.rules.sided import are_of_two_sides
from actspec.audit.rules.unt101 import ranges_in_doubt
from actspec.diagnostics import Span
from actspec.ir import JointKind
from actspec.poses import POSE_TOLERANCE, far_words, outside_words
from actspec.readings.artifact import FileKind, Framework
from actspec.readings.compare import angle_slip
from actspec.readings.dict_keys import plain_name
from actspec.readings.joint_names import joint_names
from actspec.readings.ledger import LedgerRow

_SINGLE = 1e-5
"""How far beyond the range Isaac Lab's check may take a position for inside [rad or m]. It compares without a
tolerance, in single precision; a USD has degrees, of which 180 is known to 1.5e-5, 2.7e-7 rad. Chosen: far above."""


_SAME = 0.01
"""Largest relative difference of equal positions, as `tolerance` of SRC106."""


class PoseOutOfRange(RuleInParts):
    code = "LIM111"
    name = "default-position-out-of-range"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    noted_in_folders = True
    paired = True
    needs = (
        "no configuration or deploy file states a default position of a joint with a range in a URDF or MJCF"
    )

    def subjects(self, case: Case) -> Iterator[Iterable[Finding]]:
        """Joints with a default position and a range, and those of which no model is at hand."""
        for index, artifact in case.of_kind(FileKind.CFG, FileKind.DEPLOY):
            far: dict[Span, Finding] = {}
            for row in case.rows_of(index):
                models = list(_ranges(case, row)) if row.joint and _starts_there(case, row) else []
                if models:
                    yield self._outside(case, row, models)
                elif artifact.kind is FileKind.CFG:
                    # Programs on a robot may have degrees. A key may be for several groups.
                    far |= {found.span: found for found in self._far(case, row)}
            if far:
                yield far.values()

    def _outside(self, case: Case, row: LedgerRow, models: Sequence[LedgerRow]) -> Iterator[Finding]:
        """Isaac Lab goes by the URDF that it loads; else the joint has none of the ranges."""
        if _is_in_doubt(case, row):
            return
        loaded = [model for model in models if _is_loaded(case, row, model)]
        refused = [one for model in loaded if (one := self._finding(case, row, model, _SINGLE, True))]
        if loaded:
            yield from refused[:1]
            return
        meant = [model for model in models if not _has_other_names(case, row, model)]
        found = [self._finding(case, row, model, POSE_TOLERANCE[_kind(model)], False) for model in meant]
        if all(found):
            yield from filter(None, found[:1])

    def _far(self, case: Case, row: LedgerRow) -> Iterator[Finding]:
        """Positions beyond a full turn, where no model tells what the joint is."""
        if any(partner_rows(case, row, FileKind.URDF, FileKind.MJCF)) or _is_in_doubt(case, row):
            return
        poses = dict(row.by_key.get("default_position", {}))
        if row.default_position is not None and "default_position" in row.stated:
            poses[row.joint] = (row.default_position, row.place("default_position"))
        for joint, (pose, place) in poses.items():
            if (words := far_words(pose)) is not None:
                yield Finding(
                    self.code,
                    words[0],
                    place,
                    joint,
                    pose,
                    "rad",
                    help=words[1],
                    fields=("default_position",),
                    confidence=Confidence.MEDIUM,
                )

    def _finding(
        self, case: Case, row: LedgerRow, model: LedgerRow, tolerance: float, refused: bool
    ) -> Finding | None:
        pose, limits = row.default_position, model.position_range
        assert pose is not None and limits is not None
        words = outside_words(_kind(model), limits, pose, tolerance)
        if words is None:
            return None
        beyond, message, help = words
        config = case.artifacts[row.artifact].config
        then = f"the joint stops {shown(row, 'default_position', beyond)} before it"
        if refused:
            then = "Isaac Lab raises an error at the start"
        elif config is not None and config.framework is Framework.ISAACLAB:
            then = "Isaac Lab raises an error at the start, if its USD has the range too"
        missing = "" if "default_position" in row.stated else " (no key of joint_pos is for the joint)"
        return Finding(
            self.code,
            f"{message} in {model.file}{missing}: {then}",
            row.place("default_position"),
            row.joint,
            pose,
            unit(row, "default_position"),
            help=help or "state a default position inside of the range, or correct the range",
            related=(model.place("position_range"),),
            fields=("default_position",),
            severity=Severity.ERROR if refused else None,
        )


def _starts_there(case: Case, row: LedgerRow) -> bool:
    """Whether a row has the position at which its joint starts: Isaac Lab starts what no key is for at 0."""
    if row.default_position is None or case.artifacts[row.artifact].config is None:
        return False
    return "default_position" in row.stated or is_left_at_zero(case, row)


def _is_in_doubt(case: Case, row: LedgerRow) -> bool:
    """Whether another file has the same position in the other unit, which UNT103 tells."""
    poses = (other.default_position for other in partner_rows(case, row, FileKind.CFG, FileKind.DEPLOY))
    return any(angle_slip((row.default_position or 0.0) / pose, _SAME) for pose in poses if pose)


def _ranges(case: Case, row: LedgerRow) -> Iterator[LedgerRow]:
    """The joint in each model of the robot that gives it a range, of which the unit is not in doubt (UNT101)."""
    seen = set()
    for model in partner_rows(case, row, FileKind.URDF, FileKind.MJCF):
        if model.artifact in seen or model.position_range is None or model.kind not in POSE_TOLERANCE:
            continue
        seen.add(model.artifact)
        low, high = model.position_range
        doubted = (model.place("position_range").path, model.joint) in case.once(ranges_in_doubt)
        other = are_of_two_sides(case, row.artifact, model.artifact)
        if low < high and not doubted and not other and not case.is_idle(model.span):
            yield model


def _is_loaded(case: Case, row: LedgerRow, model: LedgerRow) -> bool:
    """Whether an Isaac Lab configuration has the robot from this URDF itself; a USD may have other ranges."""
    config, artifact = case.artifacts[row.artifact].config, case.artifacts[model.artifact]
    if config is None or config.framework is not Framework.ISAACLAB or artifact.kind is not FileKind.URDF:
        return False
    return (config.model or "").lower().endswith(".urdf") and names_model(case, config, artifact)


def _has_other_names(case: Case, row: LedgerRow, model: LedgerRow) -> bool:
    """Whether a configuration sets the pose of a joint that the model has not: its USD names its joints otherwise."""
    config, joints = case.artifacts[row.artifact].config, joint_names(case.artifacts[model.artifact]) or ()
    setting = None if config is None else config.settings.get("default_position")
    if config is None or setting is None:
        return False
    names = (plain_name(config.framework, key) for key in setting.keys or ())
    return any(name is not None and name not in joints for name in names)


def _kind(model: LedgerRow) -> JointKind:
    return JointKind.SLIDE if model.kind is JointKind.SLIDE else JointKind.HINGE
