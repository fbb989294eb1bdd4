"""Tables of numbers from files of strangers: CSV, NPZ, Parquet. A cell without a number is NaN."""

from __future__ import annotations

import io
import os
import zipfile
from dataclasses import dataclass
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, Span, listed, shortened
from actspec.files import NotRegular, TooLarge, read_regular, why
from actspec.logs.log import LogError
from actspec.logs.text import MAX_CELLS, MAX_COLUMNS, read_text

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

MAX_BYTES = 256 * 2**20
"""Largest file [bytes]. Chosen: ten minutes of 29 joints at 200 Hz are 140 MB of text."""
ENDINGS = (".csv", ".tsv", ".txt", ".npz", ".parquet")
"""Of the files that are read."""
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
    readers = dict(zip(ENDINGS, (_text, _text, _text, _npz, _parquet), strict=True))
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
    except FileNotFoundError as err:
        help = "name the recording of a run; `actspec.Recorder` makes one (docs/diagnose.md)"
        raise LogError.of("LOG001", f"the log cannot be read: {why(err)}", Span(path), help=help) from err
    except (NotRegular, OSError, ValueError) as err:
        raise LogError.of("LOG001", f"the log cannot be read: {why(err)}", Span(path)) from err
    if data.startswith(b"\x80"):
        message = "the log is a pickle, which is not read: it may run code"
        raise LogError.of("LOG003", message, Span(path), help="write CSV, NPZ or Parquet")
    return readers[suffix](path, data)


def _text(path: str, data: bytes) -> Table:
    names, columns, first = read_text(path, data)
    return Table(names, columns, first, data)


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
