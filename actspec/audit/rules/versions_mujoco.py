"""VER: what only some releases of MuJoCo read."""

from __future__ import annotations

from collections.abc import Iterator

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.rule import Rule
from actspec.audit.rules.actuator_texts import WrittenActuator, written_actuators
from actspec.audit.rules.mujoco_features import WORDS, Feature, used_features
from actspec.diagnostics import Severity, Span
from actspec.readings.artifact import FileKind
from actspec.readings.versions import Meant, Release, mujoco_of
from actspec.robot.xml import parse_document

_TORQUE_SPACE = (3, 12)
_VOLTAGE_INPUTS = frozenset({"position", "velocity"})
_TORQUE_INPUTS = frozenset({"pos", "vel", "ff", "none"})


class DcmotorDialect(Rule):
    """A `dcmotor` is written in the dialect of another MuJoCo.

    ## What it does
    Reports dcmotors with `input="position"` or `"velocity"`, which MuJoCo 3.7 to 3.11 reads, and with `"pos"`, `"vel"`,
    `"ff"` or `"none"`, which 3.12 and later reads: an error where the named version is on the other side or one file
    has both, a remark for the older dialect alone. Controller gains without such an `input` are always an error.

    ## Why it matters
    The gains are in V/rad in the older dialect and in N*m/rad in the newer, and differ by R/K. A file of one dialect
    does not load in the other; with `input` left out, 3.7 to 3.11 take it for a motor that is driven by voltage, and
    the controller has no effect: a command of 0.5 rad becomes half a volt.

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
        <dcmotor joint="knee" nominal="24 45 30" saturation="24 0 0" controller="80 0 2 0 0 24"/>
      </actuator>
    </mujoco>
    ```

    ## Use instead
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="knee"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <dcmotor joint="knee" nominal="24 45 30" saturation="24 0 0" input="pos" controller="80 0 2 0 0 24"/>
      </actuator>
    </mujoco>
    ```

    ## Source
    MuJoCo 3.7, 3.11, 3.12, 3.17 and 4.0, measured; the changelog of 3.12; mujocolab/mjlab#1041.
    """

    code = "VER102"
    name = "dcmotor-dialect"
    severity = Severity.ERROR
    confidence = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Tell the dialects apart."""
        meant = mujoco_of(case.versions)
        looked = False
        motors: dict[str, list[tuple[WrittenActuator, str]]] = {}
        for found in written_actuators(case, b"<dcmotor"):
            if found.element.tag == "dcmotor":
                looked = True
                motors.setdefault(found.artifact.path, []).append((found, _dialect(found)))
        for members in motors.values():
            voltage = [found for found, dialect in members if dialect == "voltage"]
            torque = [found for found, dialect in members if dialect == "torque"]
            for found, dialect in members:
                finding = self._open_loop(found) if dialect == "" else None
                if dialect == "voltage":
                    finding = self._voltage(found, meant, torque)
                elif dialect == "torque":
                    finding = self._torque(found, meant, voltage)
                if finding is not None:
                    yield finding
        if not looked:
            yield Skipped(self.code, "no dcmotor among the files")

    def _open_loop(self, found: WrittenActuator) -> Finding | None:
        if not any(found.text.gain[slot] for slot in (4, 5, 6)):
            return None
        return Finding(
            self.code,
            "controller gains without an input that closes the loop: MuJoCo 3.7 to 3.11 drives this motor by voltage "
            "and ignores them, and 3.12 and later refuses the file",
            found.view.span,
            found.joint,
            help='add input="pos" (3.12 and later, gains in N*m/rad) or input="position" (3.7 to 3.11, gains in V/rad)',
        )

    def _voltage(
        self, found: WrittenActuator, meant: Meant | None, torque: list[WrittenActuator]
    ) -> Finding | None:
        written = _input(found)
        text = f'input="{written}" is the dialect of MuJoCo 3.7 to 3.11, with gains in V/rad'
        if meant is None and not torque:
            return self._finding(found, f"{text}: 3.12 and later refuses the file", (), Severity.INFO)
        if meant is not None:
            return None if meant.before(_TORQUE_SPACE) else self._refused(found, text, meant)
        other = torque[0]
        return self._finding(
            found,
            f'{text}, and input="{_input(other)}" that of 3.12 and later: no release loads this file',
            (other.view.span,),
            self.severity,
        )

    def _torque(
        self, found: WrittenActuator, meant: Meant | None, voltage: list[WrittenActuator]
    ) -> Finding | None:
        # Beside the other dialect one finding is enough, and the older one has to be changed.
        if meant is None or not meant.before(_TORQUE_SPACE):
            return None
        text = f'input="{_input(found)}" is the dialect of MuJoCo 3.12 and later, with gains in N*m/rad'
        return self._refused(found, text, meant)

    def _refused(self, found: WrittenActuator, text: str, meant: Meant) -> Finding:
        return self._finding(found, f"{text}: {meant.text} refuses the file", (), self.severity)

    def _finding(
        self, found: WrittenActuator, text: str, related: tuple[Span, ...], severity: Severity
    ) -> Finding:
        return Finding(
            self.code,
            text,
            found.view.span,
            found.joint,
            help=_translation(found),
            related=related,
            severity=severity,
        )


def _input(found: WrittenActuator) -> str:
    owner = found.owner("input")
    return " ".join((owner.get("input") or "").split()) if owner is not None else ""


def _dialect(found: WrittenActuator) -> str:
    """`voltage` (3.7 to 3.11), `torque` (3.12 and later), or "" for a motor that both drive by voltage."""
    words = set(_input(found).split())
    if words & _VOLTAGE_INPUTS:
        return "voltage"
    return "torque" if words & _TORQUE_INPUTS else ""


def _translation(found: WrittenActuator) -> str:
    """The same motor in the other dialect: R/K turns torque into voltage, and back-EMF is K w."""
    resistance, constant, kp, kd = (found.text.gain[slot] for slot in (0, 1, 4, 6))
    if not (resistance > 0.0 and constant > 0.0):
        return "K/R times a gain in V/rad is the gain in N*m/rad"
    ratio = resistance / constant
    if _dialect(found) == "voltage":
        if "velocity" in _input(found):
            return f'from 3.12 on: input="vel" with the gains times {1.0 / ratio:.3g}'
        return (
            f'from 3.12 on: input="pos" with kp {kp / ratio:.3g} N*m/rad and kd {kd / ratio + constant / ratio:.3g} '
            "N*m*s/rad as first and third number of the controller"
        )
    return (
        f'up to 3.11: input="position" with {kp * ratio:.3g} V/rad and {kd * ratio - constant:.3g} V*s/rad as first '
        "and third number of the controller"
    )


class NeedsAnotherMujoco(Rule):
    """The file needs another MuJoCo than the one that it is meant for.

    ## What it does
    Reports elements and attributes that the named MuJoCo (`--target mujoco==3.6`, or the one that the named mjlab
    takes) does not know yet, or no longer; and, without a named version, a file that has things which no single
    release reads together.

    ## Why it matters
    MuJoCo refuses a whole file for one attribute that it does not know. A model that is written for the newest release
    does not load where mjlab or Isaac Lab hold an older one.

    ## Example
    ```sh
    actspec audit robot.xml --target mujoco==3.6
    ```
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="knee"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <position joint="knee" kp="20" kv="1" armature="0.01" forcerange="-24 24"/>
      </actuator>
    </mujoco>
    ```

    ## Use instead
    ```xml
    <mujoco>
      <worldbody>
        <body>
          <joint name="knee" armature="0.01"/>
          <geom size="0.1"/>
        </body>
      </worldbody>
      <actuator>
        <position joint="knee" kp="20" kv="1" forcerange="-24 24"/>
      </actuator>
    </mujoco>
    ```

    ## Limits
    Only what actuators and joints are made of is looked at. `3.1` stands for any patch release of 3.1. The two dialects
    of `dcmotor` are VER102.

    ## Source
    MuJoCo 2.3.7 to 4.0, measured: the first release of which the Python package loads each of them.
    """

    code = "VER105"
    name = "needs-another-mujoco"
    severity = Severity.ERROR
    confidence = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Compare each file with the release."""
        meant = mujoco_of(case.versions)
        looked = False
        words = {word for feature, word in WORDS if _may_be_told(feature, meant)}
        for _, artifact in case.of_kind(FileKind.MJCF):
            if artifact.robot is None:
                continue
            looked = True
            if not any(word in file.data for file in artifact.robot.files for word in words):
                continue
            document = parse_document(artifact.robot.files)
            used = used_features(document)
            if meant is not None:
                yield from self._against(used, meant)
            else:
                yield from self._together(used)
        if not looked:
            yield Skipped(self.code, "no MJCF among the files")

    def _against(self, used: dict[Feature, list[Span]], meant: Meant) -> Iterator[Finding]:
        for feature, places in used.items():
            if meant.before(feature.since):
                text = f"came with MuJoCo {_text(feature.since)}: {meant.text} refuses the file"
                help = f"use MuJoCo {_text(feature.since)} or later, or leave it out"
            elif feature.until is not None and meant.release[:2] > feature.until:
                text = f"went after MuJoCo {_text(feature.until)}: {meant.text} refuses the file"
                help = "write actuatorfrcrange"
            else:
                continue
            yield Finding(self.code, f"{feature.what}{_count(places)} {text}", places[0], help=help)

    def _together(self, used: dict[Feature, list[Span]]) -> Iterator[Finding]:
        newest = max(used, key=lambda feature: feature.since, default=None)
        for feature, places in used.items():
            if newest is not None and feature.until is not None and newest.since > feature.until:
                yield Finding(
                    self.code,
                    f"{feature.what}{_count(places)} went after MuJoCo {_text(feature.until)}, and {newest.what} came "
                    f"with {_text(newest.since)}: no release reads this file",
                    places[0],
                    help="write actuatorfrcrange",
                    related=(used[newest][0],),
                )


def _may_be_told(feature: Feature, meant: Meant | None) -> bool:
    """Whether there is something to say about it."""
    if meant is None:
        return feature.until is not None
    gone = feature.until is not None and meant.release[:2] > feature.until
    return gone or meant.before(feature.since)


def _text(release: Release) -> str:
    return ".".join(map(str, release))


def _count(places: list[Span]) -> str:
    return f" (in {len(places)} places)" if len(places) > 1 else ""


RULES: tuple[type[Rule], ...] = (DcmotorDialect, NeedsAnotherMujoco)
