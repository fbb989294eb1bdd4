from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from actspec.audit.other_variants import TELLING, is_same
from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.spec_pairs import NO_SPEC, SpecJoint, spec_joints
from actspec.diagnostics import listed
from actspec.fields import FIELDS
from actspec.readings.artifact import Artifact
from actspec.readings.ledger import LedgerRow, rows_of_spec
from actspec.spec.variants import MARK, split

_Variants = dict[str, dict[str, LedgerRow]]
"""Name of a variant to what it says of each joint; "" of a spec as it stands that has no name for that."""


class FileOfAnotherVariant(RuleOver[Sequence[SpecJoint]]):
    code = "SPC107"
    name = "file-of-another-variant"
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    paired = True
    needs = NO_SPEC

    def subjects(self, case: Case) -> Iterator[Sequence[SpecJoint]]:
        """The joints of each file that a spec describes."""
        files: dict[tuple[int, int], list[SpecJoint]] = {}
        for joint in spec_joints(case):
            files.setdefault((joint.spec.artifact, joint.rows[0].artifact), []).append(joint)
        yield from files.values()

    def judge(self, case: Case, subject: Sequence[SpecJoint]) -> Iterator[Finding]:
        """Hold what the file states where variants differ to each of them."""
        spec = case.artifacts[subject[0].spec.artifact]
        if not spec.variants or spec.spec is None:
            return
        own = spec.spec.variant or ""
        variants = {name: _rows(spec, index) for index, (name, _) in enumerate(spec.variants)}
        variants[own] = {joint.rows[0].joint: joint.spec for joint in subject}
        fields, fitting = _fitting(subject, variants)
        if not fitting or own in fitting:
            return
        file = split(spec.path)[0]
        use = " or ".join(f"{file}{MARK}{name}" if name else file for name in fitting)
        joints = {
            joint.rows[0].joint: (joint, found)
            for joint in subject
            if (found := _of_variant(joint, variants, fitting))
        }
        by = listed([FIELDS[field].noun for field in fields])
        said = f"this file is of {_either(fitting)}, by {by}; the spec is read as {own or 'it stands'}: use {use}"
        for name, (joint, found) in joints.items():
            mine, wanted = joint.mine(found[0]), joint.wanted(found[0])
            assert mine is not None and wanted is not None
            yield Finding(
                self.code,
                said,
                mine.place,
                name,
                help="hold the file to that variant; or, if the robot is as the spec is read, take that one's file",
                related=(wanted.place,),
                fields=found,
            )


def _rows(artifact: Artifact, index: int) -> dict[str, LedgerRow]:
    other = replace(artifact, spec=artifact.variants[index][1])
    return {row.joint: row for row in rows_of_spec(other, 0)}


def _fitting(joints: Sequence[SpecJoint], variants: _Variants) -> tuple[list[str], list[str]]:
    """By which figures the variants are told, and those that the file fits in all that they differ in.

    Limits tell first, then armatures, then gains: the rest only of those that are left, as far as it agrees with one.
    """
    told: list[str] = []
    left = list(variants)
    for field in TELLING:
        fits = dict.fromkeys(left, True)
        tells = False
        for joint in joints:
            mine = joint.mine(field)
            figures = {name: getattr(variants[name][joint.rows[0].joint], field) for name in left}
            first = figures[left[0]]
            if mine is None or mine.value is None or None in figures.values():
                continue
            if all(is_same(figure, first) for figure in figures.values()):
                continue
            tells = True
            for name, figure in figures.items():
                fits[name] = fits[name] and is_same(mine.value, figure)
        fitting = [name for name, fit in fits.items() if fit]
        if tells and (fitting or not told):
            left = fitting
            told.append(field)
        if len(left) < 2:
            break
    return told, left if told else []


def _of_variant(joint: SpecJoint, variants: _Variants, fitting: Sequence[str]) -> tuple[str, ...]:
    """Fields in which a joint departs from the spec and agrees with a variant that its file fits."""
    found = []
    for field in TELLING:
        mine, wanted = joint.mine(field), joint.wanted(field)
        if mine is None or wanted is None or mine.value is None or is_same(mine.value, wanted.value):
            continue
        rows = (variants[name][joint.rows[0].joint] for name in fitting)
        if all(is_same(mine.value, getattr(row, field)) for row in rows):
            found.append(field)
    return tuple(found)


def _either(names: Sequence[str]) -> str:
    """Names of which one holds: `mode_5 or mode_13`."""
    *others, last = (name or "the spec as it stands" for name in names)
    return f"{listed(others)} or {last}" if others else last
