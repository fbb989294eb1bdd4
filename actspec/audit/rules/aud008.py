from __future__ import annotations

from collections.abc import Iterator

from actspec.audit.finding import quoted
from actspec.audit.rule import Case, Confidence, Finding, Rule, Severity
from actspec.diagnostics import Span, one_line
from actspec.readings.artifact import FileKind, FileReading
from actspec.robot.submodules import NOT_CHECKED_OUT
from actspec.robot.xml_reasons import READ_BY_MUJOCO


class Unreadable(Rule):
    code = "AUD008"
    name = "unreadable-file"
    severity = Severity.ERROR
    confidence = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding]:
        for file in case.files:
            if not file.readable and not file.names_nothing:
                yield from self._of(case, file)

    def _of(self, case: Case, file: FileReading) -> Iterator[Finding]:
        """What is wrong with the file, each at its place; the reader's reason where nothing has one."""
        errors = [item for item in file.diagnostics if item.severity is Severity.ERROR]
        # A spec is nobody's but the user's, wherever it lies.
        named = not file.in_folder or file.kind is FileKind.SPEC
        # A file that was lost to a fault of actspec would have been read wherever it lies.
        lost = any(item.code == self.code for item in errors)
        reasons = [item for item in errors if item.code != self.code]
        # What a part includes lies where its includer looks.
        fault, instead = "the file cannot be read", None
        if file.whole is not None:
            whole = one_line(file.whole)
            fault, instead = (
                f"the file can be read only in {whole}, which includes it",
                f"audit {whole} in its place",
            )

        def finding(
            message: str, place: Span, help: str | None, about: str, joint: str = "", away: bool = False
        ) -> Finding:
            severity = None
            # In a folder it may be no robot, or whole at its destination, but where a program there loads it.
            run = file.is_named and not (named or lost or away or read)
            # The audit makes a note of it in a folder, and counts it as one that is an error in a folder of one's own.
            noted = not (named or lost or run)
            if instead is not None or (noted and not case.is_met_at(place)):
                severity = Severity.INFO
            elif away or run:
                severity = Severity.WARNING
            return Finding(
                self.code,
                message,
                place,
                joint,
                help=help,
                severity=severity,
                noted_in_folders=noted,
                about=about,
            )

        # Of an MJCF, by who is there to load it.
        mjcf = any(b"<mujoco" in one.data for one in file.files[:1])
        read = mjcf and all((item.help or "").endswith(READ_BY_MUJOCO) for item in reasons)
        # Of a file that somebody has in a folder, one reason is enough to pass over it or to look at it.
        said = [item.message for item in reasons]
        for item in reasons if named else reasons[:1]:
            # One slip in seven joints is told once, with their names.
            alike = file.kind is FileKind.URDF and said.count(item.message) > 1
            where = f"{item.where}: " if item.where and not alike else ""
            count = len(reasons) - 1
            more = f"{count} more reason{'s' * (count != 1)}: audit the file by its name"
            help = instead or (item.help if named or len(reasons) == 1 else more)
            message = f"{fault}: {where}{item.message} ({item.code})"
            yield finding(
                message,
                item.span or Span(file.path),
                help,
                " ".join((item.code, *quoted(item.message))),
                item.where if alike else "",
                # Nothing is wrong with the file, and nothing of it is judged. A spec is of whoever has the submodule.
                item.code == NOT_CHECKED_OUT and file.kind is not FileKind.SPEC,
            )
        if lost or not errors:
            message = f"the file cannot be read: {file.reason}"
            yield finding(message, file.place, None, " ".join(quoted(message)))
