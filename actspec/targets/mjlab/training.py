"""A script that trains variants of a robot in mjlab: text for users, by templates/mjlab/train.py.j2."""

from __future__ import annotations

from collections.abc import Mapping

import actspec
from actspec.ir import ActuatorSet
from actspec.simulators import DEFAULT_VERSIONS
from actspec.targets.kit.python_text import comment_lines, environment, identifier, module_name
from actspec.targets.mjlab.text import WIDTH

VELOCITY = {"go1": "Mjlab-Velocity-Flat-Unitree-Go1", "g1": "Mjlab-Velocity-Flat-Unitree-G1"}
"""Word of a robot's name to mjlab's own task for that robot. Source: mjlab 1.6.0, tasks/velocity/config."""


def task_of(robot: str) -> str | None:
    """mjlab's own task for a robot, by its name; None: it has none."""
    words = identifier(robot).lower().split("_")
    return next((task for word, task in VELOCITY.items() if word in words), None)


def train_text(variants: Mapping[str, ActuatorSet], task: str | None, spec: str, origin: str) -> str:
    """The script.

    Args:
        variants: By name, which is that of their folders.
        task: Registered with mjlab; None: the user has to name one.
        spec: File name of a variant's spec, in its folder.
        origin: The spec that they are of.
    """
    first = next(iter(variants.values()))
    stem = identifier(first.robot)
    said = f"Written by actspec {actspec.__version__} from {origin}. Yours to edit: what was edited stays."
    return (
        environment("mjlab")
        .get_template("train.py.j2")
        .render(
            robot=stem,
            task=task,
            usage=f"python train.py {next(iter(variants))} --seed 0",
            version=DEFAULT_VERSIONS["mjlab"],
            header=comment_lines(said, width=WIDTH),
            variants=tuple(variants),
            joints=[actuator.joint for actuator in first.joints],
            timestep=first.physics_dt.require(),
            decimation=first.decimation,
            spec=spec,
            cfg=f"{module_name(first.robot)}.py",
            events=f"{stem}_mjlab_events.py",
            filters={name: found for name, of in variants.items() if (found := _cutoffs(of))},
        )
    )


def _cutoffs(actuators: ActuatorSet) -> dict[str, float]:
    """Joint to the cutoff of its filter [Hz]."""
    filters = ((a.joint, a.filter_cutoff) for a in actuators.joints)
    return {joint: q.value for joint, q in filters if q is not None and q.value is not None}
