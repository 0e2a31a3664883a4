"""Records in memory."""

from __future__ import annotations

import csv
import io
import math
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any, SupportsFloat

from borescope._complaint import Complaint

#: How files begin whose format their first bytes tell.
_BEGINNINGS = {b"MDF": "mf4", b"PK\x03\x04": "xlsx", b"PAR1": "parquet", b"MATLAB": "mat", b"TDSm": "tdms", b"\x89HDF": "h5"}


class Record:
    """Columns of equal length, each with its unit; one of them the time.

    ``columns`` is a mapping of arrays, or a DataFrame of pandas or polars. Units stand in the names, ``"p_A [bar]"``, or in
    ``units``, ``{"p_A": "bar"}``. A DataFrame of pandas may have the time as its index. A time of dates, or of time differences,
    needs no unit; dates count from the first row. A value that is None or not a number
    is a sample that is missing. ``name`` is what results call it.

    >>> record = Record({"time [s]": [0.0, 0.1], "p_A": [10.0, 10.5]}, units={"p_A": "bar"})
    >>> record["p_A"], record.units["p_A"], len(record)
    ([10.0, 10.5], 'bar', 2)
    """

    def __init__(self, columns: Any, units: Mapping[str, str] | None = None, name: str = "record") -> None:
        self.name = name
        self.units: dict[str, str] = {}
        self._columns: dict[str, list[float]] = {}
        given = dict(units or {})
        for head, values in _columns(columns):
            column, unit = _split(head)
            unit = given.pop(column, unit)
            values = _listed(values)
            if column.lower() in _TIMES and values and isinstance(values[0], (datetime, timedelta)):
                values, unit = _seconds(column, values), "s"
            if column in self._columns:
                raise Complaint(f"the column `{column}` comes twice", remedy="leave one away, or rename it")
            if unit is None:
                raise Complaint(
                    f"the column `{column}` has no unit",
                    remedy=f'write it into the name, `"{column} [bar]"`, or give `units={{"{column}": "bar"}}`; "-" is a pure number',
                )
            self.units[column] = unit
            self._columns[column] = _numbers(column, values)
        if given:
            raise Complaint(f"`units` names columns that there are not: {', '.join(given)}", remedy="check the names")
        # A frame may have its time anywhere; a table begins with it.
        time = next((column for column in self._columns if column.lower() in _TIMES), None)
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


def _columns(columns: Any) -> Iterable[tuple[str, Any]]:
    if isinstance(columns, Mapping):
        return list(columns.items())
    kind = type(columns).__module__.split(".")[0]
    if kind == "pandas":
        index = columns.index
        # Only an index of dates is a time whatever it is called; a bare one counts the rows.
        dated = "datetime" in str(index.dtype) or "timedelta" in str(index.dtype)
        named = [(str(index.name or "time"), index.to_numpy())] if index.name or dated else []
        return [*named, *((str(head), columns[head].to_numpy()) for head in columns.columns)]
    if kind == "polars":
        return [(head, columns[head].to_list()) for head in columns.columns]
    raise Complaint(
        f"a {type(columns).__name__} is no record",
        remedy="give a path, bytes, a mapping of arrays, or a DataFrame of pandas or polars",
    )


def _split(head: str) -> tuple[str, str | None]:
    head = head.strip()
    if head.endswith("]") and "[" in head:
        name, unit = head[:-1].rsplit("[", 1)
        return name.strip(), unit.strip()
    return head, None


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
            raise Complaint(
                f"row {row} of the column `{column}` is {value!r}, no number",
                remedy="give numbers; the time counts in seconds from the start of the record",
            )
    return numbers
