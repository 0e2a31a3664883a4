"""Records in memory."""

from __future__ import annotations

import csv
import io
import math
import os
import re
from collections.abc import Callable, Mapping, Sequence
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any, SupportsFloat

from borescope._complaint import Complaint

#: How files begin whose format their first bytes tell.
_BEGINNINGS = {b"MDF": "mf4", b"PK\x03\x04": "xlsx", b"PAR1": "parquet", b"MATLAB": "mat", b"TDSm": "tdms", b"\x89HDF": "h5"}


class Record:
    """Columns of equal length, each with its unit; one of them the time.

    ``columns`` is a mapping of arrays, or a DataFrame of pandas or polars. Units stand in the names, ``"p_A [bar]"``
    (or all of them as ``"p_A (bar)"``, or as ``"p_A_bar"`` behind a time ``"t_s"``), or in ``units``, ``{"p_A": "bar"}``; those of columns that the rig does not use may be ``"-"``. A DataFrame of pandas may have the time as its
    index. A time of dates, or of time differences, may have any name and needs no unit; dates count from the first row. Any other time
    is the column ``time``, or the first one. A value that is None or not a number
    is a sample that is missing. ``name`` is what results call it.

    >>> record = Record({"time [s]": [0.0, 0.1], "p_A": [10.0, 10.5]}, units={"p_A": "bar"})
    >>> record["p_A"], record.units["p_A"], len(record)
    ([10.0, 10.5], 'bar', 2)
    """

    def __init__(self, columns: Any, units: Mapping[str, str] | None = None, name: str = "record") -> None:
        if isinstance(columns, (str, os.PathLike)):
            raise Complaint(
                f"{os.fspath(columns)!r} is a file, and a `Record` is made of columns",
                remedy="give the path itself to `rig.diagnose(path)` and the like, which read all formats; or `Record.read_csv(path)` for a table "
                "with units in its names",
            )
        if isinstance(columns, (bytes, bytearray, memoryview)):
            raise Complaint(
                "bytes are a file, and a `Record` is made of columns", remedy="give the bytes themselves to `rig.diagnose(data)` and the like"
            )
        self.name = name
        given = dict(units or {})
        table = _columns(columns)
        split = _splitter([head for head, _ in table], given)
        heads = [(*split(head), _listed(values)) for head, values in table]
        names = [column for column, _, _ in heads]
        for column in names:
            if names.count(column) > 1:
                raise Complaint(f"the column `{column}` comes twice", remedy="leave one away, or rename it")
        time = _time(heads)
        found = {column: given.pop(column, unit) for column, unit, _ in heads}
        if given:
            raise Complaint(
                f"`units` names columns that there are not: {', '.join(given)}", remedy=f"there are {_quoted(names)}"
            )
        given_values: dict[str, Sequence[Any]] = {column: values for column, _, values in heads}
        if time is not None and _dated(given_values[time]):
            given_values[time], found[time] = _seconds(time, given_values[time]), "s"
        without = [column for column, unit in found.items() if unit is None]
        if without:
            raise _without_unit(without)
        self.units: dict[str, str] = {column: unit for column, unit in found.items() if unit is not None}
        self._columns: dict[str, list[float]] = {column: _numbers(column, values) for column, values in given_values.items()}
        # A frame may have its time anywhere; a table begins with it.
        if time is not None:
            self._columns = {time: self._columns[time], **self._columns}
            self.units = {time: self.units[time], **self.units}
        lengths = {column: len(values) for column, values in self._columns.items()}
        if len(set(lengths.values())) > 1:
            told = ", ".join(f"`{column}` {length}" for column, length in lengths.items())
            raise Complaint(f"the columns are of unequal length: {told}", remedy="give a value, or None, for each row")

    @classmethod
    def read_csv(cls, path: str | os.PathLike[str]) -> Record:
        """Reads a table as this package writes it: comma separated, units in the names."""
        path = Path(path)
        with path.open(newline="") as file:
            rows = list(csv.reader(file))
        columns = {head: [float(row[at]) if row[at] else math.nan for row in rows[1:]] for at, head in enumerate(rows[0])}
        return cls(columns, name=path.stem)

    def __getitem__(self, column: str) -> list[float]:
        return self._columns[column]

    def __len__(self) -> int:
        return len(next(iter(self._columns.values()), []))

    def keys(self) -> list[str]:
        """Names of the columns, in their order."""
        return list(self._columns)

    def to_csv(self) -> str:
        """The table as the command reads it; every number comes back as it is."""
        text = io.StringIO()
        table = csv.writer(text, lineterminator="\n")
        table.writerow(f"{column} [{self.units[column]}]" for column in self._columns)
        for row in zip(*self._columns.values(), strict=True):
            table.writerow("" if math.isnan(value) else repr(value) for value in row)
        return text.getvalue()

    def to_pandas(self) -> Any:
        """A DataFrame of pandas, units in the names."""
        import pandas

        return pandas.DataFrame({f"{column} [{self.units[column]}]": values for column, values in self._columns.items()})

    def to_polars(self) -> Any:
        """A DataFrame of polars, units in the names."""
        import polars

        return polars.DataFrame({f"{column} [{self.units[column]}]": values for column, values in self._columns.items()})

    def __repr__(self) -> str:
        columns = ", ".join(f"{column} [{unit}]" for column, unit in self.units.items())
        return f"Record({self.name}: {len(self)} rows of {columns})"


#: Names of a time that may be dates.
_TIMES = ("time", "t", "timestamp", "datetime", "date/time")
#: An address such as ``s3://rigs/stroke.csv``, or a chain of them; the one letter of a drive is none.
_ADDRESS = re.compile(r"[A-Za-z][A-Za-z0-9+.-]+(://|::)")
#: Most bytes of a record, as of the command.
_MOST = 1 << 30

#: What is taken for a record: a path, an address, the bytes of a file, columns, or a :class:`Record`.
RecordLike = Any


def path_of(record: RecordLike, folder: Path, name: str = "record") -> str:
    """The path of a record; one in memory is written into ``folder``."""
    if isinstance(record, str) and is_address(record):
        return _fetched(record, folder)
    if isinstance(record, (str, os.PathLike)):
        return os.fspath(record)
    if isinstance(record, (bytes, bytearray, memoryview)):
        data = bytes(record)
        ending = next((ending for start, ending in _BEGINNINGS.items() if data.startswith(start)), "csv")
        path = folder / f"{name}.{ending}"
        path.write_bytes(data)
        return str(path)
    if not isinstance(record, Record):
        record = Record(record, name=name)
    path = folder / f"{Path(record.name).name}.csv"
    number = 1
    while path.exists():
        number += 1
        path = folder / f"{Path(record.name).name}_{number}.csv"
    path.write_text(record.to_csv(), encoding="utf-8")
    return str(path)


def is_one(records: Any) -> bool:
    """Whether this is a record, and no sequence of them."""
    return isinstance(records, (str, os.PathLike, bytes, bytearray, memoryview, Mapping, Record)) or hasattr(records, "columns")


def is_address(text: str) -> bool:
    """Whether a text is an address that fsspec reads, and no path."""
    return _ADDRESS.match(text) is not None


def fetch(address: str) -> bytes:
    """What is at an address."""
    try:
        import fsspec
    except ImportError:
        raise Complaint(
            "records at addresses are read with fsspec, which is not installed",
            file=address,
            remedy="`pip install fsspec`, with `s3fs` for `s3://` and `aiohttp` for `https://`; or give a path",
        ) from None
    try:
        with fsspec.open(address, "rb") as source:
            data = source.read(_MOST + 1)
    # What a file system of any kind may raise has no common name.
    except Exception as error:
        raise Complaint(
            f"the record cannot be read: {error or type(error).__name__}",
            file=address,
            remedy="check the address and the rights to it, and that the package for its kind is installed",
        ) from error
    if len(data) > _MOST:
        raise Complaint("the record is larger than 1024 MiB", file=address, remedy="split it; no more is read")
    return bytes(data)


def _fetched(address: str, folder: Path) -> str:
    """The path of what is at an address, brought into ``folder``; it keeps its name, which results call it by."""
    data = fetch(address)
    name = re.split("[?#]", address)[0].rstrip("/").rsplit("/", 1)[-1]
    name = name if name.strip(".") else "record"
    path, number = folder / name, 1
    while path.exists():
        number += 1
        path = folder / f"{number}_{name}"
    path.write_bytes(data)
    return str(path)


def _columns(columns: Any) -> Sequence[tuple[str, Any]]:
    if isinstance(columns, Mapping):
        return [(str(head), values) for head, values in columns.items()]
    kind = type(columns).__module__.split(".")[0] if hasattr(columns, "columns") else ""
    if kind == "pandas":
        index = columns.index
        # Only an index of dates is a time whatever it is called; a bare one counts the rows.
        dated = "datetime" in str(index.dtype) or "timedelta" in str(index.dtype)
        named = [(str(index.name or "time"), index.to_numpy())] if index.name or dated else []
        # By number, as two may have one name.
        return [*named, *((str(head), columns.iloc[:, at].to_numpy()) for at, head in enumerate(columns.columns))]
    if kind == "polars":
        return [(str(head), columns[head].to_list()) for head in columns.columns]
    raise Complaint(
        f"a {type(columns).__name__} is no record",
        remedy="give a mapping of arrays, or a DataFrame of pandas or polars",
    )


#: Units as they stand behind the last `_` of a name, where they are written otherwise than between brackets.
_SUFFIXES = {"pct": "%", "lpm": "L/min", "C": "degC", **{unit: unit for unit in (
    "s", "ms", "min", "h", "bar", "mbar", "Pa", "kPa", "MPa", "psi", "m", "mm", "cm", "um", "V", "mV", "A", "mA", "N", "kN", "kg", "W", "kW", "degC"
)}}  # fmt: skip
#: A time that is written with its unit so, as in a file: `t_s`.
_TIME_WITH_UNIT = re.compile("(?:t|time|zeit|timestamp)_(?:s|ms|min|h)", re.IGNORECASE)


def _splitter(heads: Sequence[str], given: Mapping[str, str]) -> Callable[[str], tuple[str, str | None]]:
    """How names and units are written, as of a file: `p_A [bar]`, or all `p_A (bar)`, or all `p_A_bar` behind a time such as `t_s`."""
    square = any(head.strip().endswith("]") for head in heads)
    low = bool(heads) and _TIME_WITH_UNIT.fullmatch(heads[0].strip()) is not None

    def split(head: str) -> tuple[str, str | None]:
        head = head.strip()
        if head in given:
            return head, None
        if head.endswith("]") and "[" in head:
            name, unit = head[:-1].rsplit("[", 1)
            return name.strip(), unit.strip()
        if not square and head.endswith(")") and "(" in head:
            name, unit = head[:-1].rsplit("(", 1)
            return name.strip(), unit.strip()
        if not square and low and head.rpartition("_")[2] in _SUFFIXES:
            name, _, unit = head.rpartition("_")
            return name, _SUFFIXES[unit]
        return head, None

    return split


def _quoted(names: Sequence[str]) -> str:
    """Names as a sentence has them; of many the first ones."""
    return ", ".join(f"`{name}`" for name in names[:12]) + (f" and {len(names) - 12} more" if len(names) > 12 else "")


def _without_unit(names: Sequence[str]) -> Complaint:
    """Columns without a unit, all at once, with a line to copy and to fill in."""
    told = f"the column {_quoted(names)} has no unit" if len(names) == 1 else f"{len(names)} columns have no unit: {_quoted(names)}"
    asked = ", ".join(f'"{name}": "{"s" if _sounds_like_time(name) else "..."}"' for name in names[:12])
    asked += ", ..." if len(names) > 12 else ""
    return Complaint(
        told,
        remedy=f'`borescope.Record(..., units={{{asked}}})`, or units in the names, `"p_A [bar]"`; "-" is a pure number. '
        "Leave columns away that hold no numbers",
    )


def _sounds_like_time(name: str) -> bool:
    return name.lower() in _TIMES or name.lower().startswith(("time", "t_", "zeit"))


def _dated(values: Sequence[Any]) -> bool:
    return bool(values) and isinstance(values[0], (datetime, timedelta))


def _time(heads: Sequence[tuple[str, str | None, Sequence[Any]]]) -> str | None:
    """The column that is the time: the one that is called so, else the first one with dates; else the command takes the first one."""
    called = next((column for column, _, _ in heads if column.lower() in _TIMES), None)
    return called or next((column for column, _, values in heads if _dated(values)), None)


def _listed(values: Any) -> Sequence[Any]:
    """Values as Python has them; dates of numpy would come as bare numbers of nanoseconds."""
    kind = getattr(getattr(values, "dtype", None), "kind", None)
    if kind in ("M", "m"):
        values = values.astype(f"{'datetime' if kind == 'M' else 'timedelta'}64[us]")
    return values.tolist() if hasattr(values, "tolist") else list(values)


def _seconds(column: str, values: Sequence[Any]) -> list[float]:
    """Dates as seconds from the first one, time differences as seconds."""
    begin = values[0] if isinstance(values[0], datetime) else timedelta()
    try:
        return [(value - begin).total_seconds() for value in values]
    except TypeError:
        raise Complaint(
            f"the column `{column}` has rows without a time, or times of several kinds", remedy="remove the rows without a time"
        ) from None


def _numbers(column: str, values: Sequence[Any]) -> list[float]:
    numbers = []
    for row, value in enumerate(values):
        if value is None:
            numbers.append(math.nan)
        elif isinstance(value, SupportsFloat):
            numbers.append(float(value))
        else:
            raise Complaint(f"row {row} of the column `{column}` is {value!r}, no number", remedy=_number_instead_of(value))
    return numbers


def _number_instead_of(value: Any) -> str:
    if isinstance(value, str):
        return (
            "make numbers of the texts, `pandas.to_numeric(column)`, after `.str.replace(\",\", \".\")` where they have decimal commas; "
            "leave a column of words away"
        )
    if isinstance(value, (datetime, timedelta)):
        return "only one column of dates is the time: leave the others away"
    if isinstance(value, list):
        return "give arrays of one dimension, `array.ravel()`"
    return "give real numbers"
