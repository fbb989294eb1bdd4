import isaaclab.sim as sim_utils
from isaaclab.actuators import DCMotorCfg
from isaaclab.assets import ArticulationCfg

KP = 40.0

BIPED_CFG = ArticulationCfg(
    spawn=sim_utils.UsdFileCfg(usd_path="biped.usd"),
    init_state=ArticulationCfg.InitialStateCfg(joint_pos={".*_hip": 0.8, ".*_knee": -1.5}),
    actuators={
        "legs": DCMotorCfg(
            joint_names_expr=[".*_hip", ".*_knee"],
            effort_limit=24.0,
            saturation_effort=24.0,
            velocity_limit=20.0,
            stiffness=KP,
            damping=KP / 80,
            armature=0.01,
        ),
    },
)
