"""Lists of records, some of them at addresses: brought into a folder, so that every worker reads files."""

from __future__ import annotations

import csv
import hashlib
import io
import os
import re
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from borescope._complaint import Complaint, Note
from borescope._files import write
from borescope._record import fetch, is_address

#: What is taken for a list: its path, a pattern such as ``"s3://rigs/2026/*.mf4"``, or paths and addresses one after the other.
ListLike = str | os.PathLike[str] | Sequence[str]

#: Columns of a list that the command knows.
_KNOWN = ("record", "rig", "measured_at")


class Errand(NamedTuple):
    """An address, and the file that it is brought into."""

    address: str
    path: str


#: Does errands, and gives what went wrong in each that could not be done.
Fetcher = Callable[[Sequence[Errand]], Sequence[str]]


def do(errands: Sequence[Errand]) -> list[str]:
    """Brings what is not there yet; a file is whole or not there. Gives what went wrong, in words."""
    wrong = []
    for address, path in errands:
        if os.path.exists(path):
            continue
        try:
            data = fetch(address)
        except Complaint as complaint:
            wrong.append(f"{address}: {complaint.what}")
            continue
        os.makedirs(os.path.dirname(path), exist_ok=True)
        # Two workers may bring the same one.
        write(Path(path), data)
    return wrong


def local(records: ListLike, folder: Path, fetcher: Fetcher = do) -> str:
    """The path of a list of files: the list itself, or one in ``folder`` for which records were brought from their addresses.

    A record that cannot be brought stays in the list, so that it is named and counted with those that are damaged.
    """
    rows = _rows(records)
    if rows is None:
        return os.path.abspath(os.fspath(records))  # type: ignore[arg-type]
    errands = []
    for row in rows:
        address = row["record"]
        if is_address(address):
            name = re.split("[?#]", address)[0].rstrip("/").rsplit("/", 1)[-1]
            place = f"records/{hashlib.sha256(address.encode()).hexdigest()[:16]}/{name}"
            errands.append(Errand(address, str(folder.resolve() / place)))
            row["record"] = place
            row["measured_at"] = row.get("measured_at") or _modified(address)
        else:
            row["record"] = os.path.abspath(address)
    for what in fetcher(errands):
        warnings.warn(what, Note, stacklevel=4)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "list.csv"
    text = io.StringIO()
    table = csv.DictWriter(text, _KNOWN, restval="", extrasaction="ignore", lineterminator="\n")
    table.writeheader()
    table.writerows(rows)
    write(path, text.getvalue())
    return str(path.resolve())


def _rows(records: ListLike) -> list[dict[str, str]] | None:
    """The lines of a list; none where it is a file that names files only, which the command reads itself."""
    if isinstance(records, str) and is_address(records):
        return [{"record": address} for address in _expanded(records)]
    if not isinstance(records, (str, os.PathLike)):
        return [{"record": os.fspath(record)} for record in records]
    path = Path(records)
    if not path.exists():
        return None
    text = path.read_text(encoding="utf-8-sig", errors="replace")
    if "://" not in text:
        return None
    head = text.partition("\n")[0]
    separator = max(",;\t", key=head.count)
    rows = [{key: value or "" for key, value in row.items() if key} for row in csv.DictReader(text.splitlines(), delimiter=separator)]
    if any("record" not in row for row in rows):
        raise Complaint("the list has no column `record`", file=str(path), line=1, remedy="name the column with paths and addresses `record`")
    for row in rows:
        if not is_address(row["record"]):
            row["record"] = str(path.parent / row["record"])
    return rows


def _expanded(pattern: str) -> list[str]:
    """The addresses that a pattern stands for."""
    import fsspec

    try:
        system, path = fsspec.core.url_to_fs(pattern)
        found = sorted(system.glob(path))
    # What a file system of any kind may raise has no common name.
    except Exception as error:
        raise Complaint(
            f"the addresses cannot be listed: {error or type(error).__name__}", file=pattern, remedy="give a list of addresses"
        ) from error
    if not found:
        raise Complaint("there are no records of this pattern", file=pattern, remedy="check the address; `*` stands for a part of a name")
    return [system.unstrip_protocol(one) for one in found]


def _modified(address: str) -> str:
    """When what is at an address was written; empty where nobody says."""
    import fsspec

    try:
        system, path = fsspec.core.url_to_fs(address)
        moment: Any = system.modified(path)
        return str(moment.strftime("%Y-%m-%dT%H:%M:%SZ"))
    # Servers need not say it, and what is not there will be told when it is fetched.
    except Exception:
        return ""
