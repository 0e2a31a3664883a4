"""Rigs, and everything that is asked of them."""

from __future__ import annotations

import csv
import errno
import html
import io
import os
import re
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from borescope._beside import absolute, relative
from borescope._complaint import Complaint, Listener, call, call_all
from borescope._files import write
from borescope._fleet import ListLike, local
from borescope._record import Record, RecordLike, is_one, path_of
from borescope._result import Calibration, Diagnosis, Improvement, Result
from borescope._words import in_python, page_in_python

Progress = bool | Listener | None


class _Desk:
    """A folder for the files of one call."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        #: Files of records that were columns in memory, and of rigs that were texts.
        self.tables: set[str] = set()
        self.texts: set[str] = set()

    def path(self, record: RecordLike, name: str = "record") -> str:
        """The path of a record."""
        path = path_of(record, self.folder, name)
        if not isinstance(record, (str, os.PathLike, bytes, bytearray, memoryview)):
            self.tables.add(Path(path).name)
        return path

    def new(self, name: str) -> str:
        return str(self.folder / name)

    def text(self, name: str) -> str | None:
        path = self.folder / name
        return path.read_text(encoding="utf-8") if path.exists() else None

    def rig(self) -> Rig:
        """The rig that a verb has written."""
        return Rig(text=absolute(self.text("new.toml") or "", self.folder))

    def plain(self, text: str) -> str:
        """A result without the folder, which is gone when it is read."""
        return text.replace(f"{self.folder}{os.sep}", "")

    def complaint(self, complaint: Complaint) -> Complaint:
        """The same of what the user has: rows of a table and lines of a text, where files were only written for the call."""
        text = self.plain(str(complaint))
        file = complaint.file and self.plain(complaint.file)

        def row(found: re.Match[str]) -> str:
            # The head of a table is its first line, and its first row has the number 0.
            within = f"row {int(found[2]) - 2} of " if found[2] and int(found[2]) > 1 else ""
            return f"{within}the record `{Path(found[1]).stem}`"

        def line(found: re.Match[str]) -> str:
            return f"{f'line {found[2]} of ' if found[2] else ''}the text of the rig"

        for names, place in ((self.tables, row), (self.texts, line)):
            for name in names:
                text = re.sub(rf"(?<![\w/\\])({re.escape(name)})(?::(\d+))?(?![\w/])", place, text)
        plain = Complaint(self.plain(complaint.what), file, complaint.line, complaint.remedy and self.plain(complaint.remedy), text)
        plain.others = complaint.others
        return plain

    def call(self, words: Sequence[str], progress: Progress = None, threads: int | None = None) -> str:
        return call(words, progress, threads, lambda note: in_python(self.plain(note)), self.folder)

    def ask(
        self, words: Sequence[str], progress: Progress = None, threads: int | None = None, *, curves: bool = False
    ) -> tuple[str, str, str | None]:
        """JSON and page of a verb, and its curves where it has some."""
        words = [*words, "--format", "json", "--report", self.new("page.html")]
        words += ["--curves", self.new("curves.csv")] if curves else []
        out = self.call(words, progress, threads)
        return self.plain(out), page_in_python(self.plain(self.text("page.html") or "")), self.text("curves.csv")


@contextmanager
def _desk() -> Iterator[_Desk]:
    with tempfile.TemporaryDirectory(prefix="borescope-") as folder:
        desk = _Desk(Path(folder))
        try:
            yield desk
        except Complaint as complaint:
            raise desk.complaint(complaint) from None
        except OSError as error:
            if error.errno != errno.ENOSPC:
                raise
            raise Complaint(
                f"there is no room left in the folder of temporary files, {tempfile.gettempdir()}",
                remedy="make room there, or name another folder with the environment variable `TMPDIR`",
            ) from error


class Rig:
    """A hydraulic circuit with its sensors, faults and effects, as a rig file describes it.

    ``path`` is that of the rig file; or ``text`` is its content. A rig never changes: what calibrates or extends it gives
    another one.

    Raises :class:`Complaint` where the rig file is wrong, with file, line and remedy.

    >>> rig = Rig("../fixtures/two_tanks/rig.toml")
    >>> [fault["id"] for fault in rig.check()["rig"]["faults"]]
    ['upper_outlet.diameter']
    """

    def __init__(self, path: str | os.PathLike[str] | None = None, *, text: str | None = None) -> None:
        if (path is None) == (text is None):
            raise Complaint("a rig is either a file or a text", remedy='`Rig("rig.toml")` or `Rig(text=...)`')
        if isinstance(path, str) and "\n" in path:
            raise Complaint("this is the text of a rig file, not its name", remedy="write `Rig(text=...)`")
        self.path = None if path is None else os.fspath(path)
        self._text = None if text is None else absolute(text, Path())
        self._seen = self.check()

    @property
    def text(self) -> str:
        """The rig file; one that is no file has whole paths of the files that it names."""
        return self._text if self._text is not None else Path(self.path or "").read_text(encoding="utf-8")

    def save(self, path: str | os.PathLike[str], force: bool = False) -> None:
        """Writes the rig file; one that is there is only overwritten with ``force``."""
        if Path(path).exists() and not force:
            raise Complaint("the file exists", file=os.fspath(path), remedy="name another, or say `force=True`")
        write(Path(path), self._text_in(Path(path).parent))

    def _text_in(self, folder: Path) -> str:
        """The rig file as it is to be written into a folder: files beside it are named from there."""
        here = self.text if self.path is None else absolute(self.text, Path(self.path).parent)
        return relative(here, folder)

    def __repr__(self) -> str:
        rig = self._seen["rig"]
        title = f"{self.path or 'text'}: {rig['name']}" if rig["name"] else self.path or "text"
        lines = [f"{key}: {', '.join(str(one) for one in rig[key].names()) or 'none'}" for key in ("components", "inputs", "sensors", "faults", "effects")]
        return "\n  ".join([f"Rig({title})", *lines])

    def _repr_html_(self) -> str:
        rig = self._seen["rig"]
        tables = [f"<p>{key}</p>{rig[key]._repr_html_()}" for key in ("components", "inputs", "sensors", "faults", "effects") if len(rig[key])]
        return f"<p><b>Rig {html.escape(rig['name'] or self.path or '')}</b></p>{''.join(tables)}"

    def _file(self, desk: _Desk) -> str:
        if self._text is None:
            return self.path or ""
        desk.texts.add("rig.toml")
        path = Path(desk.new("rig.toml"))
        path.write_text(self._text, encoding="utf-8")
        return str(path)

    def check(self, record: RecordLike | None = None) -> Result:
        """What is in the rig file and, if given, in a record for it: ``borescope.check/1``.

        ``.rig.faults``, ``.rig.sensors``, ``.rig.parameters`` are tables; ``.record.warnings`` says which columns are doubtful, and why.
        """
        with _desk() as desk:
            records = [] if record is None else [desk.path(record)]
            return Result(desk.plain(desk.call(["check", self._file(desk), *records, "--format", "json"])))

    def diagnose(
        self,
        record: RecordLike,
        *,
        store: str | os.PathLike[str] | None = None,
        at: str | None = None,
        progress: Progress = None,
        threads: int | None = None,
    ) -> Diagnosis:
        """Which faults a record shows, how large they are and how sure that is.

        ``record`` is a path, an address such as ``"s3://rigs/stroke.csv"`` where fsspec is installed, the bytes of a file, a mapping
        of arrays, a DataFrame, or a :class:`Record`. ``store`` keeps the diagnosis in an SQLite file, which is created if missing;
        ``at`` is when the record was measured, ``"2026-05-01T12:00:00Z"``, which a record in memory does not say itself.
        ``progress`` is True for a bar of tqdm, or a function of stage, done and of.
        """
        with _desk() as desk:
            words = ["diagnose", self._file(desk), desk.path(record)]
            words += [] if store is None else ["--store", os.fspath(store)]
            words += [] if at is None else ["--at", at]
            return Diagnosis(*desk.ask(words, progress, threads, curves=True))

    def monitor(
        self, record: RecordLike, window: float, *, fits: int = 3, progress: Progress = None, threads: int | None = None
    ) -> Result:
        """Looks through a record of any length in windows of so many seconds: ``borescope.windows/1``.

        Of the windows in which a residual raises an alarm at most ``fits`` are diagnosed; the others are only listed.
        """
        with _desk() as desk:
            words = ["diagnose", self._file(desk), desk.path(record), "--window", str(window), "--fits", str(fits)]
            return Result(desk.plain(desk.call([*words, "--format", "json"], progress, threads)))

    def compare(self, record: RecordLike, *, progress: Progress = None, threads: int | None = None) -> Result:
        """Where the model misses a record, and by how much: ``borescope.comparison/1``.

        ``.times_noise`` is the error in units of the sensor noise, about 1 where the model explains the record; ``.as_stated`` the same with
        all values as the rig file has them, nothing fitted; ``.channels`` the table by sensor, ``.where`` the part of the record with the
        largest error, ``.curves`` what was measured and modelled.
        """
        with _desk() as desk:
            words = ["compare", self._file(desk), desk.path(record)]
            return Result(*desk.ask(words, progress, threads, curves=True))

    def suggest(
        self,
        record: RecordLike,
        check: RecordLike | None = None,
        *,
        progress: Progress = None,
        threads: int | None = None,
    ) -> Result:
        """Which physical effect the model lacks, judged on ``check``, another record: ``borescope.suggestion/1``.

        ``.conclusion`` is such as ``"effect-found"``; ``.candidates`` the table of effects, the best first, with ``effect`` as :meth:`add`
        takes it, errors before and after in units of the sensor noise, and ``supported`` where ``check`` agrees.
        """
        with _desk() as desk:
            words = ["suggest", self._file(desk), desk.path(record, "fit")]
            words += [] if check is None else ["--check", desk.path(check, "check")]
            return Result(*desk.ask(words, progress, threads, curves=True))

    def add(self, effect: str, fit: RecordLike | None = None, *, progress: Progress = None) -> Rig:
        """The rig with an effect, such as ``"external-leakage@A"``; its parameters are fitted to a record, if given."""
        with _desk() as desk:
            words = ["add", self._file(desk), effect, "-o", desk.new("new.toml")]
            words += [] if fit is None else ["--fit", desk.path(fit, "fit")]
            desk.call(words, progress)
            return desk.rig()

    def improve(
        self, fit: RecordLike, check: RecordLike, *, progress: Progress = None, threads: int | None = None
    ) -> Improvement:
        """Adds the physics that the model lacks, as long as ``fit`` asks for it and ``check`` agrees: ``borescope.improvement/1``.

        ``.rig`` is the new rig, ``.ledger`` the table of steps: what was added, and the error of both records in units of the sensor noise.
        """
        with _desk() as desk:
            words = ["improve", self._file(desk), "--fit", desk.path(fit, "fit")]
            words += ["--check", desk.path(check, "check"), "-o", desk.new("new.toml")]
            answer = desk.ask(words, progress, threads, curves=True)
            return Improvement(*answer, desk.rig())

    def calibrate(
        self, records: Sequence[RecordLike], *, progress: Progress = None, threads: int | None = None
    ) -> Calibration:
        """What healthy records say of the machine beyond its data sheet: ``borescope.calibration/1``; ``.rig`` is the rig with it."""
        several = [records] if is_one(records) else list(records)
        if not several:
            raise Complaint("no record to calibrate on", remedy="give healthy records, `rig.calibrate([first, second])`")
        with _desk() as desk:
            paths = [desk.path(record, f"healthy_{number}") for number, record in enumerate(several, 1)]
            out, page, _ = desk.ask(["calibrate", self._file(desk), *paths, "-o", desk.new("new.toml")], progress, threads)
            return Calibration(out, page, desk.rig())

    def simulate(
        self,
        record: RecordLike | None = None,
        *,
        set: Mapping[str, str | float] | None = None,
        seed: int | None = None,
        progress: Progress = None,
    ) -> Record:
        """What the sensors would show over the inputs of a record, or over the rig's own cycle.

        ``set`` changes parameters, ``{"cylinder.clearance": "0.1 mm", "pump.loss": 0.2}``: texts with units, bare numbers only for what is
        a pure number; with ``seed`` there is noise. Where a pressure falls below vacuum,
        which the model is not valid for, a :class:`Note` says so.
        """
        with _desk() as desk:
            words = ["simulate", self._file(desk), "-o", desk.new("simulated.csv")]
            words += [] if record is None else ["--input", desk.path(record, "inputs")]
            words += [word for id, value in (set or {}).items() for word in ("--set", f"{id}={value}")]
            words += [] if seed is None else ["--seed", str(seed)]
            desk.call(words, progress)
            return Record.read_csv(desk.new("simulated.csv"))

    def isolability(self, record: RecordLike | None = None, *, progress: Progress = None) -> Result:
        """Which faults the sensors can isolate: ``borescope.isolability/1``.

        ``.faults`` names them, ``.expected.widths`` has the half width of the 95 % interval that each would get from such a record.
        """
        with _desk() as desk:
            words = ["isolability", self._file(desk)]
            words += [] if record is None else ["--input", desk.path(record, "inputs")]
            return Result(*desk.ask(words, progress))

    def campaign(
        self,
        cases: int,
        *,
        seed: int = 1,
        rigs: int | None = None,
        disturbance: float = 1.0,
        threads: int | None = None,
    ) -> Result:
        """How good the diagnosis of this rig is, measured on synthetic faults: ``borescope.campaign/1``.

        ``.scores`` has rates and errors, ``.cases`` the table of cases.
        """
        with _desk() as desk:
            words = ["campaign", self._file(desk), "--cases", str(cases), "--seed", str(seed)]
            words += ["--disturbance", str(disturbance)]
            words += [] if rigs is None else ["--rigs", str(rigs)]
            return Result(*desk.ask(words, threads=threads))


def draft(
    record: RecordLike,
    *,
    circuit: str | None = None,
    command: str | None = None,
    load: str | None = None,
    bore: str | None = None,
    rod: str | None = None,
    stroke: str | None = None,
) -> Rig:
    """A commented rig to begin with, from the columns of a record; its text marks what only the data sheet knows.

    ``circuit`` is ``"cylinder"`` (pump, relief valve, directional valve, cylinder) or ``"reservoirs"``, ``command`` and ``load`` are the
    columns of the command and the load, ``bore``, ``rod`` and ``stroke`` the sizes of the cylinder, ``"63 mm"``. ``rig.save("rig.toml")``
    writes it, to be edited and loaded again.
    """
    given = {"circuit": circuit, "command": command, "load": load, "bore": bore, "rod": rod, "stroke": stroke}
    with _desk() as desk:
        words = ["init", desk.path(record), "-o", desk.new("new.toml")]
        words += [word for name, value in given.items() if value is not None for word in (f"--{name}", str(value))]
        desk.call(words)
        return desk.rig()


def example(folder: str | os.PathLike[str], *, force: bool = False) -> Path:
    """Writes a rig file and records to play with into a folder, which is made where it is missing; gives the folder."""
    call(["example", os.fspath(folder), *(["--force"] if force else [])])
    return Path(folder)


def components() -> Result:
    """Every kind of component that a rig file may name, with ports, parameters and faults: ``borescope.components/1``."""
    return Result(call(["components", "--format", "json"]))


def effects() -> Result:
    """Every effect that a model may lack, with its law and its parameters: ``borescope.effects/1``."""
    return Result(call(["effects", "--format", "json"]))


def diagnose_fleet(
    manifest: ListLike,
    rig: Rig | str | os.PathLike[str],
    out: str | os.PathLike[str],
    *,
    shard: str | None = None,
    threads: int | None = None,
) -> list[Complaint]:
    """Diagnoses the records that a list names, into the folder ``out``; ``shard`` is a piece of it, ``"3/100"``.

    ``manifest`` is the path of a list, a pattern such as ``"s3://rigs/2026/*.mf4"``, or a sequence of paths and addresses. Records
    at addresses are brought into ``out`` first; the list in ``out`` then names them.
    What is done already is not done again. Gives a complaint for each record that has no diagnosis.
    """
    records = local(manifest, Path(out))
    words = ["diagnose", rig_file(rig, Path(out)), "--records", records, "-o", os.fspath(out)]
    words += [] if shard is None else ["--shard", shard]
    words += [] if threads is None else ["--threads", str(threads)]
    done, wrong = call_all(words)
    if wrong and not done:
        wrong[0].others = tuple(wrong[1:])
        raise wrong[0]
    return wrong


def rig_file(rig: Rig | str | os.PathLike[str], folder: Path) -> str:
    """The path of a rig file; of a rig that is no file, one in a folder, where all workers see it."""
    if not isinstance(rig, Rig):
        return os.fspath(rig)
    if rig.path is not None:
        return rig.path
    return rig_file_in(rig, folder)


def rig_file_in(rig: Rig, folder: Path) -> str:
    """The path of a copy of the rig file in a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    path, text = folder.resolve() / "rig.toml", rig._text_in(folder.resolve())
    if path.exists() and path.read_text(encoding="utf-8") != text:
        raise Complaint("the folder holds the work of another rig file", file=str(path), remedy="name another folder")
    write(path, text)
    return str(path)


def history(store: str | os.PathLike[str], rig: Rig, *, by: str = "time") -> Result:
    """The trend of each fault over the diagnoses in a store, and when it passes its limit: ``borescope.history/1``.

    ``by`` is what trends are plotted versus: ``"time"``, when the records were measured, or ``"run"``, the order in which they were
    kept.
    """
    with _desk() as desk:
        return Result(*desk.ask(["history", rig._file(desk), "--store", os.fspath(store), "--by", by]))


class Store:
    """Diagnoses of rigs in an SQLite file, which is created with the first one.

    >>> import tempfile, warnings
    >>> folder = tempfile.TemporaryDirectory()
    >>> rig = Rig("../fixtures/two_tanks/rig.toml")
    >>> store = Store(folder.name + "/tanks.db")
    >>> with warnings.catch_warnings(action="ignore"):
    ...     for day in (1, 2):
    ...         _ = store.diagnose(rig, rig.simulate(seed=day), at=f"2026-05-0{day}T12:00:00Z")
    >>> [fault.id for fault in store.history(rig).faults]
    ['upper_outlet.diameter']
    >>> len(store.runs()["run"])
    2
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = os.fspath(path)

    def __repr__(self) -> str:
        return f"Store({self.path})"

    def diagnose(self, rig: Rig, record: RecordLike, *, at: str | None = None, progress: Progress = None) -> Diagnosis:
        """Diagnoses a record, and keeps the diagnosis; ``at`` is when it was measured, ``"2026-05-01T12:00:00Z"``."""
        return rig.diagnose(record, store=self.path, at=at, progress=progress)

    def history(self, rig: Rig, *, by: str = "time") -> Result:
        """The trend of each fault of a rig: see :func:`history`."""
        return history(self.path, rig, by=by)

    def fleet(self) -> Result:
        """How all rigs of the store stand, the worst first: ``borescope.fleet/1``."""
        return fleet(self.path)

    def runs(self) -> dict[str, list[str]]:
        """The table of all runs, a row for each fault of each run: texts by column, as ``borescope export`` writes them."""
        rows = list(csv.reader(io.StringIO(call(["export", "--store", self.path, "-o", "-"]))))
        return {head: [row[at] for row in rows[1:]] for at, head in enumerate(rows[0])}

    def to_pandas(self) -> Any:
        """The same as a DataFrame of pandas."""
        import pandas

        return pandas.read_csv(io.StringIO(call(["export", "--store", self.path, "-o", "-"])))


def fleet(source: str | os.PathLike[str]) -> Result:
    """How all rigs of a store or table stand, the worst first: ``borescope.fleet/1``."""
    with _desk() as desk:
        return Result(*desk.ask(["fleet", os.fspath(source)]))
