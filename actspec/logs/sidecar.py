"""The YAML file beside a recording, found and read."""

from __future__ import annotations

import math
import os
from datetime import date

from actspec.diagnostics import Collector, Span, SpecError, shell_word, shortened
from actspec.logs.log import LogError
from actspec.logs.tables import ENDINGS
from actspec.spec.document import load_document
from actspec.spec.sidecar import FORMAT, Sidecar
from actspec.spec.validate import checked


def sidecar_path(path: str) -> str:
    """Where the sidecar of a log stands: the log's name with `.yaml`."""
    return os.path.splitext(path)[0] + ".yaml"


def check_results_path(path: str) -> None:
    """Refuse a results file where the sidecar of a log is looked for: that log could not be read any more.

    Raises: LogError: a log of this name stands beside it.
    """
    folder, name = os.path.split(path)
    stem = os.path.splitext(name)[0]
    if not os.path.isdir(folder or os.curdir) or sidecar_path(name) != name:
        return
    for other in sorted(os.listdir(folder or os.curdir)):
        begin, ending = os.path.splitext(other)
        if begin == stem and ending.lower() in ENDINGS:
            message = (
                f"this is where the sidecar of {other} is looked for: that log could not be read any more"
            )
            help = f"name another file, e.g. {os.path.join(folder, stem)}-results.yaml"
            raise LogError.of("SYS036", message, Span(path), help=help)


def load_sidecar(path: str) -> Sidecar:
    """The sidecar of a log; one with nothing stated where there is no file.

    Args:
        path: Of the log.

    Raises:
        LogError: with every error of the file.
    """
    beside = sidecar_path(path)
    if not os.path.lexists(beside):
        return Sidecar()
    collector = Collector()
    try:
        document = load_document(beside)
        if "actspec" in document.data:
            message = f"is a spec, and stands where the sidecar of {os.path.basename(path)} is looked for"
            stem, ending = os.path.splitext(path)
            help = (
                f"give the log or the spec another name, e.g. {shell_word(f'{stem}_log{ending}')} for the log"
            )
            raise LogError.of("LOG010", message, document.spans.value(()), help=help)
        if "format" not in document.data:
            collector.error(
                "LOG010",
                "the file beside the log does not name its format",
                span=document.spans.value(()),
                help=f"write `format: {FORMAT}`, or give the file another name",
            )
        found = checked(Sidecar, document, collector)
    except SpecError as err:
        raise LogError(err.diagnostics) from err
    if found is not None and found.date is not None and not _is_day(found.date):
        message = f"must be a day as 2026-11-22, got '{shortened(found.date)}'"
        collector.error("LOG016", message, where="date", span=document.spans.value(("date",)))
    if found is not None and found.base is not None and not 0.9 < math.hypot(*found.base.orientation) < 1.1:
        message = f"a quaternion has length 1, this one {math.hypot(*found.base.orientation):.3g}"
        place = document.spans.value(("base", "orientation"))
        collector.error("LOG016", message, where="base.orientation", span=place, help="order: w, x, y, z")
    collector.raise_if_failed(LogError)
    assert found is not None
    return found


def _is_day(text: str) -> bool:
    try:
        return date.fromisoformat(text).isoformat() == text
    except ValueError:
        return False
