"""Rules of `motors`."""

from __future__ import annotations

from collections.abc import Iterator

from actspec.spec.models import Motor
from actspec.spec.paths import Path
from actspec.spec.rules.breaches import Breaches
from actspec.spec.rules.gears import check_gearbox
from actspec.spec.values import SpecValue

SIDED = ("stall_torque", "no_load_speed", "peak_torque", "continuous_torque", "torque_constant", "curve")
"""Motor figures that differ between rotor and gearbox output."""


def check_motor(name: str, motor: Motor, breaches: Breaches) -> None:
    """Side, gear, inertia and curve of a motor fit together."""
    path: Path = ("motors", name)
    sided = [field for field in SIDED if getattr(motor, field) is not None]
    if sided and motor.side is None:
        breaches.error(
            "SPEC130",
            f"`side` is missing: is {sided[0]} quoted at the gearbox output or at the rotor?",
            path,
            "write `side: joint` (output) or `side: motor` (rotor, needs gear_ratio)",
        )
    check_gearbox(path, motor, breaches)
    missing = "missing" if motor.gear_ratio is None else "unknown"
    geared = motor.gearbox is not None or (
        motor.gear_ratio is not None and motor.gear_ratio.value is not None
    )
    if motor.side == "motor" and not geared:
        for field in sided:
            breaches.error(
                "SPEC131",
                f"{field} is quoted at the motor, but `gear_ratio` is {missing}",
                (*path, field),
                "state gear_ratio or gearbox, or quote the figure at the joint with `side: joint`",
            )
    torques = [field for field in sided if field != "no_load_speed"]
    for at, efficiency in _efficiencies(path, motor):
        if motor.side == "motor" and torques and efficiency is not None and efficiency.value is None:
            breaches.error(
                "SPEC131",
                f"{torques[0]} is quoted at the motor, but `efficiency` is unknown",
                at,
                "state it, or remove it to take 1; or quote the torques at the joint with `side: joint`",
            )
    if motor.rotor_inertia is not None and motor.rotor_inertia.value is not None and not geared:
        breaches.error(
            "SPEC131",
            f"rotor_inertia is at the rotor, but `gear_ratio` is {missing}",
            (*path, "rotor_inertia"),
            "state gear_ratio (1 for a direct drive), or give reflected_inertia at the output",
        )
    if motor.rotor_inertia is not None and motor.reflected_inertia is not None:
        breaches.error(
            "SPEC132",
            "rotor_inertia and reflected_inertia are both given",
            (*path, "reflected_inertia"),
            "keep the one that was measured; the other follows from gear_ratio",
        )
    if motor.curve is not None and (motor.stall_torque is not None or motor.no_load_speed is not None):
        breaches.error(
            "SPEC133",
            "an asymmetric `curve` stands in place of stall_torque and no_load_speed",
            (*path, "curve"),
            "remove one of the two",
        )
    if motor.curve is not None:
        knee, free = motor.curve.knee_speed, motor.curve.no_load_speed
        if knee.value is not None and free.value is not None and knee.value >= free.value:
            breaches.error(
                "SPEC134",
                f"knee_speed {knee.written} is not below no_load_speed {free.written}",
                (*path, "curve", "knee_speed"),
                "the full torque ends at the knee, all torque at no_load_speed",
            )
    low, high = motor.continuous_torque, motor.peak_torque
    if low and high and low.value is not None and high.value is not None and low.value > high.value:
        breaches.error(
            "SPEC135",
            f"continuous_torque {low.written} is above peak_torque {high.written}",
            (*path, "continuous_torque"),
            "the thermal limit is the lower one; are the two swapped?",
        )


def _efficiencies(path: Path, motor: Motor) -> Iterator[tuple[Path, SpecValue | None]]:
    """Where an efficiency of the gearbox may be stated, and what is."""
    yield (*path, "efficiency"), motor.efficiency
    for index, stage in enumerate(motor.gearbox or ()):
        yield (*path, "gearbox", index, "efficiency"), stage.efficiency
