"""Rows of robot files, made while other files are still being read: then the cores wait for each other less."""

from __future__ import annotations

from actspec.audit.ledger import LedgerRow
from actspec.audit.rows.robot import rows_of_robot
from actspec.readings.artifact import Artifact, FileReading


class RowsAhead:
    """Rows of robots for the place among all artifacts that they have if every reading is kept."""

    def __init__(self) -> None:
        self._count = 0
        # By identity: an artifact that is replaced later has rows of its own.
        self._made: dict[int, tuple[Artifact, int, tuple[LedgerRow, ...]]] = {}

    def take(self, reading: FileReading) -> None:
        """Make the rows of one file.

        Args:
            reading: The next one, in the order of the files.
        """
        for artifact in reading.artifacts:
            if artifact.robot is not None:
                rows = rows_of_robot(artifact, self._count)
                self._made[id(artifact)] = artifact, self._count, rows
            self._count += 1

    def rows(self, artifact: Artifact, index: int) -> tuple[LedgerRow, ...]:
        """Rows of a robot, made now if they were not, or for another place.

        Args:
            artifact: With its robot.
            index: Its place in `Case.artifacts`.
        """
        made = self._made.get(id(artifact))
        if made is not None and made[0] is artifact and made[1] == index:
            return made[2]
        return rows_of_robot(artifact, index)
