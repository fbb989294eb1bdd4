"""LIM: limits that are missing, or that are no limits."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import ClassVar

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.ledger import LedgerRow
from actspec.audit.rule import Rule
from actspec.audit.rules.actuator_texts import written_actuators
from actspec.audit.rules.joint_units import shown, unit
from actspec.diagnostics import Severity, Span
from actspec.readings.artifact import FileKind
from actspec.robot.mjcf_actuator_text import numbers


class NoLimit(Rule):
    """Nothing limits what an actuator of an MJCF can give.

    ## What it does
    Reports an MJCF actuator that has no `forcerange`, whose joint has no `actuatorfrcrange`, and whose control range
    or voltage does not bound the torque either. Silent where a configuration of the same robot limits the joint, and
    of muscles, dampers and plugins, which have bounds of their own.

    ## Why it matters
    The simulated motor gives whatever it is asked for. A policy trained on it learns to ask for torques that the
    real one does not have: it jumps in simulation and falls on the robot.

    ## Example
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="knee"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <motor joint="knee" gear="9.1"/>
      </actuator>
    </mujoco>
    ```

    ## Use instead
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="knee" actuatorfrcrange="-33.5 33.5"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <motor joint="knee" gear="9.1"/>
      </actuator>
    </mujoco>
    ```

    ## Limits
    A limit in the code that drives the simulator (an external PD that clips) is not seen: name its configuration on
    the same command line, or set the finding aside with a reason.

    ## Source
    MuJoCo documentation, XML reference: `forcelimited`, `actuatorfrcrange`, both without a limit by default. Of 110
    MJCF of vendors and training code, 5 have such motors.
    """

    code = "LIM101"
    name = "no-limit-of-any-kind"
    severity = Severity.WARNING
    confidence = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find actuators of MJCF files without any clamp."""
        looked = False
        for index, _ in case.of_kind(FileKind.MJCF):
            limited = _limited_elsewhere(case, index)
            for row in case.rows_of(index):
                if row.control == "none" or not row.joint:
                    continue
                looked = True
                if row.effort_limit == math.inf and row.joint not in limited and not _is_bounded(row):
                    yield Finding(
                        self.code,
                        "no force range, joint limit or control range limits this actuator: it gives every "
                        f"{unit(row, 'effort_limit')} that it is asked for",
                        row.span,
                        row.joint,
                        help="add actuatorfrcrange to the joint, or forcerange to the actuator",
                    )
        if not looked:
            yield Skipped(self.code, "no MJCF with actuators on joints among the files")


class PlaceholderLimit(Rule):
    """A limit is so large that it is none.

    ## What it does
    Reports an effort or velocity limit, as a file states it, of `least` or more (default 1e5 N*m, N, rad/s or m/s).

    ## Why it matters
    Numbers such as `1e9` stand in files because a tool wanted one. They read like data and act like no limit at all:
    torque clamps never bind, and speed limits that a solver enforces never brake.

    ## Example
    ```xml
    <robot name="leg">
      <link name="base"/>
      <link name="shank"/>
      <joint name="knee" type="revolute">
        <parent link="base"/>
        <child link="shank"/>
        <axis xyz="0 1 0"/>
        <limit lower="-2" upper="0" effort="1e9" velocity="21"/>
      </joint>
    </robot>
    ```

    ## Use instead
    ```xml
    <robot name="leg">
      <link name="base"/>
      <link name="shank"/>
      <joint name="knee" type="revolute">
        <parent link="base"/>
        <child link="shank"/>
        <axis xyz="0 1 0"/>
        <limit lower="-2" upper="0" effort="33.5" velocity="21"/>
      </joint>
    </robot>
    ```

    ## Limits
    A limit that no file states (an engine's default) is not reported here.

    ## Source
    Chosen: far above every joint of a legged machine; the placeholders in published files are 1e6 (the drive
    ceiling of importers) and 1e9 (Isaac Lab's default for explicit actuators).
    """

    code = "LIM102"
    name = "limit-is-a-placeholder"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    options: ClassVar[dict[str, float]] = {"least": 1e5}

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find limits that no motor reaches."""
        least = self.option(case, "least")
        looked = False
        for row in case.rows:
            for field in ("effort_limit", "velocity_limit"):
                limit: float | None = getattr(row, field)
                if limit is None or field not in row.stated:
                    continue
                looked = True
                if least <= limit < math.inf:
                    noun = field.replace("_", " ")
                    yield Finding(
                        self.code,
                        f"the {noun} of {shown(row, field, limit, 6)} is a placeholder: no motor reaches it, and "
                        "it limits nothing",
                        row.place(field),
                        row.joint,
                        limit,
                        unit(row, field),
                        help=f"state the motor's {noun}",
                    )
        if not looked:
            yield Skipped(self.code, "no file states an effort or velocity limit")


def _is_bounded(row: LedgerRow) -> bool:
    """Whether the voltage of a dcmotor bounds its torque, or the actuator is no motor that could give any."""
    # Only a dcmotor whose control is its voltage has back-EMF beside no other gain.
    voltage = row.stall_torque is not None or (bool(row.back_emf) and row.command_range is not None)
    return voltage if row.control == "dcmotor" else row.control == "other" and row.kd is None


def _limited_elsewhere(case: Case, artifact: int) -> set[str]:
    """Joints that a configuration of the same robot limits."""
    others = [i for i in case.robot_of(artifact).artifacts if case.artifacts[i].kind is FileKind.CFG]
    rows = [row for other in others for row in case.rows_of(other)]
    return {row.joint for row in rows if row.effort_limit is not None and row.effort_limit < math.inf}


class ZeroLimit(Rule):
    """A limit of 0 stands for no limit in one engine and for a dead joint in another.

    ## What it does
    Reports moving joints whose effort or velocity limit is 0: in a URDF, in an actuator's `forcerange`, in a
    configuration. Fixed and mimic joints, and drives whose
    gains are 0 too, are left alone.

    ## Why it matters
    MuJoCo reads a URDF effort of 0 and a range of `0 0` as no limit. A tool that sets up drives from the URDF takes
    the same 0 for a motor that can give nothing, and Isaac Lab's explicit drives clip to 0.

    ## Example
    ```xml
    <robot name="finger">
      <link name="palm"/>
      <link name="tip"/>
      <joint name="finger" type="revolute">
        <parent link="palm"/>
        <child link="tip"/>
        <axis xyz="0 1 0"/>
        <limit lower="-2" upper="0" effort="0" velocity="3.14"/>
      </joint>
    </robot>
    ```

    ## Use instead
    ```xml
    <robot name="finger">
      <link name="palm"/>
      <link name="tip"/>
      <joint name="finger" type="revolute">
        <parent link="palm"/>
        <child link="tip"/>
        <axis xyz="0 1 0"/>
        <limit lower="-2" upper="0" effort="0.93" velocity="3.14"/>
      </joint>
    </robot>
    ```

    ## Limits
    Joints that a mapping by pattern leaves out get 0 in Isaac Lab too: CFG101.

    ## Source
    MuJoCo, xml_urdf.cc: a range is set only for an effort above 0; 4.0, measured: `forcerange="0 0"` compiles to no
    limit. Of 59 published URDF one has it: 16 of 20 joints of a right hand, whose left hand has 0.93 N*m on all.
    """

    code = "LIM103"
    name = "limit-of-zero"
    severity = Severity.WARNING
    confidence = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find limits of 0, and ranges from 0 to 0."""
        looked = False
        mimics = _mimics(case)
        empty = _empty_ranges(case)
        for row in case.rows:
            if row.span in empty and row.effort_limit == math.inf:
                looked = True
                yield self._finding(row, "effort_limit", _EMPTY_RANGE)
            for field in ("effort_limit", "velocity_limit"):
                limit: float | None = getattr(row, field)
                if limit is None or field not in row.stated:
                    continue
                looked = True
                if limit != 0.0 or (row.artifact, row.joint) in mimics or row.kp == row.kd == 0.0:
                    continue
                yield self._finding(row, field, self._effect(case, row, field))
        if not looked:
            yield Skipped(self.code, "no file states an effort or velocity limit")

    def _effect(self, case: Case, row: LedgerRow, field: str) -> str:
        if case.artifacts[row.artifact].kind is FileKind.URDF:
            return _URDF[field]
        return f"the {_noun(field)} is 0: the drive cannot move the joint"

    def _finding(self, row: LedgerRow, field: str, message: str) -> Finding:
        return Finding(
            self.code,
            message,
            row.place(field),
            row.joint,
            0.0,
            unit(row, field),
            help=f"state the motor's {_noun(field)}",
        )


_URDF = {
    "effort_limit": "the URDF's effort is 0: MuJoCo reads it as no limit, and a tool that sets up drives from it as a "
    "joint that can give nothing",
    "velocity_limit": "the URDF's velocity is 0: MuJoCo leaves it out, and a solver that enforces it holds the joint",
}
_EMPTY_RANGE = 'forcerange="0 0" is no limit: MuJoCo takes an empty range for none'


def _noun(field: str) -> str:
    return field.replace("_", " ")


def _mimics(case: Case) -> set[tuple[int, str]]:
    """Joints that follow another one and have no motor."""
    return {
        (index, joint.name)
        for index, artifact in case.of_kind(FileKind.URDF)
        if artifact.robot is not None
        for joint in artifact.robot.joints
        if joint.mimic is not None
    }


def _empty_ranges(case: Case) -> set[Span]:
    """Places of actuators that have the range from 0 to 0 written."""
    actuators = (
        actuator
        for _, artifact in case.of_kind(FileKind.MJCF)
        if artifact.robot is not None
        for actuator in artifact.robot.actuators
    )
    if not any(actuator.force_range is None and "forcerange" in actuator.stated for actuator in actuators):
        return set()
    return {
        found.view.span
        for found in written_actuators(case, b"forcerange")
        if "forcerange" in found.element.attributes
        and numbers(found.element.attributes["forcerange"].value, 2) == (0.0, 0.0)
    }


RULES: tuple[type[Rule], ...] = (NoLimit, PlaceholderLimit, ZeroLimit)
