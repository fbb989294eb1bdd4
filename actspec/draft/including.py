"""What to import in place of a part of a model, and what a part has otherwise in its whole."""

from __future__ import annotations

from collections.abc import Iterable

from actspec.diagnostics import Diagnostic, Severity, Span, listed, one_line
from actspec.readings.artifact import FileReading, without_comments
from actspec.readings.including import ATTACHED, INCLUDED, Around

_PART_ROOT = b"<mujocoinclude"


def including(path: str) -> str | None:
    """What to import in place of a part of a model: the files that include or attach it; None: there is none."""
    return _listed(Around(path).wholes(INCLUDED, ATTACHED)) or None


def as_part(path: str) -> Diagnostic | None:
    """What an MJCF without <compiler> that is read alone has otherwise in the models that it is a part of.

    An include takes angles, classes and limits from around it. What is attached keeps those of its own file: measured
    with MuJoCo 3.2.7 and 4.0.0, radians, `autolimits="false"` and damping 1 of the model that attaches leave degrees,
    a limit and damping 7 of the attached one as they are, and the time step is the former's.

    Args:
        path: An MJCF.
    """
    around = Around(path)
    if whole := _listed(around.wholes(INCLUDED)):
        stated = "angles, classes and limits that are stated there are not read"
        message = f"has no <compiler>, and is a part of {whole}: {stated}"
        help = "import the whole model instead"
        return Diagnostic("DRF013", Severity.WARNING, message, "", Span(path), help)
    if whole := _listed(around.wholes(ATTACHED)):
        message = (
            f"{whole} attaches it: angles, classes and limits are those of this file there too, the names of its "
            f"joints may get a prefix, and the time step is that of {whole}"
        )
        return Diagnostic("DRF013", Severity.INFO, message, "", Span(path))
    return None


def _listed(paths: Iterable[str]) -> str:
    return listed(map(one_line, paths))


def whole_of(reading: FileReading) -> str | None:
    """What to import in place of a part of a model that is no model alone; None for what may be no part."""
    whole = including(reading.path)
    if whole is not None:
        return f"it is a part of {whole}: import the whole model"
    if any(_PART_ROOT in without_comments(file.data) for file in reading.files[:1]):
        return "it is a part of a model: import the file that includes it"
    return None
