"""GEA: armature that does not follow from motor and gear."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.rule import Rule
from actspec.audit.rules.joint_units import shown, unit
from actspec.audit.rules.partners import by_joint, partner_rows
from actspec.audit.rules.reductions import figures, joints_above, reductions, same, states_speed
from actspec.diagnostics import Severity
from actspec.readings.artifact import FileKind
from actspec.units import format_quantity


class NotGearSquared(Rule):
    """An armature is not rotor inertia times gear squared.

    ## What it does
    Compares armatures with what motor and gear give, and reports those off by a factor of `ratio` (default 1.5):
    against the rotor inertia and gear of the robot's spec; and between two joints that a file gives one motor behind
    two reductions (equal effort times speed), where the armatures must differ by the square of the ratio.

    ## Why it matters
    Behind a gear the rotor is felt with the square of the ratio. With too little armature a joint is easier to
    accelerate than the real one, and gains that hold in simulation shake or sag on the robot.

    ## Example
    ```xml leg.urdf
    <robot name="leg">
      <link name="base"/>
      <link name="thigh"/>
      <link name="shank"/>
      <joint name="hip_joint" type="revolute">
        <parent link="base"/>
        <child link="thigh"/>
        <limit lower="-1" upper="1" effort="23.7" velocity="30.1"/>
      </joint>
      <joint name="knee_joint" type="revolute">
        <parent link="thigh"/>
        <child link="shank"/>
        <limit lower="-2" upper="0" effort="45.43" velocity="15.70"/>
      </joint>
    </robot>
    ```
    ```xml leg.xml
    <mujoco model="leg">
      <worldbody>
        <body>
          <joint name="hip_joint" armature="0.01" actuatorfrcrange="-23.7 23.7"/>
          <geom size="0.1"/>
          <body pos="0 0 -0.2">
            <joint name="knee_joint" armature="0.01" actuatorfrcrange="-45.43 45.43"/>
            <geom size="0.1"/>
          </body>
        </body>
      </worldbody>
    </mujoco>
    ```

    ## Use instead
    ```xml leg.xml
    <mujoco model="leg">
      <worldbody>
        <body>
          <joint name="hip_joint" armature="0.01" actuatorfrcrange="-23.7 23.7"/>
          <geom size="0.1"/>
          <body pos="0 0 -0.2">
            <joint name="knee_joint" armature="0.0367" actuatorfrcrange="-45.43 45.43"/>
            <geom size="0.1"/>
          </body>
        </body>
      </worldbody>
    </mujoco>
    ```

    ## Limits
    Between two joints, the one with less gear is taken for right. Inertia of the gear itself is not in it. An
    armature of 0 is GEA104's.

    ## Source
    Energy of a rotor behind a gear: I_joint = I_rotor N^2. Chosen: 1.5 leaves room for the gear's own inertia. mjlab's
    Go1 has 0.00403 and 0.00906 kg*m^2 for reductions that differ by 1.5: a factor of 2.25.
    """

    code = "GEA102"
    name = "armature-is-not-gear-squared"
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    paired = True
    options: ClassVar[dict[str, float]] = {"ratio": 1.5}

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Compare armatures with the spec's rotors and with the joints' reductions."""
        looked = False
        for found in (*self._against_spec(case), *self._against_limits(case)):
            looked = True
            if found is not None:
                yield found
        if not looked:
            yield Skipped(self.code, "no armature beside a rotor's inertia, or limits that show a reduction")

    def _off(self, case: Case, armature: float, expected: float) -> bool:
        ratio = self.option(case, "ratio")
        return armature >= ratio * expected or armature * ratio <= expected

    def _against_spec(self, case: Case) -> Iterator[Finding | None]:
        for index, artifact in case.of_kind(FileKind.SPEC):
            assert artifact.spec is not None
            actuators = {actuator.joint: actuator for actuator in artifact.spec.joints}
            for spec in case.rows_of(index):
                reflected = actuators[spec.joint].reflected_inertia
                if reflected.value is None or reflected.value <= 0.0:
                    continue
                for row in (spec, *partner_rows(case, spec)):
                    armature = row.armature
                    if armature is None or armature <= 0.0 or "armature" not in row.stated:
                        continue
                    if not self._off(case, armature, reflected.value):
                        yield None
                        continue
                    yield Finding(
                        self.code,
                        f"an armature of {shown(row, 'armature', armature)} is {armature / reflected.value:.3g} times "
                        f"the {shown(row, 'armature', reflected.value)} that the spec's rotor inertia has behind its "
                        "gear",
                        row.place("armature"),
                        row.joint,
                        armature,
                        unit(row, "armature"),
                        reflected.value,
                        "rotor inertia times the square of the whole reduction",
                        (reflected.span or spec.span,) if row is not spec else (),
                        confidence=Confidence.HIGH,
                    )

    def _against_limits(self, case: Case) -> Iterator[Finding | None]:
        known = case.once(figures)
        rows = {key: found[0] for key, found in by_joint(case).items()}
        for robot in case.robots:
            if not states_speed(known, robot):
                continue
            above = joints_above(case, robot)
            for reference in robot.artifacts:
                found = list(reductions(known.get(reference, {}), above))
                for other in robot.artifacts:
                    there = known.get(other, {})
                    seen = set()
                    for one in found:
                        name, base = one.joint.row.joint, one.base.row.joint
                        row, less = rows.get((other, name)), rows.get((other, base))
                        if (
                            name in seen
                            or row is None
                            or less is None
                            or not row.armature
                            or not less.armature
                        ):
                            continue
                        pairs = ((there.get(name), one.joint), (there.get(base), one.base))
                        # A file with other limits is GEA101's.
                        if not all(mine is None or same(mine.effort, its.effort) for mine, its in pairs):
                            yield None
                            continue
                        seen.add(name)
                        expected = less.armature * one.ratio**2
                        if not self._off(case, row.armature, expected):
                            yield None
                            continue
                        yield Finding(
                            self.code,
                            f"an armature of {shown(row, 'armature', row.armature)} does not fit the gear: a joint "
                            f"of the same power (effort times speed) and {one.ratio:.4g} times less reduction has "
                            f"{shown(row, 'armature', less.armature)}, which is {format_quantity(expected, '', 3)} "
                            f"here (times {one.ratio**2:.3g})",
                            row.place("armature"),
                            name,
                            row.armature,
                            unit(row, "armature"),
                            expected,
                            "rotor inertia times the square of the whole reduction, for each joint",
                            (one.joint.row.place("effort_limit"), one.base.row.place("effort_limit")),
                        )


RULES: tuple[type[Rule], ...] = (NotGearSquared,)
