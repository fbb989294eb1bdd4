"""Tables of numbers as text: which line is the header, what parts its cells, and every fault at its line."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterator
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, Span, shortened
from actspec.files import place_of
from actspec.logs.log import LogError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

MAX_CELLS = 40_000_000
"""Most numbers. Chosen: 320 MB."""
MAX_COLUMNS = 2000
MAX_HEADER = 2**17
"""Longest header. Chosen: 65 characters for each of the most columns."""
MAX_FAULTS = 20
"""After so many kinds of faults the others are counted. Chosen: they tend to have one cause."""
MISSING = frozenset(("", "nan", "na", "n/a", "null", "none", "-nan"))
"""Texts of a cell that holds no number, in small letters. Source: what pandas, numpy and MATLAB write."""
OTHERS = (
    (b"PK\x03\x04", "the log is a zip archive, not text", "a file of numpy.savez is named .npz"),
    (b"PAR1", "the log is a Parquet file, not text", "name it .parquet"),
    (b"\x1f\x8b", "the log is compressed", "unpack it with gunzip"),
    (b"\xff\xfe", "the log is UTF-16 text", "save it as UTF-8"),
    (b"\xfe\xff", "the log is UTF-16 text", "save it as UTF-8"),
)
"""First bytes of what is no UTF-8 text, what it is, and the remedy."""
SHAPE = "write a first row such as `time [s],hip.command [rad],hip.position [rad]`"
_THOUSANDS = re.compile(r",(?!\d{3}(?!\d))")


def read_text(path: str, data: bytes) -> tuple[tuple[str, ...], tuple[Array, ...], int]:
    """Names of the columns, the columns, and the line of the first row, from 1.

    Lines that begin with `#` above the header are comments; one that parts as the numbers below it is the header, as
    numpy.savetxt writes it.

    Args:
        path: For messages.
        data: The file's bytes.

    Raises:
        LogError: with every kind of fault, at its first line.
    """
    line, head, body = _parted(_decoded(path, data))
    delimiter = _delimiter(head)
    names = _header(path, line, head, delimiter)
    if not body.strip():
        raise LogError.of("LOG003", "the log has no rows", Span(path, line + 1))
    if delimiter != "," and "," in body and "." not in body and _THOUSANDS.search(body):
        # A decimal comma: no point is anywhere, and not all commas stand before three digits.
        body = body.replace(",", ".")
    return names, _numbers(path, body, delimiter, len(names), line + 1), line + 1


def _decoded(path: str, data: bytes) -> str:
    for start, message, help in OTHERS:
        if data.startswith(start):
            raise LogError.of("LOG003", message, Span(path), help=help)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as err:
        raise LogError.of(
            "LOG003",
            "the log is not UTF-8 text",
            Span(path, *place_of(data, err.start)),
            help="save it as UTF-8",
        ) from err
    if "\0" in text:
        raise LogError.of("LOG003", "the log is not text", Span(path, *place_of(data, data.index(b"\0"))))
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _delimiter(head: str) -> str:
    outside = re.sub(r'"[^"]*"', "", head)
    return next((mark for mark in ("\t", ";", ",") if mark in outside), ",")


def _parted(text: str) -> tuple[int, str, str]:
    """Number of the header's line, the header, and what is below it."""
    line, at, comment = 1, 0, None
    while text.startswith("#", at):
        end = _end(text, at)
        comment, at, line = text[at:end].lstrip("# \t"), end + 1, line + 1
    end = _end(text, at)
    head = text[at:end]
    if comment is not None and 1 < head.count(_delimiter(head)) + 1 == comment.count(_delimiter(head)) + 1:
        cells = head.split(_delimiter(head))
        if all(_number(cell) is not None for cell in cells) and any(cell.strip() for cell in cells):
            return line - 1, comment, text[at:]
    return line, head, text[end + 1 :]


def _end(text: str, at: int) -> int:
    """Where a line ends."""
    end = text.find("\n", at)
    return len(text) if end < 0 else end


def _header(path: str, line: int, head: str, delimiter: str) -> tuple[str, ...]:
    place = Span(path, line)
    if len(head) > MAX_HEADER:
        message = f"the header has {len(head)} characters, at most {MAX_HEADER} are read"
        raise LogError.of("LOG002", message, place)
    if head.count('"') % 2:
        raise LogError.of("LOG003", "a quotation mark in the header is not closed on its line", place)
    names = tuple(name.strip() for name in next(csv.reader([head], delimiter=delimiter), []))
    if not any(names):
        raise LogError.of("LOG003", "the log is empty", place, help="the first row names the columns")
    if len(names) > MAX_COLUMNS:
        message = f"the log has {len(names)} columns, at most {MAX_COLUMNS} are read"
        raise LogError.of("LOG002", message, place)
    if all(_number(name) is not None for name in names if name):
        raise LogError.of("LOG003", "the first row holds numbers, not names of columns", place, help=SHAPE)
    if len(names) == 1:
        message = (
            f"the header has one column, '{shortened(names[0])}': commas, semicolons or tabs part columns"
        )
        raise LogError.of("LOG003", message, place, help=SHAPE)
    return names


def _numbers(path: str, body: str, delimiter: str, width: int, first: int) -> tuple[Array, ...]:
    """The cells below a header, a column each."""
    import numpy as np

    lines = body.count("\n") + (not body.endswith("\n"))
    if lines * width > MAX_CELLS:
        raise LogError.of("LOG002", f"the log has over {MAX_CELLS} cells", Span(path))
    try:
        # In C, and it takes nothing but numbers; what it refuses is looked at cell by cell.
        found = np.loadtxt(
            io.TextIOWrapper(io.BytesIO(body.encode())), delimiter=delimiter, ndmin=2, comments=None
        )
        if found.shape[1] == width and len(found) == lines:
            return tuple(np.ascontiguousarray(column) for column in found.T)
    except ValueError:
        pass
    return _cells(path, body, delimiter, width, first)


class _Faults:
    """Faults of cells and rows: each kind once, at its first line, with how often it comes."""

    def __init__(self, path: str) -> None:
        self.path = path
        self.first: dict[str, tuple[str, Span, str | None]] = {}
        self.count: dict[str, int] = {}

    def add(
        self, kind: str, message: str, line: int, column: int | None = None, help: str | None = None
    ) -> None:
        self.first.setdefault(kind, (message, Span(self.path, line, column or 0), help))
        self.count[kind] = self.count.get(kind, 0) + 1

    def raise_if_any(self) -> None:
        out = Collector()
        for kind, (message, place, help) in list(self.first.items())[:MAX_FAULTS]:
            more = self.count[kind] - 1
            shown = f"{message}, and so {'does' if more == 1 else 'do'} {more} more" if more else message
            out.error("LOG004", shown, span=place, help=help)
        if len(self.first) > MAX_FAULTS:
            message = f"{len(self.first) - MAX_FAULTS} more columns have faulty cells"
            out.error("LOG004", message, span=Span(self.path))
        out.raise_if_failed(LogError)


def _cells(path: str, body: str, delimiter: str, width: int, first: int) -> tuple[Array, ...]:
    import numpy as np

    faults = _Faults(path)
    rows: list[list[float]] = []
    blank: int | None = None
    for line, cells in _rows(path, body, delimiter, first):
        if not cells:
            # At the end they are nothing; between rows they would move every later place.
            blank = line if blank is None else blank
            continue
        if blank is not None:
            faults.add("blank", "the line is blank", blank, help="remove it")
            blank = None
        if len(cells) != width:
            if cells[0].startswith("#"):
                faults.add("comment", "the line is a comment between rows", line, help="remove it")
                continue
            message = f"the row has {len(cells)} cell{'s' * (len(cells) != 1)}, the header {width}"
            faults.add(f"width {len(cells)}", message, line, help=_width(cells, width, delimiter))
            continue
        found = [_number(cell) for cell in cells]
        if line == first and all(value is None for value in found):
            message = "the row holds text, not numbers"
            faults.add("units", message, line, help="units stand in the header: `hip.position [rad]`")
            continue
        for column, (value, cell) in enumerate(zip(found, cells, strict=True), 1):
            if value is None:
                message = f"column {column} holds '{shortened(cell, 30)}', not a number"
                faults.add(f"column {column}", message, line, column, _written(cell))
        rows.append([0.0 if value is None else value for value in found])
    faults.raise_if_any()
    if not rows:
        raise LogError.of("LOG003", "the log has no rows", Span(path, first))
    return tuple(np.array(column, dtype=float) for column in zip(*rows, strict=True))


def _rows(path: str, body: str, delimiter: str, first: int) -> Iterator[tuple[int, list[str]]]:
    """Cells of each row, with the line at which it begins."""
    reader = csv.reader(io.StringIO(body), delimiter=delimiter)
    line = first
    while True:
        try:
            cells = next(reader)
        except StopIteration:
            return
        except csv.Error as err:
            raise LogError.of(
                "LOG004", f"the row cannot be read: {shortened(str(err))}", Span(path, line)
            ) from err
        yield line, cells
        line = first + reader.line_num


def _number(cell: str) -> float | None:
    """A cell's number, NaN for a missing one; None for text."""
    text = cell.strip()
    if text.lower() in MISSING:
        return float("nan")
    if text.lower() in ("true", "false"):
        return float(text.lower() == "true")
    # float() takes 1_000, which no program writes as a number.
    if "_" in text:
        return None
    try:
        return float(text)
    except ValueError:
        return None


def _width(cells: list[str], width: int, delimiter: str) -> str | None:
    if delimiter == "," and len(cells) in (2 * width, 2 * width - 1):
        return (
            "numbers with a decimal comma cannot be told from columns: write points, or part columns by `;`"
        )
    if len(cells) == width + 1 and not cells[-1].strip():
        return f"rows end in '{delimiter}', the header does not: remove it, or end the header in one too"
    return None


def _written(cell: str) -> str | None:
    plain = cell.strip().replace(",", ".")
    if plain != cell.strip() and _number(plain) is not None:
        return f"write {plain}, with a point"
    if cell.strip().split(" ")[0] != cell.strip() and _number(cell.strip().split(" ")[0]) is not None:
        return "units stand in the header: `hip.position [rad]`"
    return "leave a cell empty where nothing was read"
