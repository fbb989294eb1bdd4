"""The networks of configurations and specs, and what is known of their training."""

from __future__ import annotations

import os
from collections.abc import Iterator

from actspec.audit.case import Case
from actspec.readings.artifact import ActuatorGroup, Artifact, FileKind, RobotConfig
from actspec.readings.config import is_network
from actspec.readings.named_network import NetworkConventions, NetworkReading

SAME = 0.01
"""Relative difference up to which two periods or scales are one. Chosen: rounding of written figures."""


def networks(case: Case) -> Iterator[tuple[int, RobotConfig, ActuatorGroup]]:
    """Groups with a network: artifact, configuration, group."""
    for index, artifact in case.of_kind(FileKind.CFG):
        if artifact.config is not None:
            for group in artifact.config.groups:
                if is_network(artifact.config.framework, group):
                    yield index, artifact.config, group


def of_specs(case: Case) -> Iterator[tuple[Artifact, NetworkReading]]:
    """Networks that specs name, with the spec."""
    for _, artifact in case.of_kind(FileKind.SPEC):
        for network in artifact.networks:
            yield artifact, network


def conventions(case: Case, index: int, group: ActuatorGroup) -> NetworkConventions | None:
    """What is known of how a group's network was trained: from the manifest beside it, else from the robot's spec.

    Args:
        case: The case.
        index: Of the group's artifact.
        group: The group.
    """
    if group.network is None or group.network.manifest is not None:
        return group.network.manifest if group.network is not None else None
    name = os.path.basename(group.network.file)
    found = {
        network.manifest
        for other in case.robot_of(index).artifacts
        for network in case.artifacts[other].networks
        if os.path.basename(network.file) == name and network.manifest is not None
    }
    return found.pop() if len(found) == 1 else None


def tap_factor(indices: tuple[int, ...], taps: tuple[int, ...]) -> float | None:
    """The one number that takes all taps to the indices; None when there is none. Any does for taps of 0."""
    if len(indices) != len(taps):
        return None
    last = max(taps)
    factor = max(indices) / last if last else 1.0
    return (
        factor
        if factor > 0.0 and all(i == factor * tap for i, tap in zip(indices, taps, strict=True))
        else None
    )
