"""Small robots for tests of what compares files."""

from __future__ import annotations

LEG = """<mujoco model="leg">
  <option timestep="0.002" integrator="implicitfast"/>
  <worldbody>
    <body>
      <joint name="hip" range="-1 1" limited="true" damping="1" armature="0.01"/>
      <geom size="0.1"/>
      <body pos="0 0 -0.2">
        <joint name="knee" range="-1 1" limited="true" damping="1" armature="0.01"/>
        <geom size="0.1"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position name="hip" joint="hip" kp="100" kv="3" forcerange="-30 30" forcelimited="true"/>
    <position name="knee" joint="knee" kp="100" kv="3" forcerange="-30 30" forcelimited="true"/>
  </actuator>
</mujoco>
"""
"""Two joints alike: kp 100, kd 3 and damping 1, which are 4 together."""

SPEC = """actspec: 1
robot: {name: leg, model: leg.xml}
timing: {physics_dt: 2 ms, decimation: 10}
actuators:
  legs:
    joints: [".*"]
    level: ideal_pd
    kp: 100 N*m/rad
    kd: 3 N*m*s/rad
    effort_limit: 30 N*m
    armature: 0.01 kg*m^2
    friction: {viscous: 1 N*m*s/rad}
"""
"""The spec that `LEG` is right for."""

CFG = """from isaaclab.actuators import IdealPDActuatorCfg
from isaaclab.assets import ArticulationCfg

LEG_CFG = ArticulationCfg(
    actuators={
        "legs": IdealPDActuatorCfg(
            joint_names_expr=["hip", "knee"],
            effort_limit=30.0,
            stiffness=100.0,
            damping=3.0,
            friction=0.2,
        )
    }
)
"""
"""The same drives for Isaac Lab."""
