from __future__ import annotations

import os
from collections.abc import Iterable, Iterator

from actspec.audit.rule import Case, Confidence, Finding, RuleInParts, Severity
from actspec.audit.rules.networks_found import networks, of_specs
from actspec.readings.named_network import NetworkReading


class NetworkFileMissing(RuleInParts):
    code = "NET103"
    name = "network-file-missing"
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    needs = "no configuration or spec names the file of a network"

    def subjects(self, case: Case) -> Iterator[Iterable[Finding]]:
        """Look for the files."""
        for _, _, group in networks(case):
            if group.network is not None:
                yield self._of_group(group.network)
        for _, network in of_specs(case):
            yield self._of_spec(network)

    def _of_group(self, network: NetworkReading) -> Iterator[Finding]:
        if network.local and network.path is None:
            absolute = os.path.isabs(network.file)
            yield Finding(
                self.code,
                f"there is no network {network.file!r}"
                + (
                    " on this machine" if absolute else " beside this file, above it or in the working folder"
                ),
                network.span,
                help="name it relative to this file, as Path(__file__).parent / ..." if absolute else None,
                confidence=self.confidence if absolute else Confidence.LOW,
                # Weights are often kept beside a repository; whoever makes the robot without them is told at once.
                severity=None if absolute else Severity.INFO,
                about=network.file,
            )

    def _of_spec(self, network: NetworkReading) -> Iterator[Finding]:
        if network.path is None:
            yield Finding(
                self.code,
                f"there is no network {network.file!r}",
                network.span,
                help="name it relative to the spec",
                confidence=Confidence.HIGH,
                about=network.file,
            )
