"""Specs whose every number shows: no two alike where they could be exchanged."""

from __future__ import annotations

RICH = """actspec: 1
robot:
  name: rich-bot
  model: none
  joints: [left_hip, right_hip, left_knee, right_knee, toe, wheel, grip, {name: lift, kind: slide}]
timing: {physics_dt: 5 ms, decimation: 4}
motors:
  line: {side: joint, stall_torque: 45 N*m, no_load_speed: 30 rad/s, peak_torque: 24 N*m}
  small: {side: joint, stall_torque: 30 N*m, no_load_speed: 25 rad/s, peak_torque: 24 N*m}
  curve:
    side: joint
    curve: {drive_torque: 20 N*m, brake_torque: 25 N*m, knee_speed: 14 rad/s, no_load_speed: 30 rad/s}
actuators:
  hips:
    joints: [".*_hip"]
    level: ideal_pd
    kp: 100 N*m/rad
    kd: 4 N*m*s/rad
    effort_limit: 30 N*m
    velocity_limit: 11 rad/s
    armature: 0.02 kg*m^2
    friction: {coulomb: 0.3 N*m, static: 0.5 N*m, viscous: 0.05 N*m*s/rad}
    delay: 10 ms
    overrides: {"left_hip": {effort_limit: 25 N*m, kp: 90 N*m/rad, armature: 0.03 kg*m^2}}
  knees:
    joints: [".*_knee"]
    motor: line
    level: dc_motor
    kp: 80 N*m/rad
    kd: 2 N*m*s/rad
    effort_limit: 20 N*m
    armature: 0.01 kg*m^2
    friction: {coulomb: 0.2 N*m, viscous: 0.04 N*m*s/rad}
    overrides: {"right_knee": {motor: small}}
  toe: {joints: [toe], level: ideal_pd, kp: 20 N*m/rad, kd: 0.7 N*m*s/rad, effort_limit: 9 N*m}
  wheel: {joints: [wheel], motor: line, level: dc_motor, command: velocity, kd: 3 N*m*s/rad, effort_limit: 15 N*m}
  grip: {joints: [grip], level: ideal_pd, command: effort, effort_limit: 5 N*m}
  lift: {joints: [lift], level: ideal_pd, kp: 900 N/m, kd: 30 N*s/m, effort_limit: 200 N, armature: 1 kg}
"""
"""What the stock classes hold exactly: every level and command, numbers that differ inside a group."""

WHOLE = """actspec: 1
robot: {name: whole, model: none, joints: [a, b, c, w, e, p]}
timing: {physics_dt: 4 ms}
motors:
  line: {side: joint, stall_torque: 45 N*m, no_load_speed: 30 rad/s, peak_torque: 24 N*m}
  curve:
    side: joint
    curve: {drive_torque: 20 N*m, brake_torque: 25 N*m, knee_speed: 14 rad/s, no_load_speed: 30 rad/s}
actuators:
  line:
    joints: [a, b]
    motor: line
    level: dc_motor
    kp: 100 N*m/rad
    kd: 4 N*m*s/rad
    effort_limit: 20 N*m
    encoder_bias: 0.02 rad
    delay: 8 ms
    command_filter: {cutoff: 30 Hz}
    armature: 0.01 kg*m^2
    friction: {coulomb: 0.2 N*m, viscous: 0.04 N*m*s/rad}
    overrides: {b: {encoder_bias: -0.05 rad, command_filter: {cutoff: 12 Hz}, effort_limit: 18 N*m}}
  curve:
    joints: [c]
    motor: curve
    level: dc_motor
    kp: 60 N*m/rad
    kd: 1 N*m*s/rad
    effort_limit: 22 N*m
    command_range: [-0.4 rad, 0.5 rad]
    delay: {nominal: 8 ms, range: [4 ms, 16 ms]}
  wheel:
    joints: [w]
    motor: line
    level: dc_motor
    command: velocity
    kd: 3 N*m*s/rad
    effort_limit: 15 N*m
    command_filter: {cutoff: 20 Hz}
  grip: {joints: [e], level: ideal_pd, command: effort, effort_limit: 5 N*m, delay: 4 ms}
  plain: {joints: [p], level: ideal_pd, kp: 20 N*m/rad, kd: 0.7 N*m*s/rad, effort_limit: 9 N*m}
"""
"""What only a class of our own holds: delay, filter, bias and curve together."""

RANGED = (
    WHOLE.replace("level: dc_motor\n    kp: 60", "level: ideal_pd\n    kp: 60")
    .replace("    motor: curve\n", "")
    .replace("    command_range: [-0.4 rad, 0.5 rad]\n", "")
)
"""WHOLE with joint c as a plain drive, delayed by 4 to 16 ms of 4 ms."""
