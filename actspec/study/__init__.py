"""What a modelling decision changes: variants of a spec beside each other, and what logs say of them.

- `variants`: the same joint with less or more of its model: PD and limit, one further effect each, all of it.
- `courses`: a step, a swing and a chirp of each distinct actuator alone, sized by its own torque.
- `metrics`: what an answer shows: rise, overshoot, settling, bandwidth, saturation.
- `compare`: each variant under each course, as the law has it and as MuJoCo does.
- `ablation`, `replay`, `trainings`: specs of variants to train beside each other, how they follow a log, results.
"""
