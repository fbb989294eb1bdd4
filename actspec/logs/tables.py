"""Tables of numbers from files of strangers: CSV, NPZ, Parquet. A cell without a number is NaN."""

from __future__ import annotations

import csv
import io
import os
import zipfile
from dataclasses import dataclass
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, Span, listed, shortened
from actspec.files import NotRegular, TooLarge, read_regular, why
from actspec.logs.log import LogError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

MAX_BYTES = 256 * 2**20
"""Largest file [bytes]. Chosen: ten minutes of 29 joints at 200 Hz are 140 MB of text."""
MAX_CELLS = 40_000_000
"""Most numbers. Chosen: 320 MB."""
MAX_COLUMNS = 2000
MAX_FAULTS = 20
"""After so many faulty cells the others are counted. Chosen: they tend to have one cause."""
MISSING = frozenset(("", "nan", "na", "n/a", "null", "none", "-nan"))
"""Texts of a cell that holds no number, in small letters. Source: what pandas, numpy and MATLAB write."""
PICKLES = (".pkl", ".pickle", ".pt", ".pth", ".npy", ".mat", ".h5", ".hdf5", ".bag", ".mcap", ".db3")


@dataclass(frozen=True, slots=True)
class Table:
    """Columns of numbers.

    Attributes:
        names: As the file has them, units included.
        columns: Of each, shape (n,).
        first_row: Line of the first row in the file, from 1.
        data: The file's bytes.
    """

    names: tuple[str, ...]
    columns: tuple[Array, ...]
    first_row: int
    data: bytes


def read_table(path: str) -> Table:
    """Read a table.

    Raises:
        LogError: with every fault of the file, each with its row.
    """
    suffix = os.path.splitext(path)[1].lower()
    readers = {".csv": _csv, ".tsv": _csv, ".txt": _csv, ".npz": _npz, ".parquet": _parquet}
    if suffix not in readers:
        help = "write CSV, NPZ or Parquet with columns `time [s]`, `JOINT.position [rad]`, ..."
        if suffix in PICKLES:
            help = f"{suffix} is not read, because such a file may run code or has no columns: {help}"
        raise LogError.of("LOG001", f"'{shortened(path)}' is no log", Span(path), help=help)
    try:
        data = read_regular(path, MAX_BYTES)
    except TooLarge as err:
        message = f"the log has {err.size} bytes, at most {MAX_BYTES} are read"
        raise LogError.of(
            "LOG002", message, Span(path), help="split the recording, or leave columns out"
        ) from err
    except (NotRegular, OSError, ValueError) as err:
        raise LogError.of("LOG001", f"the log cannot be read: {why(err)}", Span(path)) from err
    return readers[suffix](path, data)


def _csv(path: str, data: bytes) -> Table:
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as err:
        line = data.count(b"\n", 0, err.start) + 1
        raise LogError.of("LOG003", "the log is not UTF-8 text", Span(path, line)) from err
    if "\0" in text:
        raise LogError.of(
            "LOG003", "the log is not text", Span(path, text.count("\n", 0, text.index("\0")) + 1)
        )
    head, _, body = text.partition("\n")
    delimiter = next((mark for mark in ("\t", ";", ",") if mark in head), ",")
    names = _header(path, next(csv.reader([head.rstrip("\r")], delimiter=delimiter), []))
    del text
    return Table(names, _numbers(path, body, delimiter, len(names)), 2, data)


def _header(path: str, given: list[str]) -> tuple[str, ...]:
    names = tuple(name.strip() for name in given)
    if not any(names):
        raise LogError.of("LOG003", "the log is empty", Span(path, 1), help="the first row names the columns")
    if len(names) > MAX_COLUMNS:
        message = f"the log has {len(names)} columns, at most {MAX_COLUMNS} are read"
        raise LogError.of("LOG002", message, Span(path, 1))
    if all(_number(name) is not None for name in names if name):
        help = "write a first row such as `time [s],hip.command [rad],hip.position [rad]`"
        raise LogError.of(
            "LOG003", "the first row holds numbers, not names of columns", Span(path, 1), help=help
        )
    return names


def _numbers(path: str, body: str, delimiter: str, width: int) -> tuple[Array, ...]:
    """The cells below a header, a column each."""
    import numpy as np

    if not body.strip():
        raise LogError.of("LOG003", "the log has no rows", Span(path, 2))
    try:
        # In C, and it takes nothing but numbers; what it refuses is looked at cell by cell.
        found = np.loadtxt(io.StringIO(body), delimiter=delimiter, ndmin=2, comments=None)
        if found.shape[1] == width and len(found) == body.count("\n") + (not body.endswith("\n")):
            return tuple(np.ascontiguousarray(column) for column in found.T)
    except ValueError:
        pass
    return _cells(path, body, delimiter, width)


def _cells(path: str, body: str, delimiter: str, width: int) -> tuple[Array, ...]:
    import numpy as np

    faults = Collector()
    many = 0
    rows: list[list[float]] = []
    for line, cells in enumerate(csv.reader(io.StringIO(body), delimiter=delimiter), 2):
        if not cells:
            # Blank lines count in file rows: a gap would move every later place.
            rows.append([])
            continue
        if len(cells) != width:
            many += 1
            if many <= MAX_FAULTS:
                message = f"the row has {len(cells)} cells, the header {width}"
                faults.error("LOG004", message, span=Span(path, line), help=_comma(cells, width, delimiter))
            continue
        found = [_number(cell) for cell in cells]
        for column, (value, cell) in enumerate(zip(found, cells, strict=True), 1):
            if value is None:
                many += 1
                if many <= MAX_FAULTS:
                    message = f"column {column} holds '{shortened(cell, 30)}', not a number"
                    faults.error("LOG004", message, span=Span(path, line, column), help=_written(cell))
        rows.append([0.0 if value is None else value for value in found])
        if len(rows) * width > MAX_CELLS:
            raise LogError.of("LOG002", f"the log has over {MAX_CELLS} cells", Span(path, line))
    if many > MAX_FAULTS:
        faults.error("LOG004", f"{many - MAX_FAULTS} more cells or rows are faulty", span=Span(path))
    while rows and not rows[-1]:
        rows.pop()
    for index, row in enumerate(rows):
        if not row:
            faults.error("LOG004", "the line is blank", span=Span(path, index + 2), help="remove it")
            break
    faults.raise_if_failed(LogError)
    if not rows:
        raise LogError.of("LOG003", "the log has no rows", Span(path, 2))
    return tuple(np.array(column, dtype=float) for column in zip(*rows, strict=True))


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


def _comma(cells: list[str], width: int, delimiter: str) -> str | None:
    if delimiter == "," and len(cells) in (2 * width, 2 * width - 1):
        return "numbers with a decimal comma cannot be told from columns: write points, or separate by `;`"
    return None


def _written(cell: str) -> str | None:
    plain = cell.strip().replace(",", ".")
    if plain != cell.strip() and _number(plain) is not None:
        return f"write {plain}, with a point"
    if cell.strip().split(" ")[0] != cell.strip() and _number(cell.strip().split(" ")[0]) is not None:
        return "units stand in the header: `hip.position [rad]`"
    return None


def _npz(path: str, data: bytes) -> Table:
    import numpy as np

    faults = Collector()
    names: list[str] = []
    columns: list[Array] = []
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            members = archive.infolist()
            if sum(member.file_size for member in members) > 8 * MAX_CELLS or len(members) > MAX_COLUMNS:
                message = f"the log has over {MAX_CELLS} cells or {MAX_COLUMNS} columns"
                raise LogError.of("LOG002", message, Span(path))
            for member in members:
                name = member.filename.removesuffix(".npy")
                column = _array(archive, member)
                if isinstance(column, str):
                    faults.error("LOG005", f"array '{shortened(name)}' {column}", span=Span(path))
                else:
                    names.append(name)
                    columns.append(column)
    except (
        zipfile.BadZipFile,
        zipfile.LargeZipFile,
        NotImplementedError,
        OSError,
        EOFError,
        ValueError,
    ) as err:
        raise LogError.of("LOG003", f"the log is no NPZ file: {shortened(str(err))}", Span(path)) from err
    except RuntimeError as err:
        # An encrypted member.
        raise LogError.of("LOG003", f"the log cannot be unpacked: {shortened(str(err))}", Span(path)) from err
    faults.raise_if_failed(LogError)
    lengths = {len(column) for column in columns}
    if len(lengths) > 1:
        shown = listed([f"{name} has {len(column)}" for name, column in zip(names, columns, strict=True)])
        raise LogError.of("LOG004", f"the arrays have different lengths: {shown}", Span(path))
    if not columns or not columns[0].size:
        raise LogError.of("LOG003", "the log has no rows", Span(path))
    return Table(tuple(names), tuple(np.ascontiguousarray(column) for column in columns), 1, data)


def _array(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> Array | str:
    """A member's numbers, or why it holds none; never unpickled, and no larger than the archive says."""
    import numpy as np

    with archive.open(member) as stream:
        try:
            version = np.lib.format.read_magic(stream)
            read = {
                (1, 0): np.lib.format.read_array_header_1_0,
                (2, 0): np.lib.format.read_array_header_2_0,
            }.get(version)
            if read is None:
                return "is of an unknown version of the NPY format"
            shape, _, dtype = read(stream)
        except ValueError:
            return "is no array"
        if dtype.hasobject:
            return "holds Python objects, which are not read: they may run code"
        if dtype.kind not in "fiub" or len(shape) != 1:
            return f"must hold numbers in one dimension, got {dtype} of shape {shape}"
        size = shape[0] * dtype.itemsize
        if size > member.file_size:
            return "is cut off"
        found = np.frombuffer(stream.read(size), dtype=dtype)
        return "is cut off" if len(found) != shape[0] else found.astype(float)


def _parquet(path: str, data: bytes) -> Table:
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError as err:
        help = "pip install pyarrow, or write CSV or NPZ"
        raise LogError.of("LOG001", "Parquet needs the package pyarrow", Span(path), help=help) from err
    import numpy as np

    faults = Collector()
    try:
        file = pyarrow.parquet.ParquetFile(pyarrow.BufferReader(data))
        meta = file.metadata
        if meta.num_rows * meta.num_columns > MAX_CELLS or meta.num_columns > MAX_COLUMNS:
            message = f"the log has over {MAX_CELLS} cells or {MAX_COLUMNS} columns"
            raise LogError.of("LOG002", message, Span(path))
        table = file.read()
        columns = []
        for name in table.column_names:
            kind = table.schema.field(name).type
            if not (
                pyarrow.types.is_floating(kind) or pyarrow.types.is_integer(kind) or kind == pyarrow.bool_()
            ):
                message = f"column '{shortened(name)}' holds {kind}, not numbers"
                faults.error("LOG005", message, span=Span(path))
                continue
            columns.append(np.asarray(table.column(name).to_numpy(), dtype=float))
    except (pyarrow.ArrowException, OSError, ValueError) as err:
        raise LogError.of("LOG003", f"the log is no Parquet file: {shortened(str(err))}", Span(path)) from err
    faults.raise_if_failed(LogError)
    if not columns or not columns[0].size:
        raise LogError.of("LOG003", "the log has no rows", Span(path))
    return Table(tuple(table.column_names), tuple(columns), 1, data)
