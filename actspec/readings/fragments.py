"""Parts of a model that another of the audited files includes."""

from __future__ import annotations

import os
from collections.abc import Sequence

from actspec.readings.artifact import FileReading


def without_fragments(readings: Sequence[FileReading]) -> tuple[FileReading, ...]:
    """The readings without files that are no models alone and that another one includes: they are judged there.

    A file that MuJoCo takes alone stays, whoever includes it: it is a model.

    Args:
        readings: All of one audit.
    """
    included = {
        os.path.realpath(part.path)
        for reading in readings
        for part in reading.files
        if part.include and reading.artifacts
    }
    return tuple(
        reading
        for reading in readings
        if not (_is_refused(reading) and os.path.realpath(reading.path) in included)
    )


def _is_refused(reading: FileReading) -> bool:
    """Whether MuJoCo takes nothing of a file."""
    return bool(reading.artifacts) and all(one.text_only is not None for one in reading.artifacts)
