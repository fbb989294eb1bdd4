"""The actuator classes of Isaac Lab and mjlab, and the fields that each takes.

Source: Isaac Lab 2.2.0 and 2.3.2, isaaclab/actuators/*_cfg.py; mjlab 1.0.0, 1.2.0, 1.3.0, 1.5.3 and 1.6.0,
mjlab/actuator/*.py.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class StockClass:
    """One class.

    Attributes:
        fields: All that it takes, the selection of its joints left out.
        required: Those without a default.
        mappable: Those that may be a value by joint pattern.
    """

    fields: frozenset[str]
    required: frozenset[str]
    mappable: frozenset[str]


LIMITS = frozenset(
    {
        "effort_limit",
        "velocity_limit",
        "effort_limit_sim",
        "velocity_limit_sim",
        "actuator_effort_limit",
        "actuator_velocity_limit",
        "joint_effort_limit",
        "joint_velocity_limit",
    }
)
"""Isaac Lab's limits in the names of 2.x and 3.0; which version has which is VER103's."""

_JOINT = frozenset({"stiffness", "damping", "armature", "friction", "dynamic_friction", "viscous_friction"})

_NET = frozenset({"network_file", "saturation_effort"})

_LINE = frozenset({"saturation_effort", "velocity_limit", "actuator_velocity_limit"})


def _isaac(extra: frozenset[str] = frozenset(), required: frozenset[str] = frozenset()) -> StockClass:
    fields = _JOINT | LIMITS | extra | {"class_type"}
    return StockClass(fields, required - _LINE, (_JOINT | LIMITS))


_PD = frozenset({"stiffness", "damping"})

_MLP = frozenset({"pos_scale", "vel_scale", "torque_scale", "input_order", "input_idx"})

ISAACLAB = {
    "ImplicitActuatorCfg": _isaac(required=_PD),
    "IdealPDActuatorCfg": _isaac(required=_PD),
    "DCMotorCfg": _isaac(frozenset({"saturation_effort"}), _PD),
    "DelayedPDActuatorCfg": _isaac(frozenset({"min_delay", "max_delay"}), _PD),
    "RemotizedPDActuatorCfg": _isaac(
        frozenset({"min_delay", "max_delay", "joint_parameter_lookup"}), _PD | {"joint_parameter_lookup"}
    ),
    "ActuatorNetLSTMCfg": _isaac(_NET, frozenset({"network_file"})),
    "ActuatorNetMLPCfg": _isaac(_NET | _MLP, _MLP | {"network_file"}),
}
"""Isaac Lab's classes; figures of the torque-speed line that are missing are LIM110's."""

COMMON = frozenset(
    {
        "viscous_damping",
        "delay_min_lag",
        "delay_max_lag",
        "delay_hold_prob",
        "delay_update_period",
        "delay_per_env_phase",
    }
)
"""Fields that every actuator of mjlab has from `simulators.mjlab.COMMON_FIELDS` on."""

_BASE = COMMON | {"transmission_type", "armature", "frictionloss"}

_NONE: frozenset[str] = frozenset()


def _mjlab(extra: frozenset[str], required: frozenset[str]) -> StockClass:
    # `base_cfg` is the reader's: mjlab 1.0 to 1.2 wrapped an actuator to delay it.
    return StockClass(_BASE | extra | {"base_cfg", "delay_target"}, required - _LINE, _NONE)


_DC = frozenset(
    {
        "motor_params",
        "mode",
        "stiffness",
        "damping",
        "voltage_limit",
        "integral_gain",
        "integral_limit",
        "slew_rate",
        "effort_limit",
        "gear",
        "inductance",
        "electrical_time_constant",
        "thermal",
        "cogging",
        "lugre",
    }
)

_MUSCLE = frozenset(
    {
        "length_range",
        "gear",
        "timeconst",
        "tausmooth",
        "range",
        "force",
        "scale",
        "lmin",
        "lmax",
        "vmax",
        "fpmax",
        "fvmax",
    }
)

_SCALES = frozenset({"pos_scale", "vel_scale", "torque_scale"})

MJLAB = {
    "BuiltinPositionActuatorCfg": _mjlab(_PD | {"effort_limit"}, _PD),
    "BuiltinPdActuatorCfg": _mjlab(_PD | {"effort_limit"}, _PD),
    "BuiltinVelocityActuatorCfg": _mjlab(frozenset({"damping", "effort_limit"}), frozenset({"damping"})),
    "BuiltinMotorActuatorCfg": _mjlab(frozenset({"effort_limit", "gear"}), frozenset({"effort_limit"})),
    "BuiltinDcMotorActuatorCfg": _mjlab(_DC, frozenset({"motor_params"})),
    "BuiltinMuscleActuatorCfg": _mjlab(_MUSCLE, _NONE),
    "IdealPdActuatorCfg": _mjlab(_PD | {"effort_limit"}, _PD),
    "DcMotorActuatorCfg": _mjlab(_PD | {"effort_limit", "saturation_effort", "velocity_limit"}, _PD),
    "LearnedMlpActuatorCfg": _mjlab(
        _PD
        | _SCALES
        | {
            "effort_limit",
            "saturation_effort",
            "velocity_limit",
            "network_file",
            "input_order",
            "history_length",
        },
        _SCALES | {"network_file"},
    ),
    "XmlActuatorCfg": _mjlab(frozenset({"command_field"}), _NONE),
}
"""mjlab's classes, the fields of all its versions together."""
