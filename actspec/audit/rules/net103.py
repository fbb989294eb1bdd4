from __future__ import annotations

import os
from collections.abc import Iterator

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.rule import Rule
from actspec.audit.rules.networks_found import networks, of_specs
from actspec.diagnostics import Severity


class NetworkFileMissing(Rule):
    code = "NET103"
    name = "network-file-missing"
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Look for the files."""
        looked = False
        for _, _, group in networks(case):
            network = group.network
            looked = looked or network is not None
            if network is not None and network.local and network.path is None:
                absolute = os.path.isabs(network.file)
                yield Finding(
                    self.code,
                    f"there is no network {network.file!r}"
                    + (
                        " on this machine"
                        if absolute
                        else " beside this file, above it or in the working folder"
                    ),
                    network.span,
                    help="name it relative to this file, as Path(__file__).parent / ..."
                    if absolute
                    else None,
                    confidence=self.confidence if absolute else Confidence.LOW,
                )
        for _, network in of_specs(case):
            looked = True
            if network.path is None:
                yield Finding(
                    self.code,
                    f"there is no network {network.file!r}",
                    network.span,
                    help="name it relative to the spec",
                    confidence=Confidence.HIGH,
                )
        if not looked:
            yield Skipped(self.code, "no configuration or spec names the file of a network")
