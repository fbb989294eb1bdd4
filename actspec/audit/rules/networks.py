"""NET: actuator networks in a configuration, without their manifest."""

from __future__ import annotations

import os
from collections.abc import Iterator

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.rule import Rule
from actspec.audit.rules.cfg_groups import groups_of
from actspec.audit.rules.joint_units import shown
from actspec.audit.rules.networks_found import is_network, networks, of_specs
from actspec.audit.rules.randomized import rows_in
from actspec.diagnostics import Severity
from actspec.readings.artifact import (
    ActuatorGroup,
    FileKind,
    Framework,
    RandomizedRange,
)
from actspec.readings.versions import release


class NetworkFileMissing(Rule):
    """The network that a configuration or spec names is not there.

    ## What it does
    Reports actuator networks whose file is a local path and is found neither as it is written, nor from the folder of
    the configuration or one above it, nor from the working folder; of a spec, from the spec's folder. Servers
    (`omniverse://`, a Nucleus folder) and paths with a part that is not known are not judged.

    ## Why it matters
    The task stops when the robot is made; with a path of somebody's home folder, on every machine but theirs.

    ## Example
    ```python robot_cfg.py
    from isaaclab.actuators import ActuatorNetLSTMCfg
    from isaaclab.assets.articulation import ArticulationCfg

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": ActuatorNetLSTMCfg(
                joint_names_expr=[".*"],
                network_file="/home/me/nets/leg.pt",
                saturation_effort=120.0,
                effort_limit=80.0,
                velocity_limit=7.5,
            )
        }
    )
    ```

    ## Use instead
    ```python robot_cfg.py
    from isaaclab.actuators import ActuatorNetLSTMCfg
    from isaaclab.assets.articulation import ArticulationCfg
    from isaaclab.utils.assets import ISAACLAB_NUCLEUS_DIR

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": ActuatorNetLSTMCfg(
                joint_names_expr=[".*"],
                network_file=f"{ISAACLAB_NUCLEUS_DIR}/ActuatorNets/leg.pt",
                saturation_effort=120.0,
                effort_limit=80.0,
                velocity_limit=7.5,
            )
        }
    )
    ```

    ## Limits
    From which folder training runs no file says: a relative path may be right on the machine that trains.

    ## Source
    Isaac Lab 2.3.2, actuator_net.py: the file is read when the actuator is made.
    """

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


class GainsRandomisedOnNetwork(Rule):
    """Gains are randomised of joints whose torque a network gives.

    ## What it does
    Reports ranges of kp and kd on joints whose group is an actuator network.

    ## Why it matters
    A network has no gains: Isaac Lab and mjlab change numbers that nothing reads, without a word. The policy meets
    none of the variation that it is thought to be robust against.

    ## Example
    ```python cfg.py
    import isaaclab.envs.mdp as mdp
    from isaaclab.actuators import ActuatorNetLSTMCfg
    from isaaclab.assets import ArticulationCfg
    from isaaclab.envs import ManagerBasedRLEnvCfg
    from isaaclab.managers import EventTermCfg, SceneEntityCfg
    from isaaclab.scene import InteractiveSceneCfg
    from isaaclab.utils import configclass
    from isaaclab.utils.assets import ISAACLAB_NUCLEUS_DIR


    @configclass
    class SceneCfg(InteractiveSceneCfg):
        robot = ArticulationCfg(
            actuators={
                "legs": ActuatorNetLSTMCfg(
                    joint_names_expr=[".*"],
                    network_file=f"{ISAACLAB_NUCLEUS_DIR}/ActuatorNets/leg.pt",
                    saturation_effort=120.0,
                    effort_limit=80.0,
                    velocity_limit=7.5,
                )
            }
        )


    @configclass
    class EventCfg:
        gains = EventTermCfg(
            func=mdp.randomize_actuator_gains,
            mode="reset",
            params={
                "asset_cfg": SceneEntityCfg("robot", joint_names=".*"),
                "stiffness_distribution_params": (0.8, 1.2),
                "operation": "scale",
            },
        )


    @configclass
    class DogEnvCfg(ManagerBasedRLEnvCfg):
        scene: SceneCfg = SceneCfg()
        events: EventCfg = EventCfg()
    ```

    ## Use instead
    ```python cfg.py
    import isaaclab.envs.mdp as mdp
    from isaaclab.actuators import DCMotorCfg
    from isaaclab.assets import ArticulationCfg
    from isaaclab.envs import ManagerBasedRLEnvCfg
    from isaaclab.managers import EventTermCfg, SceneEntityCfg
    from isaaclab.scene import InteractiveSceneCfg
    from isaaclab.utils import configclass


    @configclass
    class SceneCfg(InteractiveSceneCfg):
        robot = ArticulationCfg(
            actuators={
                "legs": DCMotorCfg(
                    joint_names_expr=[".*"],
                    stiffness=40.0,
                    damping=5.0,
                    saturation_effort=120.0,
                    effort_limit=80.0,
                    velocity_limit=7.5,
                )
            }
        )


    @configclass
    class EventCfg:
        gains = EventTermCfg(
            func=mdp.randomize_actuator_gains,
            mode="reset",
            params={
                "asset_cfg": SceneEntityCfg("robot", joint_names=".*"),
                "stiffness_distribution_params": (0.8, 1.2),
                "operation": "scale",
            },
        )


    @configclass
    class DogEnvCfg(ManagerBasedRLEnvCfg):
        scene: SceneCfg = SceneCfg()
        events: EventCfg = EventCfg()
    ```

    ## Source
    Isaac Lab 2.3.2, measured: the torque is the same with twice the stiffness. mjlab 1.6.0: `dr.pd_gains` accepts the
    class, and it does not use them. walk-these-ways: the network's torque takes `motor_strength` alone.
    """

    code = "NET105"
    name = "gains-randomised-on-a-network"
    severity = Severity.WARNING
    confidence = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Hold the ranges of gains against the groups."""
        looked = False
        for index, artifact in case.of_kind(FileKind.CFG):
            config = artifact.config
            ranges = (
                [one for one in config.randomize if one.field in ("kp", "kd")] if config is not None else []
            )
            if config is None or not config.groups or not ranges:
                continue
            looked = True
            for group in config.groups:
                for one in ranges if is_network(config, group) else ():
                    for joint in _joints(case, index, group, one):
                        yield Finding(
                            self.code,
                            f"this range of {one.field} does nothing: a network gives the joint's torque, and has no "
                            "gains",
                            one.span,
                            joint,
                            help="randomise the torque instead, or train the network on several gains",
                            related=(group.span,),
                        )
        if not looked:
            yield Skipped(self.code, "no configuration with actuator groups randomises gains")


def _joints(case: Case, index: int, group: ActuatorGroup, one: RandomizedRange) -> list[str]:
    """Joints of a group in a range; legged_gym's network drives them all."""
    rows = [row.joint for row in rows_in(case, index, one) if row.actuator == group.name]
    return rows or ([""] if group.joints is None and one.joints is None else [])


class NetworkWithoutSpeedClip(Rule):
    """Isaac Lab's LSTM network is not clipped by its torque-speed line.

    ## What it does
    Remarks groups of `ActuatorNetLSTMCfg` where an Isaac Lab 2.x is named.

    ## Why it matters
    The class clips the network's torque with the line of a DC motor, but never tells it the joint's speed: the line is
    taken at standstill. `effort_limit` is all that limits the torque; a network that asks for more than the motor has
    at speed gets it.

    ## Example
    ```sh
    actspec audit robot_cfg.py --target isaaclab==2.3.2
    ```
    ```python robot_cfg.py
    from isaaclab.actuators import ActuatorNetLSTMCfg
    from isaaclab.assets.articulation import ArticulationCfg
    from isaaclab.utils.assets import ISAACLAB_NUCLEUS_DIR

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": ActuatorNetLSTMCfg(
                joint_names_expr=[".*"],
                network_file=f"{ISAACLAB_NUCLEUS_DIR}/ActuatorNets/leg.pt",
                saturation_effort=120.0,
                effort_limit=80.0,
                velocity_limit=7.5,
            )
        }
    )
    ```

    ## Use instead
    ```python robot_cfg.py
    from isaaclab.actuators import ActuatorNetMLPCfg
    from isaaclab.assets.articulation import ArticulationCfg
    from isaaclab.utils.assets import ISAACLAB_NUCLEUS_DIR

    LEG_CFG = ArticulationCfg(
        actuators={
            "legs": ActuatorNetMLPCfg(
                joint_names_expr=[".*"],
                network_file=f"{ISAACLAB_NUCLEUS_DIR}/ActuatorNets/leg_mlp.pt",
                pos_scale=1.0,
                vel_scale=1.0,
                torque_scale=1.0,
                input_order="pos_vel",
                input_idx=[0, 1, 2],
                saturation_effort=120.0,
                effort_limit=80.0,
                velocity_limit=7.5,
            )
        }
    )
    ```

    ## Limits
    A network that learned the real torque keeps within the line by itself, where the log covered such speeds.

    ## Source
    Isaac Lab 2.2.0 and 2.3.2, actuator_net.py: `ActuatorNetLSTM.compute` does not store `joint_vel`. Measured: at
    10 rad/s with the figures above it gives 80 N*m, where the line has -40 N*m.
    """

    code = "NET106"
    name = "network-without-speed-clip"
    severity = Severity.INFO
    confidence = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find LSTM networks in Isaac Lab 2.x."""
        named = case.versions.isaaclab
        if named is None or not (2, 2) <= release(named)[:2] < (3,):
            yield Skipped(self.code, "no Isaac Lab 2.2 or 2.3 is named")
            return
        looked = False
        for group in groups_of(
            case, Framework.ISAACLAB, frozenset({"ActuatorNetLSTMCfg", "ActuatorNetMLPCfg"})
        ):
            looked = True
            for row in group.rows if group.cfg.cls == "ActuatorNetLSTMCfg" else ():
                limit, speed = row.effort_limit, row.no_load_speed
                if limit is not None and speed is not None:
                    yield Finding(
                        self.code,
                        f"Isaac Lab {named} takes this network's torque-speed line at standstill: it may give "
                        f"{shown(row, 'effort_limit', limit)} at {shown(row, 'no_load_speed', speed)}, where the line "
                        f"has {shown(row, 'effort_limit', 0.0)}",
                        group.cfg.span,
                        row.joint,
                        help="clip in a subclass, or check that the network's training log covers these speeds",
                    )
        if not looked:
            yield Skipped(self.code, "no network of Isaac Lab among the files")


RULES: tuple[type[Rule], ...] = (NetworkFileMissing, GainsRandomisedOnNetwork, NetworkWithoutSpeedClip)
