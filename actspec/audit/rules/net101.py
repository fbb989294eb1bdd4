from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

from actspec.audit.rule import Case, Confidence, Finding, RuleInParts, Severity
from actspec.audit.rules.networks_found import (
    SAME,
    conventions,
    networks,
    of_specs,
    tap_factor,
)
from actspec.diagnostics import Span
from actspec.readings.artifact import ActuatorGroup, Framework, RobotConfig
from actspec.readings.named_network import NetworkConventions
from actspec.readings.networks import tap_steps
from actspec.units import format_quantity


class HistoryPeriod(RuleInParts):
    code = "NET101"
    name = "network-history-period"
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    paired = True
    needs = "no network with a manifest, a tap period and a physics step"

    def subjects(self, case: Case) -> Iterator[Iterable[Finding]]:
        """Compare how far back the taps reach."""
        for index, config, group in networks(case):
            manifest = conventions(case, index, group)
            step = _step(case, index, config)
            if manifest is None or manifest.tap_period is None or step is None:
                continue
            yield self._otherwise(config, group, manifest, manifest.tap_period, *step)
        for artifact, network in of_specs(case):
            own = artifact.spec.physics_dt if artifact.spec is not None else None
            manifest = network.manifest
            if own is None or not own.value or manifest is None or manifest.tap_period is None:
                continue
            yield self._between_steps(network.span, manifest, manifest.tap_period, own.value, own.span)

    def _otherwise(
        self,
        config: RobotConfig,
        group: ActuatorGroup,
        manifest: NetworkConventions,
        period: float,
        dt: float,
        place: Span,
    ) -> Iterator[Finding]:
        """A network of a configuration whose samples are not those that it learned from."""
        reach = _stride(config, group, manifest)
        if reach is None:
            return
        stride, last = reach
        if not math.isclose(stride * dt, period, rel_tol=SAME):
            yield Finding(
                self.code,
                f"the network learned from samples {_ms(period)} apart and gets samples {_ms(stride * dt)} apart: what "
                f"it learned of {_ms(last * period)} happens within {_ms(last * stride * dt)}",
                _place(group),
                "",
                stride * dt,
                "s",
                period,
                _help(config, manifest, period / dt),
                (Span(manifest.path), place),
            )

    def _between_steps(
        self, span: Span, manifest: NetworkConventions, period: float, dt: float, place: Span | None
    ) -> Iterator[Finding]:
        """A network of a spec whose samples do not fall on the spec's steps."""
        steps = period / dt
        whole = max(round(steps), 1)
        if not math.isclose(steps, whole, rel_tol=SAME):
            yield Finding(
                self.code,
                f"the network learned from samples {_ms(period)} apart, which is {steps:.3g} physics steps of "
                f"{_ms(dt)}: no class of a simulator takes samples between steps",
                span,
                "",
                dt,
                "s",
                period / whole,
                "set timing.physics_dt to a whole part of the period, or train the network on samples of this step",
                (Span(manifest.path), *((place,) if place is not None else ())),
            )


def _step(case: Case, index: int, config: RobotConfig) -> tuple[float, Span] | None:
    """The physics step and its place: the configuration's own, else another one's of the robot."""
    others = (case.artifacts[other].config for other in case.robot_of(index).artifacts)
    for one in (config, *others):
        setting = one.settings.get("physics_dt") if one is not None else None
        value = setting.number if setting is not None else None
        if setting is not None and value is not None and value > 0.0:
            return value, setting.span
    return None


def _stride(
    config: RobotConfig, group: ActuatorGroup, manifest: NetworkConventions
) -> tuple[float, int] | None:
    """Physics steps between two samples, and the last sample; None where the taps do not fit or do not matter."""
    if manifest.kind != "mlp":
        return 1.0, 1
    indices = tap_steps(config.framework, group)
    if indices is None or not any(manifest.taps):
        return None
    stride = tap_factor(indices, manifest.taps)
    return None if stride is None else (stride, max(manifest.taps))


def _help(config: RobotConfig, manifest: NetworkConventions, steps: float) -> str:
    whole = round(steps)
    if (
        manifest.kind == "mlp"
        and config.framework is Framework.ISAACLAB
        and whole
        and abs(steps - whole) < 1e-6
    ):
        return f"input_idx={[whole * tap for tap in manifest.taps]}"
    return "train the network on samples of the physics step, or run it at the period of its log"


def _ms(seconds: float) -> str:
    return format_quantity(1000.0 * seconds, "ms", 3)


def _place(group: ActuatorGroup) -> Span:
    return group.network.span if group.network is not None else group.span
