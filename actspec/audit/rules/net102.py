from __future__ import annotations

import math
from collections.abc import Iterator
from os.path import basename
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.networks_found import SAME, conventions, networks
from actspec.diagnostics import Span
from actspec.readings.artifact import Setting
from actspec.readings.named_network import NetworkConventions
from actspec.units import format_number

SCALES = {"pos_scale": "position_scale", "vel_scale": "velocity_scale", "torque_scale": "torque_scale"}
"""Field of the class to the manifest's."""


_Subject = tuple[NetworkConventions | None, str, str, Setting, float]


class NetworkScale(RuleOver[_Subject]):
    code = "NET102"
    name = "network-scale-or-sign"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    paired = True
    needs = "no configuration of a network with scales among the files"
    _NOTHING: ClassVar[dict[str, str]] = {
        "pos_scale": "the network does not see how far the joint is from its target",
        "vel_scale": "the network does not see the joint's speed",
        "torque_scale": "the network gives no torque",
    }

    def subjects(self, case: Case) -> Iterator[_Subject]:
        for index, _, group in networks(case):
            manifest = conventions(case, index, group)
            for name, theirs in SCALES.items():
                setting = group.settings.get(name)
                value = setting.number if setting is not None else None
                if setting is None or value is None:
                    continue
                yield manifest, name, theirs, setting, value

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Compare scales."""
        manifest, name, theirs, setting, value = subject
        if manifest is not None:
            yield from self._against(name, value, setting.span, manifest, getattr(manifest, theirs))
        elif value == 0.0:
            yield Finding(
                self.code,
                f"{name} is 0: {self._NOTHING[name]}",
                setting.span,
                about=name,
            )
        elif value < 0.0 and name != "torque_scale":
            yield self._negative(name, value, setting.span)

    def _negative(self, name: str, value: float, span: Span) -> Finding:
        fed = "measured - target" if name == "pos_scale" else "minus the measured velocity"
        return Finding(
            self.code,
            f"{name} {format_number(value)} feeds the network {fed}: right only for a network that was trained so",
            span,
            help="write it down in a manifest beside the network; `actspec schema network` has its keys",
            severity=Severity.INFO,
            confidence=Confidence.LOW,
            about=f"{name} {format_number(value)}",
        )

    def _against(
        self, name: str, value: float, span: Span, manifest: NetworkConventions, trained: float
    ) -> Iterator[Finding]:
        if math.isclose(value, trained, rel_tol=SAME):
            return
        turned = value * trained < 0.0
        effect = ""
        if turned:
            effect = (
                ": the torque pushes the wrong way"
                if name != "vel_scale"
                else ": it drives where it should brake"
            )
        yield Finding(
            self.code,
            f"{name} is {format_number(value)}, and {basename(manifest.path)} says {format_number(trained)}{effect}",
            span,
            "",
            value,
            "1",
            trained,
            f"{name}={format_number(trained)}",
            (Span(manifest.path),),
            severity=Severity.ERROR if turned else self.severity,
        )
