"""Simulation of single joints, for verification, identification and learning.

- `excitation`: courses of a command (`stepped`, `ramped`, `chirp`, `command_for`), and states that joints are held at.
- `reference`: the law held (`held_torque`) and moving (`integrate`), with exact stick-slip.
- `experiment`: joints that are let go, each on a body of its own, with courses sized by their own laws (`design`).
- `rollout`: the same in MuJoCo, in this process or in a release of its own (`Rig`, `rollout`, `isolated`).
- `standalone`: what scripts in other simulators' environments share with us (`Body`, `Driven`, `follow`, `serve`).

Arrays are numpy's, joint side and SI; time runs along the first axis, joints along the last. Nothing here knows
specs, robot files or targets; it stands on `ir` and `laws`. MuJoCo is imported by `rollout` alone, inside functions.
Names are imported from the modules: who needs one module does not wait for the others.
"""
