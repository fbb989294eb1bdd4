from __future__ import annotations

from collections.abc import Iterator
from os.path import basename
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.configs import is_as_written, names_model
from actspec.audit.rules.damping_parts import first_rows
from actspec.audit.rules.joints import by_joint, effort_noun, shown, unit
from actspec.readings.artifact import FileKind, Framework
from actspec.readings.ledger import LedgerRow

_Subject = tuple[LedgerRow, LedgerRow, float, float]


class GainBesideModelDamping(RuleOver[_Subject]):
    code = "DMP105"
    name = "cfg-kd-and-model-damping"
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    written_over = frozenset({"damping"})
    paired = True
    needs = "no configuration with a kd beside an MJCF of the same robot"
    options: ClassVar[dict[str, float]] = {"share": 0.5}

    def subjects(self, case: Case) -> Iterator[_Subject]:
        """Each model's joint beside each kd once: of configurations that take it from another the first counts."""
        seen: set[tuple[int, str, float]] = set()
        for rows in by_joint(case, FileKind.CFG, FileKind.DEPLOY).values():
            row = rows[0]
            if row.kd is None:
                continue
            for model in first_rows(case, row, FileKind.MJCF):
                if model.joint_damping is None or not self._is_its_model(case, row, model):
                    continue
                key = model.artifact, model.joint, row.kd
                if key in seen:
                    continue
                seen.add(key)
                yield row, model, row.kd, model.joint_damping

    def _is_its_model(self, case: Case, row: LedgerRow, model: LedgerRow) -> bool:
        """Whether a configuration runs on this model, as far as it says so."""
        config = case.artifacts[row.artifact].config
        own = config is not None and config.framework is Framework.MJLAB
        if config is None or not own:
            return True
        return is_as_written(config, "damping") and names_model(case, config, case.artifacts[model.artifact])

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Compare kd with the model's damping."""
        row, model, kd, damping = subject
        if kd <= 0.0 or damping <= 0.0 or "joint_damping" in row.stated:
            return
        found = self._compare(case, row, model, kd, damping)
        if found is not None:
            yield found

    def _compare(
        self, case: Case, row: LedgerRow, model: LedgerRow, kd: float, damping: float
    ) -> Finding | None:
        total = f"together {shown(row, 'kd', kd + damping)}"
        figures = f"a joint damping of {shown(row, 'kd', damping)}"
        file = basename(row.file)
        config = case.artifacts[row.artifact].config
        if config is not None and config.framework is Framework.MJLAB:
            if damping < self.option(case, "share") * kd:
                return None
            # The row's ratio is that with the first MJCF of the robot, which this one need not be.
            alone = (
                row.damping_ratio * kd / row.total_damping
                # A drive that the model has itself stays beside the configuration's, and stiffens the joint as well.
                if row.damping_ratio and row.total_damping and model.control in ("motor", "none")
                else None
            )
            text, absurd = "", False
            if alone is not None:
                ratio = alone * (kd + damping) / kd
                text = f", a damping ratio of {ratio:.2g} instead of {alone:.2g}"
                absurd = damping >= kd and ratio >= 1.0
            message = (
                f"the drive of {file} brakes with kd {shown(row, 'kd', kd)}, and {figures} stays beside it, "
                f"outside the {effort_noun(row)} limit: {total}{text}"
            )
            severity, confidence = (
                (Severity.ERROR, Confidence.HIGH) if absurd else (self.severity, self.confidence)
            )
        else:
            if damping < kd or model.control not in ("motor", "none"):
                return None
            message = (
                f"with the kd of {shown(row, 'kd', kd)} from {file}, this joint of the MJCF brakes with {figures} "
                f"as well: {total}, which that configuration does not have"
            )
            severity, confidence = Severity.INFO, self.confidence
        return Finding(
            self.code,
            message,
            model.place("joint_damping"),
            row.joint,
            damping,
            unit(row, "kd"),
            help="leave only the measured friction in the joint damping, or state it in the configuration",
            related=(row.place("kd"),),
            fields=("joint_damping",),
            severity=severity,
            confidence=confidence,
            noted_in_folders=(
                severity is not Severity.ERROR
                and _is_measured(damping)
                and _is_measured(model.frictionloss or 0.0)
            )
            or "actuators" in case.written(row.span, row.joint),
        )


def _is_measured(figure: float) -> bool:
    """Whether nobody guesses a figure: 168.77 N*m*s/rad beside 33.92 N*m are what an identification gave the joint."""
    return figure > 0.0 and float(f"{figure:.3g}") != figure
