"""Specs and model for the Playground function, with what is asked of every number, by hand."""

from __future__ import annotations

MODEL = """<mujoco model="leg">
  <option solver="CG"/>
  <worldbody>
    <body>
      <joint name="base" type="ball"/>
      <inertial pos="0 0 0" mass="5" diaginertia="0.3 0.3 0.3"/>
      <body pos="0.1 0 0">
        <inertial pos="0 0 -0.1" mass="1" diaginertia="0.1 0.1 0.1"/>
        <joint name="rest" axis="0 1 0" armature="0.03" frictionloss="0.6" damping="0.15"/>
      </body>
      <body pos="0.2 0 0">
        <inertial pos="0 0 -0.1" mass="1" diaginertia="0.1 0.1 0.1"/>
        <joint name="hip" axis="0 1 0" armature="0.01" frictionloss="0.2" damping="0.05"/>
      </body>
      <body pos="0.3 0 0">
        <inertial pos="0 0 -0.1" mass="1" diaginertia="0.1 0.1 0.1"/>
        <joint name="it's &quot;odd&quot;" axis="0 1 0" armature="0.01" frictionloss="0.2" damping="0.05"/>
      </body>
      <body pos="0.4 0 0">
        <inertial pos="0 0 -0.1" mass="1" diaginertia="0.1 0.1 0.1"/>
        <joint name="knee" axis="0 1 0" armature="0.02" frictionloss="0.4" damping="0.1"/>
      </body>
      <body pos="0.5 0 0">
        <inertial pos="0 0 -0.1" mass="1" diaginertia="0.1 0.1 0.1"/>
        <joint name="toe" axis="0 1 0" armature="0.02" frictionloss="0.3" damping="0.2" actuatorfrcrange="-9 8"/>
      </body>
    </body>
  </worldbody>
  <tendon>
    <fixed name="one"><joint joint="rest" coef="1"/></fixed>
    <fixed name="two"><joint joint="rest" coef="1"/></fixed>
    <fixed name="three"><joint joint="rest" coef="1"/></fixed>
  </tendon>
  <actuator><motor name="pull" tendon="three" gear="0.5"/></actuator>
</mujoco>
"""
"""A joint's number is neither that of its degree of freedom nor of its actuator; the tendon's is the hip's.

The solver is the one that takes JAX the least to compile.
"""

JOINTS = ("rest", "hip", 'it\'s "odd"', "knee", "toe")
HIPS = JOINTS[1:3]

GROUPS = """  rest:
    joints: [rest]
    level: ideal_pd
    kp: 50 N*m/rad
    kd: 2 N*m*s/rad
    effort_limit: 40 N*m
  hips:
    joints: [hip, "it's.*"]
    level: ideal_pd
    kp: 20 N*m/rad
    kd: 0.5 N*m*s/rad
    effort_limit: 30 N*m
    armature: 0.01 kg*m^2
    friction: {coulomb: 0.2 N*m, viscous: 0.05 N*m*s/rad}
    encoder_bias: 0.01 rad
    randomize: {%(hips)s}
  knees:
    joints: [knee]
    level: ideal_pd
    command: velocity
    kd: 1 N*m*s/rad
    effort_limit: 25 N*m
    armature: 0.02 kg*m^2
    friction: {coulomb: 0.4 N*m, viscous: 0.1 N*m*s/rad}
    randomize: {%(knees)s}
  toes:
    joints: [toe]
    level: ideal_pd
    command: effort
    effort_limit: 8 N*m
    friction: {coulomb: 0.3 N*m, viscous: 0.2 N*m*s/rad}
    randomize: {%(toes)s}
"""

FIELDS = {
    "hips": "kp: {scale: [0.5, 1.5]}, armature: {scale: [0.5, 2], distribution: log_uniform}, "
    "friction.coulomb: {abs: [0.2, 0.01], distribution: gaussian}, encoder_bias: {add: [-0.02 rad, 0.04 rad]}",
    "knees": "kd: {add: [-0.5, 1]}, effort_limit: {abs: [10, 25]}, friction.viscous: {scale: [0, 2]}",
    "toes": "effort_limit: {scale: [0.5, 1.5]}, armature: {abs: [0.01, 0.04]}",
}
"""Every field, operation and distribution, each joint on its own."""

STRENGTH = "strength: {scale: [0.5, 1], per: env}"
FACTORS = {
    "hips": f"gains: {{scale: [0.8, 1.2], per: group}}, friction.viscous: {{scale: [0, 2], per: group}}, {STRENGTH}",
    "knees": STRENGTH,
    "toes": STRENGTH,
}
"""Factors on several numbers, and draws that joints share."""

MOTORS = """  legs:
    joints: [hip, "it's.*", knee]
    motor: line
    level: dc_motor
    kp: 25 N*m/rad
    kd: 0.5 N*m*s/rad
    effort_limit: 20 N*m
    randomize:
      kp: {scale: [0.5, 2]}
      kd: {scale: [0.2, 3]}
      strength: {scale: [0.5, 1.5], per: env}
"""
"""In the voltage dialect kd = 0.5 is a negative controller gain: a factor on it would be wrong."""

NOMINAL: dict[str, dict[str, float]] = {
    "rest": {
        "kp": 50.0,
        "kd": 2.0,
        "limit": 40.0,
        "armature": 0.03,
        "coulomb": 0.6,
        "viscous": 0.15,
        "bias": 0.0,
    },
    **{
        hip: {
            "kp": 20.0,
            "kd": 0.5,
            "limit": 30.0,
            "armature": 0.01,
            "coulomb": 0.2,
            "viscous": 0.05,
            "bias": 0.01,
        }
        for hip in HIPS
    },
    "knee": {"kd": 1.0, "limit": 25.0, "armature": 0.02, "coulomb": 0.4, "viscous": 0.1},
    "toe": {"limit": 8.0, "armature": 0.02, "coulomb": 0.3, "viscous": 0.2},
}
"""What MODEL and GROUPS state: the value of what is not drawn."""

ASKED: dict[str, dict[tuple[str, str], tuple[str, float, float]]] = {
    "fields": {
        # 20 · 0.5 to 20 · 1.5; 0.01 · 0.5 to 0.01 · 2; mean and deviation; 0.01 − 0.02 to 0.01 + 0.04.
        **{(hip, "kp"): ("uniform", 10.0, 30.0) for hip in HIPS},
        **{(hip, "armature"): ("log_uniform", 0.005, 0.02) for hip in HIPS},
        **{(hip, "coulomb"): ("gaussian", 0.2, 0.01) for hip in HIPS},
        **{(hip, "bias"): ("uniform", -0.01, 0.05) for hip in HIPS},
        ("knee", "kd"): ("uniform", 0.5, 2.0),
        ("knee", "limit"): ("uniform", 10.0, 25.0),
        ("knee", "viscous"): ("uniform", 0.0, 0.2),
        ("toe", "limit"): ("uniform", 4.0, 12.0),
        ("toe", "armature"): ("uniform", 0.01, 0.04),
    },
    "factors": {
        # A strength from 0.5 to 1 on each limit; the gains are tested as ratios.
        **{(hip, "limit"): ("uniform", 15.0, 30.0) for hip in HIPS},
        **{(hip, "viscous"): ("uniform", 0.0, 0.1) for hip in HIPS},
        **{(hip, "kp"): ("product", 8.0, 24.0) for hip in HIPS},
        **{(hip, "kd"): ("product", 0.2, 0.6) for hip in HIPS},
        ("knee", "kd"): ("uniform", 0.5, 1.0),
        ("knee", "limit"): ("uniform", 12.5, 25.0),
        ("toe", "limit"): ("uniform", 4.0, 8.0),
    },
}
"""Distribution and range of what is drawn, by hand."""

BATCHED = {
    "fields": [
        "actuator_biasprm",
        "actuator_forcerange",
        "actuator_gainprm",
        "dof_armature",
        "dof_damping",
        "dof_frictionloss",
        "jnt_actfrcrange",
    ],
    "factors": ["actuator_biasprm", "actuator_forcerange", "actuator_gainprm", "dof_damping"],
}
