"""NET: actuator networks in a configuration against what their manifest says."""

from __future__ import annotations

import math
from collections.abc import Iterator
from os.path import basename

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.rule import Rule
from actspec.audit.rules.networks_found import SAME, conventions, networks, of_specs
from actspec.diagnostics import Severity, Span
from actspec.readings.artifact import (
    ActuatorGroup,
    Framework,
    NetworkConventions,
    NetworkReading,
    RobotConfig,
)
from actspec.units import format_quantity

MJLAB_HISTORY = 3
"""mjlab's default `history_length`. Source: mjlab 1.6.0, actuator/learned_actuator.py."""


class HistoryPeriod(Rule):
    """A network's history has another period in the simulation than it had in training.

    ## What it does
    Compares how far back the network looks by its manifest (taps times `tap_period`) with how far back the
    configuration lets it look (`input_idx` or `history_length` times the physics step). The manifest is the
    `actspec-network/1` file that lies beside the network, `leg.json` beside `leg.pt`, or that the robot's spec names
    for a network of that name. For a network in a spec, reports a period that is no whole number of physics steps.

    ## Why it matters
    The classes feed a network once a physics step. One that was trained on samples 20 ms apart and gets samples 5 ms
    apart acts on a robot that is four times as fast: a delay of one sample that it learned is 5 ms, not 20 ms.

    ## Example
    ```json leg.json
    {"format": "actspec-network/1", "kind": "mlp", "inputs": "position_velocity", "taps": [0, 1, 2],
     "tap_period": "20 ms", "position_scale": -1.0, "velocity_scale": 1.0, "torque_scale": 1.0,
     "initial_history": "zero"}
    ```
    ```python cfg.py
    from isaaclab.actuators import ActuatorNetMLPCfg
    from isaaclab.assets import ArticulationCfg
    from isaaclab.envs import DirectRLEnvCfg
    from isaaclab.sim import SimulationCfg
    from isaaclab.utils import configclass


    @configclass
    class DogEnvCfg(DirectRLEnvCfg):
        sim: SimulationCfg = SimulationCfg(dt=0.005)
        robot_cfg: ArticulationCfg = ArticulationCfg(
            actuators={
                "legs": ActuatorNetMLPCfg(
                    joint_names_expr=[".*"],
                    network_file="leg.pt",
                    pos_scale=-1.0,
                    vel_scale=1.0,
                    torque_scale=1.0,
                    input_order="pos_vel",
                    input_idx=[0, 1, 2],
                    saturation_effort=23.7,
                    effort_limit=23.7,
                    velocity_limit=30.0,
                )
            }
        )
    ```

    ## Use instead
    ```python cfg.py
    from isaaclab.actuators import ActuatorNetMLPCfg
    from isaaclab.assets import ArticulationCfg
    from isaaclab.envs import DirectRLEnvCfg
    from isaaclab.sim import SimulationCfg
    from isaaclab.utils import configclass


    @configclass
    class DogEnvCfg(DirectRLEnvCfg):
        sim: SimulationCfg = SimulationCfg(dt=0.005)
        robot_cfg: ArticulationCfg = ArticulationCfg(
            actuators={
                "legs": ActuatorNetMLPCfg(
                    joint_names_expr=[".*"],
                    network_file="leg.pt",
                    pos_scale=-1.0,
                    vel_scale=1.0,
                    torque_scale=1.0,
                    input_order="pos_vel",
                    input_idx=[0, 4, 8],
                    saturation_effort=23.7,
                    effort_limit=23.7,
                    velocity_limit=30.0,
                )
            }
        )
    ```

    ## Limits
    Without a manifest nobody can tell: the file of a network has no period.

    ## Source
    Isaac Lab 2.3.2, actuator_net.py, and mjlab 1.6.0, measured: one sample a physics step. Case: the network of
    Improbable-AI/walk-these-ways, logged every 20 ms, run every 5 ms; it acts on the previous sample.
    """

    code = "NET101"
    name = "network-history-period"
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    paired = True

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Compare how far back the taps reach."""
        looked = False
        for index, config, group in networks(case):
            manifest = conventions(case, index, group)
            step = _step(case, index, config)
            if manifest is None or manifest.tap_period is None or step is None:
                continue
            looked = True
            period, (dt, place) = manifest.tap_period, step
            reach = _stride(config, group, manifest)
            if reach is None:
                continue
            stride, last = reach
            if math.isclose(stride * dt, period, rel_tol=SAME):
                continue
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
        for artifact, network in of_specs(case):
            own = artifact.spec.physics_dt if artifact.spec is not None else None
            manifest = network.manifest
            if own is None or not own.value or manifest is None or manifest.tap_period is None:
                continue
            looked = True
            yield from self._between_steps(network.span, manifest, manifest.tap_period, own.value, own.span)
        if not looked:
            yield Skipped(self.code, "no network with a manifest, a tap period and a physics step")

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


def _indices(config: RobotConfig, group: ActuatorGroup) -> tuple[int, ...] | None:
    """Physics steps back of each tap, as the class takes them; None: not known."""
    if config.framework is Framework.MJLAB:
        setting = group.settings.get("history_length")
        length = MJLAB_HISTORY if setting is None else setting.value
        return tuple(range(length)) if isinstance(length, int) and 0 < length <= 1000 else None
    setting = group.settings.get("input_idx")
    value = setting.value if setting is not None else None
    if isinstance(value, tuple) and value:
        return tuple(one for one in value if isinstance(one, int)) if _whole(value) else None
    return None


def _whole(values: tuple[object, ...]) -> bool:
    return all(isinstance(one, int) and not isinstance(one, bool) for one in values)


def _stride(
    config: RobotConfig, group: ActuatorGroup, manifest: NetworkConventions
) -> tuple[float, int] | None:
    """Physics steps between two samples, and the last sample; None where the taps do not fit or do not matter."""
    if manifest.kind != "mlp":
        return 1.0, 1
    indices = _indices(config, group)
    if indices is None or not any(manifest.taps):
        return None
    stride = _factor(indices, manifest.taps)
    return None if stride is None else (stride, max(manifest.taps))


def _factor(indices: tuple[int, ...], taps: tuple[int, ...]) -> float | None:
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


class NetworkInputs(Rule):
    """A network is fed other inputs than it was trained on.

    ## What it does
    Compares class, `input_order` and `input_idx` (mjlab: `history_length`) with the manifest beside the network: kind,
    order of the blocks, number and order of the samples. A manifest that cannot be read is reported too.

    ## Why it matters
    The numbers of inputs agree, so nothing complains; the network takes speeds for errors, or the oldest sample for the
    newest, and gives torques that look like torques.

    ## Example
    ```json leg.json
    {"format": "actspec-network/1", "kind": "mlp", "inputs": "position_velocity", "taps": [0, 1, 2],
     "tap_period": "5 ms", "position_scale": 1.0, "velocity_scale": 1.0, "torque_scale": 1.0,
     "initial_history": "zero"}
    ```
    ```python cfg.py
    from isaaclab.actuators import ActuatorNetMLPCfg
    from isaaclab.assets import ArticulationCfg

    DOG_CFG = ArticulationCfg(
        actuators={
            "legs": ActuatorNetMLPCfg(
                joint_names_expr=[".*"],
                network_file="leg.pt",
                pos_scale=1.0,
                vel_scale=1.0,
                torque_scale=1.0,
                input_order="pos_vel",
                input_idx=[2, 1, 0],
                saturation_effort=23.7,
                effort_limit=23.7,
                velocity_limit=30.0,
            )
        }
    )
    ```

    ## Use instead
    ```python cfg.py
    from isaaclab.actuators import ActuatorNetMLPCfg
    from isaaclab.assets import ArticulationCfg

    DOG_CFG = ArticulationCfg(
        actuators={
            "legs": ActuatorNetMLPCfg(
                joint_names_expr=[".*"],
                network_file="leg.pt",
                pos_scale=1.0,
                vel_scale=1.0,
                torque_scale=1.0,
                input_order="pos_vel",
                input_idx=[0, 1, 2],
                saturation_effort=23.7,
                effort_limit=23.7,
                velocity_limit=30.0,
            )
        }
    )
    ```

    ## Limits
    Samples that are further apart, in the same order, are NET101's.

    ## Source
    Isaac Lab 2.3.2, measured: `input_idx=[2, 1, 0]` feeds the oldest sample first.
    """

    code = "NET104"
    name = "network-inputs-against-manifest"
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    paired = True

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Compare inputs."""
        looked = False
        for _, named in of_specs(case):
            looked = looked or named.manifest is not None or named.problem is not None
            if named.problem is not None:
                yield self._unreadable(named)
        for index, config, group in networks(case):
            network, manifest = group.network, conventions(case, index, group)
            if network is None or (manifest is None and network.problem is None):
                continue
            looked = True
            if manifest is None:
                yield self._unreadable(network)
                continue
            for told, name in _differences(config, group, manifest):
                setting = group.settings.get(name)
                yield Finding(
                    self.code,
                    f"{told} ({basename(manifest.path)})",
                    setting.span if setting is not None else network.span,
                    related=(Span(manifest.path),),
                )
        if not looked:
            yield Skipped(self.code, "no network with a manifest beside it")

    def _unreadable(self, network: NetworkReading) -> Finding:
        return Finding(
            self.code,
            f"the network's manifest cannot be read: {network.problem}",
            network.span,
            severity=Severity.WARNING,
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
    indices = _indices(config, group)
    if indices is None or _factor(indices, manifest.taps) is not None:
        return
    name = "history_length" if config.framework is Framework.MJLAB else "input_idx"
    yield f"{name} feeds samples {list(indices)}, and the network was trained on {list(manifest.taps)}", name


RULES: tuple[type[Rule], ...] = (HistoryPeriod, NetworkInputs)
