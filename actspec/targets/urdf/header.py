"""The comment at the top of a written URDF: what its numbers are made of, and what is not in it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import actspec
from actspec.ir import ActuatorSet, Origin, Quantity
from actspec.targets.base import Approximation
from actspec.targets.provenance import loss_lines, provenance, source_lines, xml_comment
from actspec.targets.python_text import grouped
from actspec.targets.urdf.plan import written


def header(actuators: ActuatorSet, driven: frozenset[str], lost: Iterable[Approximation], source: str) -> str:
    """The text of one XML comment.

    Args:
        actuators: What was compiled.
        driven: Joints whose numbers are written.
        lost: What is not in the file.
        source: File name of the robot's model.
    """
    lines = [
        f"Written by actspec {actspec.__version__} as URDF. Do not edit: change the spec and compile again.",
        f"spec sha256 {actuators.spec_sha256}",
        f"model {source}",
    ]
    if actuators.unmanaged:
        lines.append(f"Not managed by the spec: {', '.join(actuators.unmanaged)}")
    joints = [a for a in actuators.joints if a.joint in driven]
    entries = [((a.group, tuple(_entries(written(a)))), a.joint) for a in joints]
    for (group, numbers), members in grouped(entries, lambda entry: entry[0]):
        lines += ["", f"{group}: {', '.join(joint for _, joint in members)}", *(f"  {n}" for n in numbers)]
    left = list(loss_lines(_by_group(actuators, lost)))
    if left:
        lines += ["", "Not in this format, or not as asked:", *(f"  {line}" for line in left)]
    cited = list(source_lines(actuators, (q for a in joints for q in written(a).values() if q.known)))
    if cited:
        lines += ["", "Sources:", *(f"  {line}" for line in cited)]
    return xml_comment(lines)


def _by_group(actuators: ActuatorSet, lost: Iterable[Approximation]) -> Iterator[Approximation]:
    """The losses with a group's name in the place of its joints where all of them lose the same."""
    groups: dict[str, set[str]] = {}
    for actuator in actuators.joints:
        groups.setdefault(actuator.group, set()).add(actuator.joint)
    for loss, members in grouped(lost, lambda one: replace(one, joint="")):
        joints = dict.fromkeys(member.joint for member in members)
        for group, own in groups.items():
            if own <= joints.keys():
                yield replace(loss, joint=group)
                joints = {joint: None for joint in joints if joint not in own}
        for joint in joints:
            yield replace(loss, joint=joint)


def _entries(numbers: dict[str, Quantity]) -> Iterator[str]:
    for attribute, quantity in numbers.items():
        if not quantity.known:
            yield f"{attribute} {provenance(quantity)}: the file's own, if it has one"
        elif quantity.origin is Origin.DEFAULT:
            yield f"{attribute} {provenance(quantity, 'not written')}"
        else:
            yield f"{attribute} {provenance(quantity)}"
