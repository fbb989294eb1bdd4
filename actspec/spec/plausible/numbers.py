"""The checks that need no robot, `check_numbers`, and what they share with those of a robot's joints."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

from actspec.diagnostics import Collector, Path, did_you_mean, listed
from actspec.ir import JointActuator
from actspec.spec.document import Document, SourceMap
from actspec.spec.models import SpecModel
from actspec.spec.plausible.clamps import range_doubts
from actspec.spec.plausible.contradicted import contradictions
from actspec.spec.plausible.driven import gear_doubts
from actspec.spec.plausible.exchanges import exchanges
from actspec.spec.plausible.gearing import multiplier_doubts
from actspec.spec.plausible.groups import group_doubts, layers
from actspec.spec.plausible.linkages import linkage_doubts
from actspec.spec.plausible.repairs import motor_doubts
from actspec.spec.plausible.rubbing import rubbed_doubts
from actspec.spec.plausible.table import BY_CODE, Doubt, Kept, at, by_number, kept_of, tell
from actspec.spec.plausible.times import time_doubts
from actspec.spec.plausible.witnesses import file_doubts, witnessed
from actspec.spec.rules.motors import sided_figures
from actspec.spec.rules.robot import SPEC_ITSELF
from actspec.spec.values import SpecValue
from actspec.units import format_quantity

SPREAD = 10.0
"""Standard deviation over value. Chosen: of what a fit hardly sees it is 1 to 3."""

_BY_FILE = frozenset(("FRC101", "SPEC135", "SPEC180", "SPEC187"))
_CODE = re.compile("[A-Za-z]{2,}[0-9]+")


def check_numbers(model: SpecModel, document: Document, collector: Collector) -> None:
    """Report the numbers of a spec that can hardly be right, whatever its robot is.

    Args:
        model: What the spec says; it is valid.
        document: Where it says it.
        collector: Takes warnings, and errors where nothing could be right.
    """
    for key in model.accept:
        whose, _, code = key.partition(".")
        if whose == SPEC_ITSELF and _CODE.fullmatch(code) and code not in BY_CODE:
            # What another family reports is no misspelt check.
            akin = [f"{SPEC_ITSELF}.{known}" for known in BY_CODE if known[:3] == code[:3].upper()]
            none = (
                "its checks: " + listed(akin, 40)
                if akin
                else f"remove it: --strict refuses nothing of {code}"
            )
            help = did_you_mean(f"{SPEC_ITSELF}.{code.upper()}", akin, none)
            collector.at(f"accept.{key}", document.spans.key(("accept", key))).error(
                "SPEC162", f"no check of a spec's numbers is called {code}", help
            )
    kept = kept_of(document, model.accept)
    doubts = number_doubts(model, document, kept)
    # Which of friction and limit, or of two torques, is wrong, the robot's file tells: no reason not to read it.
    read = not collector.failed
    told = (replace(doubt, error=False) if read and doubt.code in _BY_FILE else doubt for doubt in doubts)
    tell(told, kept, collector)


def number_doubts(
    model: SpecModel, document: Document, kept: Kept, joints: Sequence[JointActuator] = ()
) -> list[Doubt]:
    """What the figures imply; also what the author is sure of, where other figures follow from it.

    Args:
        model: What the spec says.
        document: Where it says it.
        kept: What the author is sure of.
        joints: The resolved spec, with what the robot's file says; none: whatever the robot is.
    """
    spans = document.spans
    drives = list(witnessed(joints, model, spans, kept))
    exchanged = list(exchanges(drives, model, spans))
    together = {name for pair in exchanged for name in pair.motors}
    doubts = [pair.doubt for pair in exchanged]
    gears = list(_gears(model, spans))
    # What follows from a gear that nobody can make is not told, nor of whatever it drives.
    made = {doubt.where.split(".")[1] for doubt in gears if doubt.where.startswith("motors.")}
    # Nor by figures of which nobody says at which side of the gear they are: that is told (SPEC130).
    made |= {name for name, motor in model.motors.items() if motor.side is None and sided_figures(motor)}
    doubts += gears
    for drive in drives:
        if drive.name not in together and drive.name not in made:
            own = list(motor_doubts(drive, spans)) or list(rubbed_doubts(drive, spans))
            own = own or list(multiplier_doubts(drive, model, joints, spans))
            doubts += own or contradictions(drive, joints, model, spans)
    places = {doubt.span for doubt in doubts}
    doubts += (doubt for doubt in by_number(file_doubts(joints, model, spans)) if doubt.span not in places)
    doubted = {place for doubt in doubts for place in (doubt.where, doubt.span)}
    doubts += linkage_doubts(model, spans, joints, doubted)
    doubts += [*range_doubts(model, spans), *time_doubts(model, spans, (joint.joint for joint in joints))]
    doubts += _std_doubts(model, spans)
    return list(_one_of_gains([*doubts, *group_doubts(model, spans, doubted, kept)]))


def _one_of_gains(doubts: Sequence[Doubt]) -> Iterator[Doubt]:
    """One message of kp and kd: where one of them is not its source's that is told, of both what explains both."""
    sourced = {doubt.span for doubt in doubts if doubt.code == "SPEC194"}
    pairs = [frozenset((doubt.span, *doubt.judged)) for doubt in doubts if doubt.code == "SPEC192"]
    explained = {span for pair in pairs if len(pair) > 1 and pair <= sourced for span in pair}
    for doubt in doubts:
        if doubt.code == "SPEC194" and doubt.span in explained:
            continue
        if (
            doubt.code == "SPEC192"
            and doubt.span not in explained
            and sourced.intersection((doubt.span, *doubt.judged))
        ):
            continue
        yield doubt


def _gears(model: SpecModel, spans: SourceMap) -> Iterator[Doubt]:
    """Stages of gearboxes and transmissions that nobody can make."""
    for name, motor in model.motors.items():
        yield from gear_doubts(motor.gearbox or (), ("motors", name, "gearbox"), spans)
    for path, fields, _ in layers(model):
        yield from gear_doubts(fields.transmission or (), (*path, "transmission"), spans)


def _std_doubts(model: SpecModel, spans: SourceMap) -> Iterator[Doubt]:
    """Standard deviations far above their values; an encoder's error may be 0, with any."""
    parts: list[tuple[Path, Any]] = [(("motors", name), motor) for name, motor in model.motors.items()]
    for path, fields, _ in layers(model):
        parts += [(path, fields), ((*path, "friction"), fields.friction)]
    for path, part in parts:
        for key in () if part is None else sorted(part.model_fields_set - {"encoder_bias"}):
            stated = getattr(part, key)
            if not isinstance(stated, SpecValue) or not stated.value or not stated.std:
                continue
            ratio = stated.std / abs(stated.value)
            if ratio > SPREAD:
                message = (
                    f"a standard deviation of {format_quantity(stated.std, stated.unit, 4)} is "
                    f"{format_quantity(ratio, '', 3)} times the value of {stated.written}"
                )
                help = "look for a wrong unit, or the point in the wrong place"
                yield at(spans, "SPEC188", message, (*path, key, "std"), help, (*path, key))
