"""Networks that a configuration or a spec names: whether their file is here, and what their manifest says."""

from __future__ import annotations

import json
import math
import os
from dataclasses import replace
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, Span, SpecError
from actspec.files import NotRegular, TooLarge, read_regular
from actspec.ir import ActuatorSet, Network
from actspec.readings.artifact import ActuatorGroup, Framework, RobotConfig
from actspec.readings.named_network import NetworkConventions, NetworkReading

if TYPE_CHECKING:
    from actspec.spec.network import NetworkManifest

SETTINGS = ("network_file", "actuator_net_file")
"""Settings that name a network: of Isaac Lab and mjlab, and of legged_gym."""

MAX_MANIFEST = 1024 * 1024
"""Largest manifest [bytes]. Chosen: one has some hundred."""

MAX_LEVELS = 12
"""Folders above the configuration in which a relative path is looked for. Chosen: deeper than any repository."""

MJLAB_HISTORY = 3
"""mjlab's default `history_length`. Source: mjlab 1.6.0, actuator/learned_actuator.py."""

_MARK = b"actspec-network/"
_SCALES = {"pos_scale": "position_scale", "vel_scale": "velocity_scale", "torque_scale": "torque_scale"}
_ORDERS = {"pos_vel": "position_velocity", "vel_pos": "velocity_position"}
"""Words of Isaac Lab and mjlab to those of a manifest."""


def with_networks(config: RobotConfig) -> RobotConfig:
    """The configuration with what is known of its networks; network files are never opened."""
    if not any(name in group.settings for group in config.groups for name in SETTINGS):
        return config
    return replace(config, groups=tuple(replace(group, network=_network(group)) for group in config.groups))


def _network(group: ActuatorGroup) -> NetworkReading | None:
    setting = next((group.settings[name] for name in SETTINGS if name in group.settings), None)
    if setting is None or not isinstance(setting.value, str):
        return None
    file = setting.value
    if not file or "{" in file or "://" in file or "\0" in file:
        return NetworkReading(file, setting.span, local=False)
    folder = os.path.dirname(setting.span.path)
    # Networks are often left out of a repository, their manifests are not.
    beside = _find(f"{os.path.splitext(file)[0]}.json", folder)
    manifest, problem = (None, None) if beside is None else _manifest(beside)
    return NetworkReading(file, setting.span, True, _find(file, folder), manifest, problem)


def tap_steps(framework: Framework, group: ActuatorGroup) -> tuple[int, ...] | None:
    """Physics steps back of each tap of an MLP, as the class takes them; None: not known."""
    if framework is Framework.MJLAB:
        setting = group.settings.get("history_length")
        length = MJLAB_HISTORY if setting is None else setting.value
        return tuple(range(length)) if isinstance(length, int) and 0 < length <= 1000 else None
    setting = group.settings.get("input_idx")
    value = setting.value if setting is not None else None
    if not isinstance(value, tuple) or not value:
        return None
    whole = tuple(one for one in value if isinstance(one, int) and not isinstance(one, bool))
    return whole if len(whole) == len(value) else None


def stated_manifest(
    framework: Framework, group: ActuatorGroup, step: float | None
) -> tuple[str, tuple[str, ...]]:
    """The manifest of a group's network as far as its class and settings state it, as JSON, and the keys that lack.

    The period of the samples is the physics step, which both frameworks count taps in.

    Args:
        framework: Isaac Lab or mjlab; no other states anything of a network.
        group: The group.
        step: The simulation's step [s]; None: nobody states it.

    Returns:
        "" where nothing is stated.

    Source: Isaac Lab 2.3.2, actuator_net.py: an LSTM gets error and velocity of this step, unscaled; an MLP's history
    is 0 after a reset. mjlab 1.6.0, learned_actuator.py: it is the first sample.
    """
    kinds = "".join((group.cls, *group.bases)).lower()
    if framework not in (Framework.ISAACLAB, Framework.MJLAB) or ("mlp" in kinds) == ("lstm" in kinds):
        return "", ()
    order: object = "pos_vel"
    taps: tuple[int, ...] | None = (0,)
    scales: dict[str, float | None] = dict.fromkeys(_SCALES.values(), 1.0)
    if "mlp" in kinds:
        given = {name: group.settings[name] for name in (*_SCALES, "input_order") if name in group.settings}
        numbers = {key: given[name].number if name in given else None for name, key in _SCALES.items()}
        scales = {key: n if n is not None and math.isfinite(n) else None for key, n in numbers.items()}
        order = given["input_order"].value if "input_order" in given else None
        taps = tap_steps(framework, group)
    stated = {
        "format": f"{_MARK.decode()}1",
        "kind": "mlp" if "mlp" in kinds else "lstm",
        "inputs": _ORDERS.get(order) if isinstance(order, str) else None,
        "taps": taps,
        "tap_period": "unknown" if step is None else f"{step * 1e3:.12g} ms",
        **{key: scale if scale is None or scale % 1.0 else int(scale) for key, scale in scales.items()},
        "initial_history": "first_sample" if framework is Framework.MJLAB else "zero",
    }
    lacking = tuple(key for key, value in stated.items() if value is None)
    return json.dumps({key: value for key, value in stated.items() if value is not None}), lacking


def networks_of(spec: ActuatorSet) -> tuple[NetworkReading, ...]:
    """The networks of a spec, each once, with their manifests; network files are never opened."""
    found: dict[Network, NetworkReading] = {}
    for actuator in spec.joints:
        network = actuator.network
        if network is None or network in found:
            continue
        paths = [path for path in network_paths(network).values() if os.path.isfile(path)]
        manifest = network.manifest or f"{os.path.splitext(network.file or '')[0]}.json"
        said, problem = _manifest(manifest) if os.path.isfile(manifest) else (None, None)
        file = network.file or manifest
        span = network.span or actuator.span or Span(file)
        found[network] = NetworkReading(file, span, True, next(iter(paths), None), said, problem)
    return tuple(found.values())


def network_paths(network: Network) -> dict[str, str]:
    """Paths of a network's files by format: `file` where a spec names it, else those of its manifest.

    A manifest that cannot be read names none: whoever needs a file says why.
    """
    if network.file is not None:
        return {"file": network.file}
    assert network.manifest is not None
    manifest, _ = _checked(network.manifest)
    if manifest is None or manifest.files is None:
        return {}
    folder = os.path.dirname(network.manifest)
    named = {"onnx": manifest.files.onnx, "torchscript": manifest.files.torchscript}
    return {form: os.path.join(folder, entry.path) for form, entry in named.items() if entry is not None}


def _find(file: str, folder: str) -> str | None:
    """The file as training code may find it: absolute, or from a folder at or above the configuration."""
    if os.path.isabs(file):
        return file if os.path.isfile(file) else None
    folders = [folder]
    above = os.path.abspath(folder)
    while len(folders) < MAX_LEVELS and os.path.dirname(above) != above:
        above = os.path.dirname(above)
        folders.append(above)
    for place in (*folders, ""):
        if os.path.isfile(os.path.join(place, file)):
            return os.path.join(place, file)
    return None


def _manifest(path: str) -> tuple[NetworkConventions | None, str | None]:
    """The manifest beside a network, or why it cannot be read; neither when there is none."""
    found, problem = _checked(path)
    if found is None:
        return None, problem
    return (
        NetworkConventions(
            path,
            found.kind,
            found.inputs == "velocity_position",
            found.taps,
            found.tap_period.value,
            found.position_scale,
            found.velocity_scale,
            found.torque_scale,
        ),
        None,
    )


def _checked(path: str) -> tuple[NetworkManifest | None, str | None]:
    """A file as a manifest, or what is wrong with it; neither where it is no manifest."""
    try:
        if _MARK not in read_regular(path, MAX_MANIFEST):
            return None, None
    except (OSError, ValueError, NotRegular, TooLarge):
        return None, None
    # Few configurations have one, and the models take time to build.
    from actspec.spec.document import load_document
    from actspec.spec.network import NetworkManifest
    from actspec.spec.validate import checked

    collector = Collector()
    try:
        found = checked(NetworkManifest, load_document(path), collector)
    except SpecError as err:
        return None, err.diagnostics[0].message
    if found is None:
        first = next(iter(collector.sorted()))
        return None, f"{first.where}: {first.message}"
    return found, None
