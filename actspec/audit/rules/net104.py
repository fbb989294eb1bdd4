from __future__ import annotations

from collections.abc import Iterable, Iterator
from os.path import basename

from actspec.audit.rule import Case, Confidence, Finding, RuleInParts, Severity
from actspec.audit.rules.networks_found import (
    conventions,
    networks,
    of_specs,
    tap_factor,
)
from actspec.diagnostics import Span
from actspec.readings.artifact import ActuatorGroup, Framework, RobotConfig
from actspec.readings.named_network import NetworkConventions, NetworkReading
from actspec.readings.networks import tap_steps


class NetworkInputs(RuleInParts):
    code = "NET104"
    name = "network-inputs-against-manifest"
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    paired = True
    needs = "no network with a manifest beside it"

    def subjects(self, case: Case) -> Iterator[Iterable[Finding]]:
        """Compare inputs."""
        for _, named in of_specs(case):
            if named.problem is not None:
                yield (self._unreadable(named),)
            elif named.manifest is not None:
                yield ()
        for index, config, group in networks(case):
            network, manifest = group.network, conventions(case, index, group)
            if network is None or (manifest is None and network.problem is None):
                continue
            if manifest is None:
                yield (self._unreadable(network),)
            else:
                yield self._departures(config, group, network, manifest)

    def _departures(
        self, config: RobotConfig, group: ActuatorGroup, network: NetworkReading, manifest: NetworkConventions
    ) -> Iterator[Finding]:
        for text, name in _differences(config, group, manifest):
            setting = group.settings.get(name)
            yield Finding(
                self.code,
                f"{text} ({basename(manifest.path)})",
                setting.span if setting is not None else network.span,
                related=(Span(manifest.path),),
                about=name,
            )

    def _unreadable(self, network: NetworkReading) -> Finding:
        return Finding(
            self.code,
            f"the network's manifest cannot be read: {network.problem}",
            network.span,
            severity=Severity.WARNING,
            about="manifest",
        )


def _differences(
    config: RobotConfig, group: ActuatorGroup, manifest: NetworkConventions
) -> Iterator[tuple[str, str]]:
    """What is fed otherwise than the network learned, and the setting that does it."""
    recurrent = "lstm" in group.cls.lower() or "gru" in group.cls.lower()
    if recurrent != (manifest.kind != "mlp"):
        yield f"{group.cls} is not for the network's kind, which is {manifest.kind}", "network_file"
        return
    if recurrent:
        return
    order = group.settings.get("input_order")
    if order is not None and order.value in ("pos_vel", "vel_pos"):
        wanted = "vel_pos" if manifest.velocity_first else "pos_vel"
        if order.value != wanted:
            yield f"input_order is {order.value}, and the network was trained on {wanted}", "input_order"
    indices = tap_steps(config.framework, group)
    if indices is None or tap_factor(indices, manifest.taps) is not None:
        return
    name = "history_length" if config.framework is Framework.MJLAB else "input_idx"
    yield f"{name} feeds samples {list(indices)}, and the network was trained on {list(manifest.taps)}", name
