"""One report with everything in it that a format could trip over."""

from __future__ import annotations

import math

from actspec.audit.case import Case
from actspec.audit.engine import judge
from actspec.audit.finding import Confidence, Fix, Safety, Skipped, TextEdit
from actspec.audit.outcome import Report
from actspec.audit.rules.aud008 import Unreadable
from actspec.audit.settings import Settings
from actspec.diagnostics import Diagnostic, Severity, Span
from actspec.ir import JointKind
from actspec.readings.artifact import Artifact, FileKind, FileReading, Robot
from actspec.robot.view import ModelFile
from tests.audit.making import finding, row, rule_of

XML = """<mujoco>
\t<joint name="öl😀"/> <motor joint="hip"/>
  <motor joint="knee"/>
</mujoco>
"""
URDF = '<robot name="leg">\n<joint name="hip"/>\n</robot>\n'
EVIL = "<script>alert(1)</script>|\"'&\x07\n[a](b)@me #1 %41,:\ud800"
"""A name that is markup, a command or a control character somewhere."""


def report() -> Report:
    """Three joints of one fault in a.xml, one of two files, one of a whole file; one unread, one gone; a mute rule."""
    fix = Fix("Set forcerange", Safety.UNSAFE, (TextEdit("a.xml", 10, 12, b"xx"),))
    first = rule_of(
        "LIM901",
        "first-rule",
        *(
            finding(
                "LIM901",
                line=line,
                column=22,
                joint=joint,
                message="no limit, got 0 N*m",
                value=math.inf,
                unit="N*m",
                expected=33.5,
                help="add one",
                fix=fix,
            )
            for line, joint in ((2, "hip"), (3, "knee"), (3, "ankle"))
        ),
        severity=Severity.ERROR,
    )
    second = rule_of(
        "SRC901",
        "second-rule",
        finding(
            "SRC901", "b.urdf", 2, 0, joint="hip", message="50 here, 35 there", related=(Span("a.xml", 3, 3),)
        ),
        finding("SRC901", "we ird%.xml", 0, 0, message=f"bad {EVIL}", severity=Severity.INFO),
        confidence=Confidence.MEDIUM,
    )
    skipped = rule_of("NET901", "third-rule", Skipped("NET901", "no network among the files"))
    return judge(_case(), Settings(), (first, second, skipped, Unreadable))


def _case() -> Case:
    note = Diagnostic("ROBOT113", Severity.INFO, "1 joint left out", "", Span("a.xml"))
    fault = Diagnostic("ROBOT004", Severity.ERROR, "this is not XML", "", Span("secret.txt", 1, 1))
    gone = Diagnostic("AUD016", Severity.ERROR, "there is no such file", "", Span("gone.xml"))
    files = (
        _reading("a.xml", FileKind.MJCF, XML, note),
        _reading("b.urdf", FileKind.URDF, URDF),
        # Its bytes must never be shown.
        FileReading(
            "secret.txt", None, "not XML", (), (ModelFile("secret.txt", "", b"password\n"),), (fault,)
        ),
        FileReading("gone.xml", None, "there is no such file", diagnostics=(gone,)),
    )
    artifacts = tuple(artifact for file in files for artifact in file.artifacts)
    rows = (
        row("a.xml", "hip", kp=50.0, kd_clamped=True, effort_limit=50.0, armature=0.0, kind=JointKind.HINGE),
        row("a.xml", "knee", kp=50.0, effort_limit=50.0, armature=0.0, kind=JointKind.HINGE),
        row("a.xml", "ankle", kp=20.0, effort_limit=math.inf, armature=0.0, kind=JointKind.HINGE),
        row("a.xml", "rail", kp=1e4, armature=0.0, kind=JointKind.SLIDE),
        row("b.urdf", "hip", 1, effort_limit=35.0, control="none", kind=JointKind.HINGE),
        row("b.urdf", "knee", 1, effort_limit=50.1, control="none", kind=JointKind.HINGE),
        row("b.urdf", EVIL, 1, velocity_limit=21.0, control="none", kind=JointKind.HINGE),
    )
    return Case(files, artifacts, rows, (Robot("leg", (0, 1)),))


def _reading(path: str, kind: FileKind, text: str, *diagnostics: Diagnostic) -> FileReading:
    file = ModelFile(path, "", text.encode())
    return FileReading(path, kind, None, (Artifact(path, kind, "leg"),), (file,), diagnostics)
