"""Stages of gears between two shafts: ratio, efficiency, and inertia on the way."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from actspec.diagnostics import Path
from actspec.fields import unit_of_kind
from actspec.ir import JointKind, Origin, Quantity, tidy
from actspec.resolution.quantities import Factor, in_words, scaled, written
from actspec.spec.document import Breaches
from actspec.spec.gears import KINDS_OF_STAGE, Stage
from actspec.spec.models import Motor
from actspec.spec.rules.motors import number, stage_ratio, stage_speed
from actspec.spec.validate import Spec
from actspec.spec.values import SpecValue
from actspec.units import Kind, format_number, format_quantity

WRONG_OUTPUT = {"lead": JointKind.HINGE, "lever_arm": JointKind.SLIDE}
"""What cannot stand behind such a stage."""

OTHER = {JointKind.HINGE: JointKind.SLIDE, JointKind.SLIDE: JointKind.HINGE}


@dataclass(frozen=True, slots=True)
class Step:
    """One stage of a train.

    Attributes:
        ratio: Speed at its input per speed at its output [-, rad/m or m/rad].
        key: What it is, as the spec calls it.
        text: How the ratio is written.
        output: What its output does: turn (hinge) or travel (slide).
        inertia: Of what moves with its output; None: not stated.
        path: Where it is written.
    """

    ratio: float
    key: str
    text: str
    output: JointKind
    path: Path
    inertia: SpecValue | None = None


@dataclass(frozen=True, slots=True)
class Train:
    """The stages between two shafts, from the motor's side to the joint's; none: the shafts are one.

    Attributes:
        name: What it is in formulas: `gear_ratio`, `gearbox`, `reduction` or `transmission`.
        steps: Its stages.
        input: What its input does: turn or travel.
        efficiency: Factor on the torque that passes, with its name; None: nobody states one.
        legend: What `name` is made of; "" where it is one number.
        efficiencies: What `efficiency` is made of, likewise.
    """

    name: str
    steps: tuple[Step, ...]
    input: JointKind
    efficiency: Factor | None
    legend: str = ""
    efficiencies: str = ""

    @property
    def speed(self) -> tuple[Factor, ...]:
        """Factors from the speed of its output to that of its input."""
        return self.behind(0)

    @property
    def torque(self) -> tuple[Factor, ...]:
        """Factors from the torque at its input to that at its output."""
        return self.speed if self.efficiency is None else (*self.speed, self.efficiency)

    @property
    def massless(self) -> tuple[str, ...]:
        """Stages that state no inertia, where stages are stated one by one."""
        if not self.legend:
            return ()
        return tuple(
            f"{self.name} stage {index}" for index, step in enumerate(self.steps, 1) if step.inertia is None
        )

    def behind(self, first: int, power: int = 1) -> tuple[Factor, ...]:
        """The ratio of the stages from `first` on, to a power, with its name; nothing behind the last."""
        steps = self.steps[first:]
        if not steps:
            return ()
        name = self.name
        if first:
            last = len(self.steps)
            name += f" stage {last}" if first == last - 1 else f" stages {first + 1} to {last}"
        ratio = math.prod(step.ratio for step in steps)
        # As a product: a power of floats raises where a product is infinite.
        return ((ratio if power == 1 else ratio * ratio, name if power == 1 else f"{name}^2"),)


def gear_train(motor: Motor, name: str, output: JointKind) -> Train:
    """The gearbox of a motor, from rotor to output; an unknown gear ratio or efficiency counts as 1.

    What such a figure would scale is refused before (SPEC131).

    Args:
        motor: The motor.
        name: Its key in `motors`.
        output: What the gearbox's output does.
    """
    path: Path = ("motors", name)
    whole = None if motor.efficiency is None else (motor.efficiency.value or 1.0, "efficiency")
    if motor.gearbox is not None:
        steps = _steps(motor.gearbox, output, (*path, "gearbox"))
        return _train("gearbox", motor.gearbox, steps, output, whole)
    ratio = None if motor.gear_ratio is None else motor.gear_ratio.value
    steps = (
        ()
        if ratio is None
        else (Step(ratio, "ratio", f"{format_number(ratio)}", output, (*path, "gear_ratio")),)
    )
    return Train("gear_ratio", steps, output, whole)


def joint_train(
    stages: Sequence[Stage] | None, reduction: float | None, path: Path, joint: JointKind
) -> Train:
    """What stands between a motor's output and its joint.

    Args:
        stages: The stages of `transmission`; None without one.
        reduction: In its place; None without one.
        path: Where the stages are written.
        joint: The joint's kind.
    """
    if stages is not None:
        return _train("transmission", stages, _steps(stages, joint, path), joint, None)
    steps = (
        () if reduction is None else (Step(reduction, "ratio", f"{format_number(reduction)}", joint, path),)
    )
    # A bare reduction has no losses of its own: there is no field for them.
    return Train("reduction", steps, joint, (1.0, "efficiency"))


def _train(
    name: str, stages: Sequence[Stage], steps: tuple[Step, ...], output: JointKind, whole: Factor | None
) -> Train:
    """A train of stages, with the product of their efficiencies where the whole has none."""
    texts = [f"({step.text})" if " + " in step.text and len(steps) > 1 else step.text for step in steps]
    legend = f", {name} = {' x '.join(texts)}"
    stated = [None if stage.efficiency is None else stage.efficiency.value or 1.0 for stage in stages]
    if whole is not None or not any(stated):
        return Train(name, steps, _input(stages, output), whole, legend)
    own = "efficiency" if name == "gearbox" else f"efficiency of the {name}"
    parts = (
        f"1 (stage {index}, default)" if part is None else f"{format_number(part)}"
        for index, part in enumerate(stated, 1)
    )
    efficiencies = f", {own} = {' x '.join(parts)}" if len(stated) > 1 else ""
    efficiency = (math.prod(part or 1.0 for part in stated), own)
    return Train(name, steps, _input(stages, output), efficiency, legend, efficiencies)


def _steps(stages: Sequence[Stage], output: JointKind, path: Path) -> tuple[Step, ...]:
    """The stages as numbers; what turns and what travels follows from the joint, so they are read from there."""
    steps: list[Step] = []
    for index in reversed(range(len(stages))):
        stage = stages[index]
        ratio, text = _ratio(stage, output)
        key = next(kind for kind in KINDS_OF_STAGE if getattr(stage, kind) is not None)
        steps.append(Step(ratio, key, text, output, (*path, index), stage.inertia))
        output = _before(stage, output)
    return tuple(reversed(steps))


def _input(stages: Sequence[Stage], output: JointKind) -> JointKind:
    for stage in reversed(stages):
        output = _before(stage, output)
    return output


def _before(stage: Stage, output: JointKind) -> JointKind:
    """What the input of a stage does."""
    return output if stage_ratio(stage) is not None else OTHER[output]


def _ratio(stage: Stage, output: JointKind) -> tuple[float, str]:
    """Speed at a stage's input per speed at its output, and how it is written."""
    plain = stage_ratio(stage)
    if stage.planetary is not None and plain is not None:
        return plain, f"1 + {stage.planetary.ring.written}/{stage.planetary.sun.written}"
    if stage.teeth is not None and plain is not None:
        return plain, f"{stage.teeth.driven.written}/{stage.teeth.driving.written}"
    if plain is not None:
        return plain, f"{format_number(plain)}"
    length = stage.lead or stage.radius or stage.lever_arm
    assert length is not None
    ratio = stage_speed(stage, output is JointKind.SLIDE)
    return ratio, length.written if ratio == number(length) else f"1/({length.written})"


def check_train(train: Train, end: str, breaches: Breaches) -> bool:
    """Refuse a screw whose nut would turn, a lever whose joint would travel, an inertia in the other's unit.

    Args:
        train: The train.
        end: What it drives, for messages.
        breaches: Takes what is wrong.

    Returns: Whether its stages fit each other and what they drive.
    """
    fits = True
    for step in train.steps:
        does = "turns" if step.output is JointKind.HINGE else "travels"
        if step.output is WRONG_OUTPUT.get(step.key):
            fits = False
            at = (*step.path, step.key)
            breaches.error(
                "RES013",
                f"the part that a {step.key} drives {does}, on the way to {end}",
                at,
                "a lead turns rotation into travel, a lever_arm travel into rotation: a screw drives a slide joint, "
                "or a lever_arm that drives a hinge",
            )
        elif step.inertia is not None and unfit(step.inertia, step.output):
            at = (*step.path, "inertia")
            breaches.error(
                "RES001",
                f"the inertia is {step.inertia.written}, but the stage's output {does}, on the way to {end}",
                at,
                "what turns has an inertia in kg*m^2, what travels one in kg",
            )
    return fits


def unfit(value: SpecValue, kind: JointKind) -> bool:
    """Whether a number is in the unit of what travels and its shaft turns, or the reverse."""
    return value.value is not None and value.linear is (kind is JointKind.HINGE)


def inertia_at_joint(
    motor: Sequence[Quantity],
    behind: Sequence[Factor],
    outside: Sequence[Quantity],
    missing: Sequence[str],
    unit: str,
) -> Quantity:
    """The sum of inertias that are at the joint already; one that is unknown makes the sum unknown.

    Args:
        motor: Those of the motor and its gearbox, the rotor's first.
        behind: Factors that all of them were scaled by last.
        outside: Those of what stands behind its output.
        missing: Parts that state none, and count as nothing.
        unit: Unit of the sum.
    """
    terms = (*motor, *outside)
    if not all(term.known for term in terms):
        return next(term for term in terms if not term.known)
    first = terms[0]
    remark = f"without {' and '.join(missing)}, whose inertia is not stated" if missing else None
    note = "; ".join(part for part in (first.note, remark) if part) or None
    if len(terms) == 1:
        return replace(first, unit=unit, note=note)
    texts = [term.formula or format_quantity(term.value, term.unit) for term in terms]
    common = in_words(behind)
    own = " + ".join(text.removesuffix(common) for text in texts[: len(motor)])
    if common:
        own = f"({own}){common}" if len(motor) > 1 else f"{own}{common}"
    stated = [term.std for term in terms if term.std is not None]
    return Quantity(
        tidy(sum(term.require() for term in terms)),
        unit,
        Origin.DERIVED,
        first.source,
        first.span,
        math.hypot(*stated) if stated else None,
        note,
        " + ".join((own, *texts[len(motor) :])),
    )


def carried(train: Train, behind: Sequence[Factor], spec: Spec) -> list[Quantity]:
    """Inertias of a train's own stages at the joint; a stage without one gives nothing.

    Args:
        train: The train.
        behind: Factors from the train's output to the joint.
        spec: The spec.
    """
    found = []
    for index, step in enumerate(train.steps):
        if step.inertia is not None:
            own = written(
                step.inertia, unit_of_kind(Kind.INERTIA, step.output), spec.span(*step.path, "inertia")
            )
            found.append(scaled(own, (*train.behind(index + 1, power=2), *behind)))
    return found
