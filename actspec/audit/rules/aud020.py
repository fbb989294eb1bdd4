from __future__ import annotations

import re
from collections.abc import Iterator

from actspec.audit.finding import quoted
from actspec.audit.rule import Case, Confidence, Finding, Rule, Severity
from actspec.diagnostics import Span, one_line
from actspec.patterns import is_slip
from actspec.readings.artifact import Artifact, FileReading
from actspec.readings.including import place_of_include
from actspec.readings.versions import mujoco_of
from actspec.simulators import text_of

_BY_RELEASE = re.compile(
    r"unrecognized (?:attribute: '(\w+)'|element)|no longer supported|orientation specifier"
    r"|plugin mujoco\.elasticity\.\w+ not found|for mesh geoms, inertia should be specified"
    r"|at most one of '|bad format in attribute|zero quaternion|top-level default class|flex"
)
"""Reasons of MuJoCo that another release may not have; what no joint is, none has.

Source: the wheels' plugin folders: 4.0.0 has no libelasticity (cable, shell, solid) any more. Measured: 3.2.6 takes
shellinertia of a geom with a mesh; 2.2.0 reads `pos="0,0,0"`, two orientations and a quaternion of zeros, 2.3.7 the
last of these, and 3.1.6 a default of another name than main at the top.
"""

_OF_FLEX = re.compile(r"\bpin\w* out of range|no decoder found for mesh|unknown element '\w*_\d+'")
_FLEX_FILE = re.compile(rb"<flexcomp\b[^<>]*\bfile\s*=")
"""What MuJoCo says of a flexcomp whose mesh has other vertices, and a flexcomp with a file, which is not read."""

_OWN_PLUGIN = re.compile(r"plugin (?!mujoco\.)\S+ not found")
"""One that does not come with MuJoCo: a program loads its library before the model."""

_SHORT = 3
"""Letters up to which an attribute is no other one's slip. Chosen: `kp`, `rgb`, `key`."""


class RefusedModel(Rule):
    code = "AUD020"
    name = "refused-model"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    written_over = frozenset({"compiled"})

    def check(self, case: Case) -> Iterator[Finding]:
        # In a folder, of a model that no program names, AUD013 says it: it may be for another MuJoCo.
        for file in case.files:
            for artifact in file.refused_models:
                message, help, severity = "the model does not compile in the installed MuJoCo", None, None
                if file.whole is not None:
                    whole = one_line(file.whole)
                    message, severity = (
                        f"the model compiles only in {whole}, which includes it",
                        Severity.INFO,
                    )
                    help = f"audit {whole} in its place"
                elif (needs := _needs(file, artifact.text_only or "")) is not None:
                    message, severity = f"the model compiles only with {needs}", Severity.INFO
                elif (older := _older(case, file, artifact)) is not None:
                    message, severity = f"{message} {older}", Severity.INFO
                place, related = _place(case, file, artifact)
                yield Finding(
                    self.code,
                    f"{message}, and is judged from its text alone: {artifact.text_only}",
                    place,
                    related=related,
                    about=" ".join(quoted(artifact.text_only or "")),
                    help=help,
                    severity=severity,
                )


def _place(case: Case, file: FileReading, artifact: Artifact) -> tuple[Span, tuple[Span, ...]]:
    """Where MuJoCo refuses it; where that is in a model that compiles by itself, the include, which is at fault."""
    at = artifact.refused_at or Span(file.path)
    if at.path != file.path and any(other.path == at.path and other.compiles for other in case.files):
        return place_of_include(file, at.path), (at,)
    return at, ()


def _needs(file: FileReading, reason: str) -> str | None:
    """What MuJoCo lacks of a model that nobody but its user has, or that is not read."""
    if _OWN_PLUGIN.search(reason):
        return "the library of its plugin, which a program has to load"
    if _OF_FLEX.search(reason) and any(_FLEX_FILE.search(part.data) for part in file.files):
        return "the file of its flexcomp, which is not read"
    return None


def _older(case: Case, file: FileReading, artifact: Artifact) -> str | None:
    """The installed release with what asks for an older one, which is what was said before what a project says."""
    reason = _BY_RELEASE.search(artifact.text_only or "")
    if file.refused_by is None or reason is None or (reason[1] and _is_misspelt(reason[1])):
        return None
    meant = mujoco_of(case.versions)
    if meant is None:
        asked = None if file.asked is None else file.asked.told
    else:
        asked = f"it is meant for {meant.text}, which may take it" if meant.before(file.refused_by) else None
    return None if asked is None else f"{text_of(file.refused_by)} ({asked})"


def _is_misspelt(attribute: str) -> bool:
    """Whether an attribute that the installed release does not know is one of its own with a slip: `ctrlimited`."""
    from actspec.robot.mjspec import schema_words

    return is_slip(attribute, [word for word in schema_words() if len(word) > _SHORT])
