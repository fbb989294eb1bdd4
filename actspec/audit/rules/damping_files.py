"""DMP: damping that two files of one robot both have."""

from __future__ import annotations

from collections.abc import Iterator
from os.path import basename
from typing import ClassVar

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.ledger import LedgerRow
from actspec.audit.rule import Rule
from actspec.audit.rules.damping_parts import same
from actspec.audit.rules.joint_units import shown, unit
from actspec.audit.rules.partners import by_joint, partner_rows
from actspec.diagnostics import Severity
from actspec.readings.artifact import FileKind, Framework


class GainBesideModelDamping(Rule):
    """A configuration's kd acts on joints that the model damps as strongly.

    ## What it does
    Compares the kd of a training or deploy configuration with the joint damping of the robot's MJCF. mjlab's drives
    act on the MJCF's own joints, so both brake: from `share` of kd (default 0.5) this is a warning, and an error where
    damping is kd or more and the joint is overdamped by the sum. For other configurations it is a remark about
    running the policy on that MJCF: from kd on, where the MJCF has motors or bare joints.

    ## Why it matters
    The joint is damped by the sum. Policies trained so expect a joint that resists more than the robot's, and
    torque limits do not bind the passive part.

    ## Example
    ```xml leg.xml
    <mujoco model="leg">
      <worldbody>
        <body>
          <joint name="hip_joint" damping="2"/>
          <geom size="0.1"/>
          <body pos="0 0 -0.2">
            <joint name="knee_joint" damping="2"/>
            <geom size="0.1"/>
          </body>
        </body>
      </worldbody>
    </mujoco>
    ```
    ```python leg_constants.py
    from mjlab.actuator import BuiltinPositionActuatorCfg
    from mjlab.entity import EntityArticulationInfoCfg

    LEG_ACTUATOR = BuiltinPositionActuatorCfg(
        target_names_expr=(".*_joint",), stiffness=20.0, damping=2.0, effort_limit=30.0
    )
    LEG_ARTICULATION = EntityArticulationInfoCfg(actuators=(LEG_ACTUATOR,))
    ```

    ## Use instead
    ```xml leg.xml
    <mujoco model="leg">
      <worldbody>
        <body>
          <joint name="hip_joint" damping="0.05"/>
          <geom size="0.1"/>
          <body pos="0 0 -0.2">
            <joint name="knee_joint" damping="0.05"/>
            <geom size="0.1"/>
          </body>
        </body>
      </worldbody>
    </mujoco>
    ```

    ## Limits
    Silent where the configuration states the passive part itself (`viscous_damping`, `viscous_friction`). What Isaac
    Lab reads is a USD or a URDF; the MJCF is then only where the policy is tried out.

    ## Source
    mjlab 1.6.0, measured: `viscous_damping=None` keeps the XML's joint damping, and the drive's kd comes on top.
    Reports: LeCAR-Lab/dial-mpc#1, mujocolab/mjlab#518 (joint damping 0.56 beside a DC motor class).
    """

    code = "DMP105"
    name = "cfg-kd-and-model-damping"
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    paired = True
    options: ClassVar[dict[str, float]] = {"share": 0.5}

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Compare kd with the model's damping."""
        looked = False
        for rows in by_joint(case, FileKind.CFG, FileKind.DEPLOY).values():
            row = rows[0]
            if row.kd is None:
                continue
            for model in _first_rows(case, row, FileKind.MJCF):
                if model.joint_damping is None:
                    continue
                looked = True
                if row.kd <= 0.0 or model.joint_damping <= 0.0 or "joint_damping" in row.stated:
                    continue
                found = self._compare(case, row, model, row.kd, model.joint_damping)
                if found is not None:
                    yield found
        if not looked:
            yield Skipped(self.code, "no configuration with a kd beside an MJCF of the same robot")

    def _compare(
        self, case: Case, row: LedgerRow, model: LedgerRow, kd: float, damping: float
    ) -> Finding | None:
        total = f"together {shown(row, 'kd', kd + damping)}"
        figures = f"a joint damping of {shown(row, 'kd', damping)}"
        file = basename(row.file)
        config = case.artifacts[row.artifact].config
        if config is not None and config.framework is Framework.MJLAB:
            if damping < self.option(case, "share") * kd:
                return None
            # The row's ratio is that with the first MJCF of the robot, which this one need not be.
            alone = (
                row.damping_ratio * kd / row.total_damping
                if row.damping_ratio and row.total_damping
                else None
            )
            told, absurd = "", False
            if alone is not None:
                ratio = alone * (kd + damping) / kd
                told = f", a damping ratio of {ratio:.2g} instead of {alone:.2g}"
                absurd = damping >= kd and ratio >= 1.0
            message = (
                f"the drive of {file} brakes with kd {shown(row, 'kd', kd)}, and {figures} stays beside it, "
                f"outside the torque limit: {total}{told}"
            )
            severity, confidence = (
                (Severity.ERROR, Confidence.HIGH) if absurd else (self.severity, self.confidence)
            )
        else:
            if damping < kd or model.control not in ("motor", "none"):
                return None
            message = (
                f"with the kd of {shown(row, 'kd', kd)} from {file}, this joint of the MJCF brakes with {figures} "
                f"as well: {total}, which that configuration does not have"
            )
            severity, confidence = Severity.INFO, self.confidence
        return Finding(
            self.code,
            message,
            model.place("joint_damping"),
            row.joint,
            damping,
            unit(row, "kd"),
            help="leave only the measured friction in the joint damping, or state it in the configuration",
            related=(row.place("kd"),),
            severity=severity,
            confidence=confidence,
        )


class UrdfDamping(Rule):
    """The damping of a URDF is not that of the robot's other files, and means four things.

    ## What it does
    Reports joints whose URDF has `<dynamics damping=...>` above 0, where an MJCF or spec of the robot has another
    passive damping, or where it is `share` (default 0.1) or more of a configuration's kd that states no passive part.

    ## Why it matters
    The same tag is joint damping in MuJoCo's URDF loader, the drive's kd in Newton, passive damping again in the
    URDF-to-USD converter, and nothing in Isaac Sim 6.1. A number that is right in one of them is a second D gain, or
    none at all, in the next.

    ## Example
    ```xml leg.urdf
    <robot name="leg">
      <link name="base"/>
      <link name="shank"/>
      <joint name="knee_joint" type="revolute">
        <parent link="base"/>
        <child link="shank"/>
        <axis xyz="0 1 0"/>
        <limit lower="-2" upper="0" effort="33.5" velocity="21"/>
        <dynamics damping="0.5"/>
      </joint>
    </robot>
    ```
    ```xml leg.xml
    <mujoco model="leg">
      <worldbody>
        <body>
          <joint name="knee_joint" damping="0.01"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
    </mujoco>
    ```

    ## Use instead
    ```xml leg.urdf
    <robot name="leg">
      <link name="base"/>
      <link name="shank"/>
      <joint name="knee_joint" type="revolute">
        <parent link="base"/>
        <child link="shank"/>
        <axis xyz="0 1 0"/>
        <limit lower="-2" upper="0" effort="33.5" velocity="21"/>
        <dynamics damping="0.01"/>
      </joint>
    </robot>
    ```

    ## Limits
    Which importer reads the URDF no file says.

    ## Source
    Importers' source text and issues: MuJoCo xml_urdf.cc, Newton import_urdf.py, isaac-sim/IsaacSim#841. Training
    code that sets it to 0 for that reason: Improbable-AI/walk-these-ways#13.
    """

    code = "DMP106"
    name = "urdf-damping-has-four-meanings"
    severity = Severity.INFO
    confidence = Confidence.MEDIUM
    paired = True
    options: ClassVar[dict[str, float]] = {"share": 0.1}

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Compare the URDF's damping with the other files'."""
        looked = False
        for rows in by_joint(case, FileKind.URDF).values():
            row = rows[0]
            damping = row.joint_damping
            if damping is None or damping <= 0.0:
                continue
            for other in _first_rows(case, row, FileKind.MJCF, FileKind.SPEC, FileKind.CFG):
                looked = True
                told = self._other(case, other, damping)
                if told is not None:
                    yield Finding(
                        self.code,
                        f"the URDF's damping of {shown(row, 'kd', damping)} meets {told} in {basename(other.file)}: "
                        "it is joint damping in MuJoCo, the drive's kd in Newton and nothing in Isaac Sim 6.1",
                        row.place("joint_damping"),
                        row.joint,
                        damping,
                        unit(row, "kd"),
                        help="give the URDF the friction that the other files have, or 0 where they hold it all",
                        related=(other.place("joint_damping"),),
                    )
        if not looked:
            yield Skipped(self.code, "no URDF with damping beside another file of the same robot")

    def _other(self, case: Case, other: LedgerRow, damping: float) -> str | None:
        """What the other file has instead; None where they agree or nobody can tell."""
        passive = other.joint_damping
        if case.artifacts[other.artifact].kind is not FileKind.CFG or "joint_damping" in other.stated:
            if passive is None or same(passive, damping):
                return None
            return f"a joint damping of {shown(other, 'kd', passive)}"
        if other.kd is None or other.kd <= 0.0 or damping < self.option(case, "share") * other.kd:
            return None
        return f"a kd of {shown(other, 'kd', other.kd)} and no passive part"


def _first_rows(case: Case, row: LedgerRow, *kinds: FileKind) -> Iterator[LedgerRow]:
    """Rows of the same joint in the robot's other files, one each file."""
    seen = set()
    for other in partner_rows(case, row, *kinds):
        if other.artifact not in seen:
            seen.add(other.artifact)
            yield other


RULES: tuple[type[Rule], ...] = (GainBesideModelDamping, UrdfDamping)
