"""What an identification says of a joint beside its figures: why it has none, on which gains they rest, what goes
together, and where they come from.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from actspec.diagnostics import Collector, Span, listed
from actspec.fields import BY_IR
from actspec.ir import Approximation, JointActuator, Origin, Quantity, Source
from actspec.resolution.stated import JointInputs, Stated
from actspec.spec.rules.robot import SPEC_ITSELF
from actspec.spec.validate import Spec
from actspec.units import Kind, format_number, format_quantity

CORRELATED = 0.5
"""|correlation| above which draws of two fields apart are another set of robots. Chosen: results list none below."""
SAME_GAIN = 0.01
"""Relative difference of two gains that is rounding. Chosen: a tenth of what a log tells of a scale without torque."""
ON_GAINS = ("armature", "friction_coulomb", "friction_static", "friction_viscous")
"""Figures that a fit without torque scales by the gains it holds."""


def why_missing(inputs: JointInputs, field: str) -> tuple[str, str]:
    """Why the results have no value of a field, with the place that says so, and what would help.

    Args:
        inputs: What is said about the joint.
        field: As in `randomize`, and `bandwidth`.
    """
    # Results are models that take time to build: they are there where this is asked.
    from actspec.spec.remedy import remedy

    stated = inputs.stated
    file, result = stated.results, stated.result
    if file is None:
        return "no results are read", "write the number here"
    name = file.document.path
    if result is None:
        has = listed(file.model.joints) or "none"
        return (
            # Without the joint's name: those with the same reason are told together.
            f"{name} has no such joint, its joints are {has}",
            "fit the joint, or write the number here",
        )
    if field in result.left_out:
        where = stated.result_span("left_out", field)
        return f"{where} left it out: {result.left_out[field]}", "write the number here"
    found = remedy(field, result)
    design = f" (`actspec sysid design --experiment {found.experiment}`)" if found.experiment else ""
    help = f"{found.words}{design}; or write the number here"
    for key, words in (
        ("unidentifiable", "lists it as unidentifiable"),
        ("bounds_hit", "lists it as at a bound of the fit"),
    ):
        named: Sequence[str] = getattr(result, key)
        if field in named:
            place = stated.result_span(key, named.index(field))
            told = [
                f"{formula} = {format_quantity(sum_.value, sum_.unit)}"
                for formula, sum_ in result.combinations.items()
                if field in _fields_in(formula)
            ]
            because = f": {result.reasons[field]}" if field in result.reasons else ""
            return f"{place} {words}{because}" + (f"; it has {' and '.join(told)}" if told else ""), help
    held = getattr(result.gains, field, None) if field in ("kp", "kd") else None
    if held is not None:
        where = stated.result_span("gains", field)
        return f"the fit took {held.written} as given ({where})", help
    return f"{name} has no {field} of it", help


def _fields_in(formula: str) -> set[str]:
    """`(kd+friction.viscous)/inertia` as its fields."""
    for sign in "()+/*":
        formula = formula.replace(sign, " ")
    return set(formula.split())


def drawn_apart(inputs: JointInputs) -> Iterator[Approximation]:
    """Pairs of fields whose ranges are those of one fit, in which their errors go together: no target draws pairs."""
    result = inputs.stated.result
    if result is None:
        return
    drawn = [name for name, entry in inputs.stated.group.randomize.items() if entry.from_ is not None]
    for one, other, r in result.correlation:
        if one in drawn and other in drawn and one != other and abs(r) > CORRELATED:
            yield Approximation(
                SPEC_ITSELF,
                inputs.joint.name,
                "correlation",
                f"{one} and {other} with a correlation of {format_number(r, 2)}",
                "each drawn on its own",
                "no range goes with another: some draws are pairs that the logs rule out; a range for one of the two "
                "leaves them out",
                None,
                inputs.unit(Kind.TORQUE),
            )


def check_gains(pairs: Iterable[tuple[JointActuator, Stated]], collector: Collector) -> None:
    """Tell where figures rest on other gains than the spec's (SPEC175), joints with the same numbers together."""
    found: dict[str, list[tuple[str, Span | None]]] = {}
    for actuator, stated in pairs:
        said = _resting(actuator, stated)
        if said is not None:
            found.setdefault(said, []).append((actuator.joint, stated.result_span("gains")))
    for said, joints in found.items():
        collector.info(
            "SPEC175",
            f"{listed([joint for joint, _ in joints])}: {said}",
            where=f"joints.{joints[0][0]}.gains",
            span=joints[0][1],
            help="right where the drive had those gains during the log; else correct them in its sidecar and fit again",
        )


def _resting(actuator: JointActuator, stated: Stated) -> str | None:
    """Which figures rest on which gains, where those are not the spec's; None else."""
    gains = None if stated.result is None else stated.result.gains
    if gains is None:
        return None
    resting = [
        BY_IR[name].spec
        for name in ON_GAINS
        if (quantity := getattr(actuator, name)) is not None and quantity.origin is Origin.IDENTIFIED
    ]
    apart = []
    for name in ("kp", "kd"):
        gain: Quantity | None = getattr(actuator, name)
        held = getattr(gains, name)
        if gain is None or gain.value is None or held.value is None:
            continue
        if abs(gain.value - held.value) > SAME_GAIN * max(abs(gain.value), abs(held.value)):
            own = format_quantity(gain.value, gain.unit)
            apart.append(f"{name} {format_quantity(held.value, gain.unit)}, the spec has {own}")
    if not resting or not apart:
        return None
    return f"{' and '.join(resting)} rest on gains that the fit took as given: {'; '.join(apart)}"


def results_sources(spec: Spec) -> Iterator[Source]:
    """The results files as sources of their figures: how and when they were found, and the file's hash."""
    for name, file in spec.results.items():
        found = file.model
        parts = [f"identification by {found.method}" + (f" at {found.commit}" if found.commit else "")]
        parts += [part for part in (found.date, found.temperature and f"motors {found.temperature}") if part]
        parts.append(f"sha256 {file.document.text_sha256}")
        if name not in spec.model.sources:
            yield Source(name, ", ".join(parts))
