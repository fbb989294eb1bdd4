"""What people call things in deploy files, and what actspec calls them in its own."""

from __future__ import annotations

PER_JOINT = {
    "kp": (
        "kp",
        "kps",
        "stiffness",
        "p_gains",
        "kp_gains",
        "joint_kp",
        "joint_stiffness",
        "fixed_kp",
        "rl_kp",
    ),
    "kd": ("kd", "kds", "damping", "d_gains", "kd_gains", "joint_kd", "joint_damping", "fixed_kd", "rl_kd"),
    "effort_limit": (
        "effort_limit",
        "effort_limits",
        "torque_limit",
        "torque_limits",
        "tau_limit",
        "dof_effort_limit_list",
    ),
    "velocity_limit": ("velocity_limit", "velocity_limits", "dof_vel_limit_list"),
    "armature": ("armature", "dof_armature_list"),
    "frictionloss": ("friction_coulomb", "frictionloss", "dof_joint_friction_list"),
    "joint_damping": ("friction_viscous",),
    "default_position": (
        "default_position",
        "default_joint_pos",
        "default_joint_angles",
        "default_dof_pos",
        "default_angles",
        "default_pos",
    ),
    "action_scale": ("action_scale", "action_scales"),
}
"""Field to the keys that people use for it. Source: unitree_rl_gym, unitree_rl_lab, rl_sar, ASAP, OpenHomie deploy
files, and what actspec writes."""

TIMES = {
    "physics_dt": ("physics_dt", "simulation_dt", "sim_dt"),
    "control_dt": ("control_dt", "step_dt", "policy_dt"),
    "decimation": ("decimation", "control_decimation"),
}
"""Robot-wide setting to its keys."""

OWN_FORMAT = "actspec-deploy/"
"""What `format` begins with in a file that actspec wrote, whose other lists are known too."""

OWN_LISTS = {
    "command": ("command", ""),
    "position_low": ("position_lower", ""),
    "position_high": ("position_upper", ""),
    "command_low": ("command_range", "low"),
    "command_high": ("command_range", "high"),
    "delay": ("policy_delay", "nominal"),
    "delay_low": ("policy_delay", "low"),
    "delay_high": ("policy_delay", "high"),
}
"""Setting of a joint to the key of the list, and of the part of it."""

NAMES = (
    "joint_names",
    "dof_names",
    "joint_order",
    "policy_joint_names",
    "actuated_joint_names",
    "joint_controller_names",
    "joints",
)
"""Keys of the list that names the joints."""
