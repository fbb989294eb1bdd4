"""One joint on its way into a cfg: what is asked for, what is written of it, what is lost."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from actspec.ir import Command, JointActuator, Level, Quantity
from actspec.laws import TorqueLaw, law_of
from actspec.simulators.isaaclab import IsaacLabDialect
from actspec.targets.approximation import held_step_error
from actspec.targets.base import Approximation
from actspec.targets.losing_joint import network_clip
from actspec.targets.python_text import provenance
from actspec.units import format_quantity

if TYPE_CHECKING:
    from actspec.targets.network_file import NetworkFile


@dataclass(frozen=True, slots=True)
class Field:
    """One keyword of a cfg.

    Attributes:
        name: Keyword.
        value: Number, text or list; None keeps the USD's own number.
        note: What stands behind it: unit and origin.
        scalar: The cfg takes one value a group.
        file: The value is a file beside the module.
    """

    name: str
    value: float | str | list[int] | None
    note: str = ""
    scalar: bool = False
    file: bool = False


class Joint:
    """A joint and a dialect, with the losses and remarks that gather as fields are chosen.

    Raises: ValueError: the law lacks a number; it says which.
    """

    def __init__(
        self,
        actuator: JointActuator,
        dialect: IsaacLabDialect,
        step: float,
        target: str,
        network: tuple[NetworkFile, int] | None,
    ) -> None:
        self.actuator = actuator
        self.dialect = dialect
        self.step = step
        self.target = target
        self.network = network
        self.unit = actuator.effort_limit.unit
        self.speed_unit = actuator.velocity_limit.unit
        self.limit = actuator.effort_limit.require()
        self.gains_known = all(gain is None or gain.known for gain in (actuator.kp, actuator.kd))
        self.lost: list[Approximation] = []
        self.remarks: list[str] = []
        self.law = self._law()

    def _law(self) -> TorqueLaw:
        """The law; of a network or unknown gains its clamp, as a drive whose command is the torque."""
        actuator = self.actuator
        if actuator.level is Level.ACTUATOR_NET:
            return law_of(replace(network_clip(actuator), delay=None, filter_cutoff=None))
        return law_of(actuator if self.gains_known else replace(actuator, command=Command.EFFORT))

    def approximate(self, field: str, asked: str, emitted: str, why: str, error: float | None) -> None:
        """Record a loss; see `Approximation`."""
        self.lost.append(
            Approximation(self.target, self.actuator.joint, field, asked, emitted, why, error, self.unit)
        )

    def note(self, quantity: Quantity) -> str:
        """Unit, origin and formula, as a comment has them."""
        return "; ".join(filter(None, (quantity.unit, provenance(quantity), quantity.formula)))

    def curve_text(self, law: TorqueLaw) -> str:
        """A line or curve in words."""
        if law.curve is not None:
            drive, brake, knee, no_load = law.curve
            return (
                f"curve: drive {format_quantity(drive, self.unit)}, brake {format_quantity(brake, self.unit)}, "
                f"knee {knee:g}, no load {no_load:g} {self.speed_unit}"
            )
        return (
            f"line from {format_quantity(law.stall_torque, self.unit)} to "
            f"{format_quantity(law.no_load_speed, self.speed_unit)}"
        )

    def ms(self, steps: int) -> str:
        """A number of physics steps in words."""
        plural = "" if steps == 1 else "s"
        return f"{steps * self.step * 1e3:g} ms ({steps} step{plural} of {self.step * 1e3:g} ms)"

    @property
    def speed_limit(self) -> float | None:
        """The joint's speed limit [rad/s or m/s]; None: unknown."""
        return self.actuator.velocity_limit.value

    @property
    def opaque(self) -> bool:
        """Whether the torque of a command is not known here; it is at most from one limit to the other."""
        return self.network is not None or not self.gains_known

    def lost_step(self) -> float:
        """Size of a lost delay or filter [N*m or N]."""
        return held_step_error(self.law) if self.network is None else 2.0 * self.limit
