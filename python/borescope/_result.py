"""Results: what the command writes as JSON, with attributes, tables and curves."""

from __future__ import annotations

import csv
import html
import io
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

from borescope._complaint import Complaint
from borescope._files import write
from borescope._words import in_python

if TYPE_CHECKING:
    from borescope._rig import Rig

#: Keys that name an entry of a list.
_NAMES = ("id", "name", "effect", "kind", "rig")
#: Keys whose lists hold objects, after ``docs/schema``: such a list is a table without rows too.
TABLES = frozenset(
    "bins by_count candidates cases channels columns components consequences dynamics effects episodes events failures faults findings "
    "fitted goes_with hypotheses inputs inseparable left_out mapping nodes not_fitted onsets parameters phases ports profiles records refused "
    "residuals rig_files rigs rival_effects rivals runs sensors set signatures states steps tests uncertain values widths windows with worst".split()
)
#: Rows of a table that are shown; ``to_pandas()`` has all of them.
_SHOWN = 40
#: Letters of a line of text, and of one of its cells.
_WIDE, _CELL = 150, 40


class Item(Mapping[str, Any]):
    """An object of a result; its keys are attributes too. Keys are those of ``docs/reference/json.md``."""

    def __init__(self, data: Mapping[str, Any]) -> None:
        self._data = data

    def __getattr__(self, key: str) -> Any:
        # Copies and pickles ask for these before there are data.
        if key.startswith("_"):
            raise AttributeError(key)
        if key not in self._data:
            raise AttributeError(f"there is no `{key}` here, but {', '.join(self._data)}")
        return _wrapped(key, self._data[key])

    def __getitem__(self, key: str) -> Any:
        return _wrapped(key, self._data[key])

    def __iter__(self) -> Iterator[str]:
        return iter(self._data)

    def __len__(self) -> int:
        return len(self._data)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._data]

    def __repr__(self) -> str:
        return f"Item({', '.join(f'{key}={value!r}' for key, value in self._data.items())})"

    def to_dict(self) -> dict[str, Any]:
        """The plain data."""
        return dict(self._data)


class Table(Sequence[Item]):
    """A list of objects, by number or by name: ``faults["cylinder.clearance"]``."""

    def __init__(self, rows: Sequence[Mapping[str, Any]]) -> None:
        self._rows = rows

    def _name(self, row: Mapping[str, Any]) -> Any:
        return next((row[key] for key in _NAMES if key in row), None)

    @overload
    def __getitem__(self, key: int | str) -> Item: ...
    @overload
    def __getitem__(self, key: slice) -> Table: ...
    def __getitem__(self, key: int | str | slice) -> Item | Table:
        if isinstance(key, slice):
            return Table(self._rows[key])
        if isinstance(key, int):
            return Item(self._rows[key])
        for row in self._rows:
            if self._name(row) == key:
                return Item(row)
        raise KeyError(f"there is no `{key}` here, but {', '.join(str(name) for name in self.names())}")

    def __len__(self) -> int:
        return len(self._rows)

    def names(self) -> list[Any]:
        """What the rows are called."""
        return [self._name(row) for row in self._rows]

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, (Table, list)):
            return NotImplemented
        return list(self._rows) == list(other._rows if isinstance(other, Table) else other)

    # Its rows may be changed by whoever holds the data.
    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        heads, rows = self._cells()
        lines = [f"Table of {len(self)}{':' if rows else ''}"]
        widths = [max(len(line[at]) for line in [heads, *rows]) for at in range(len(heads))]
        fitting = [at for at in range(len(heads)) if sum(widths[: at + 1]) + 2 * at <= _WIDE]
        lines += ["  ".join(line[at].ljust(widths[at]) for at in fitting).rstrip() for line in ([heads, *rows] if rows else [])]
        further = [heads[at] for at in range(len(heads)) if at not in fitting]
        lines += [f"and the columns {', '.join(further)}"] if further else []
        lines += [f"and {len(self) - len(rows)} more rows"] if len(rows) < len(self) else []
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        heads, rows = self._cells()

        def line(cells: Sequence[str], tag: str) -> str:
            return "<tr>" + "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in cells) + "</tr>"

        more = f"<p>and {len(self) - len(rows)} more rows</p>" if len(rows) < len(self) else ""
        body = "".join(line(row, "td") for row in rows)
        return f"<table><thead>{line(heads, 'th')}</thead><tbody>{body}</tbody></table>{more}" if heads else "<p>Table of 0</p>"

    def _cells(self) -> tuple[list[str], list[list[str]]]:
        """Heads and the first rows as texts."""
        flat = [_flat(row) for row in self._rows[:_SHOWN]]
        heads = list(dict.fromkeys(key for row in flat for key in row))
        return heads, [[_cell(row.get(head)) for head in heads] for row in flat]

    def rows(self) -> list[dict[str, Any]]:
        """The rows with plain values: intervals as ``low`` and ``high``, lists of plain values as they are, what an object within has
        as ``trend.slope``; lists of objects are left away."""
        return [_flat(row) for row in self._rows]

    def to_pandas(self) -> Any:
        """A DataFrame of pandas, a row for each object; intervals as ``low`` and ``high``."""
        import pandas

        return pandas.DataFrame(self.rows())

    def to_polars(self) -> Any:
        """The same as a DataFrame of polars."""
        import polars

        return polars.DataFrame(self.rows(), infer_schema_length=None)


def _wrapped(key: str, value: Any) -> Any:
    if isinstance(value, Mapping):
        return Item(value)
    if isinstance(value, list) and (all(isinstance(one, Mapping) for one in value) if value else key in TABLES):
        return Table(value)
    return in_python(value) if isinstance(value, str) else value


def _is_plain(value: Any) -> bool:
    return not isinstance(value, (list, Mapping))


def _flat(row: Mapping[str, Any]) -> dict[str, Any]:
    flat: dict[str, Any] = {}
    for key, value in row.items():
        if key == "ci95":
            flat["low"], flat["high"] = value
        elif isinstance(value, Mapping):
            flat |= {f"{key}.{own}": one for own, one in _flat(value).items() if _is_plain(one)}
        elif _is_plain(value) or (isinstance(value, list) and value and all(_is_plain(one) for one in value)):
            flat[key] = value
        elif value == [] and key not in TABLES:
            flat[key] = value
    return flat


def _cell(value: Any) -> str:
    """A value of a row as people read it."""
    if value is None:
        return ""
    if isinstance(value, list):
        value = ", ".join(_cell(one) for one in value)
    text = f"{value:.5g}" if isinstance(value, float) else str(value)
    return text if len(text) <= _CELL else f"{text[: _CELL - 3]}..."


def _short(value: float) -> str:
    """Two digits, and never a power of ten: 0.95, 34, 210."""
    return f"{float(f'{value:.2g}'):g}"


class Result(Item):
    """What a verb of the command gives.

    Its keys are attributes; ``dir(result)`` and ``list(result)`` name them. Lists in it are tables: ``result.channels.to_pandas()``.
    ``json`` is the text that the command writes, ``page`` its page with pictures (or None), and ``curves`` its table of curves.
    """

    def __init__(self, text: str, page: str | None = None, curves: str | None = None) -> None:
        super().__init__(json.loads(text))
        self.json = text
        self.page = page
        self._curves = curves

    @property
    def curves(self) -> dict[str, Any]:
        """Curves by name and unit, such as ``"p_A.measured [bar]"``: arrays of numpy, without it lists; NaN where there is no sample."""
        if self._curves is None:
            raise Complaint("this result has no curves", remedy="`compare`, `diagnose`, `suggest` and `improve` have them")
        rows = list(csv.reader(io.StringIO(self._curves)))
        columns = {head: [float(row[at]) if row[at] else math.nan for row in rows[1:]] for at, head in enumerate(rows[0])}
        try:
            import numpy
        except ImportError:
            return dict(columns)
        return {head: numpy.array(values) for head, values in columns.items()}

    def save(self, path: str | Path, force: bool = False) -> None:
        """Writes the page with pictures to a file; one that is there is only overwritten with ``force``."""
        if self.page is None:
            raise Complaint("this result has no page")
        path = Path(path)
        if path.exists() and not force:
            raise Complaint("the file exists", file=str(path), remedy="name another, or say `force=True`")
        write(path, self.page)

    def _repr_html_(self) -> str:
        if self.page is None:
            tables = "".join(f"<p>{html.escape(key)}</p>{table._repr_html_()}" for key, table in self._tables())
            return f"<p>{html.escape(self._head())}</p>{tables}"
        return (
            f'<p>{html.escape(repr(self).partition(chr(10))[0])}</p><iframe sandbox="allow-scripts allow-downloads" width="100%" height="560" '
            f'style="border: 1px solid #8888" srcdoc="{html.escape(self.page)}"></iframe>'
        )

    def _tables(self) -> list[tuple[str, Table]]:
        """The tables in it, and those of the objects in it."""
        found = [(key, value) for key, value in self.items() if isinstance(value, Table) and len(value)]
        for key, value in self.items():
            if isinstance(value, Item):
                found += [(f"{key}.{own}", table) for own, table in value.items() if isinstance(table, Table) and len(table)]
        return found

    def __repr__(self) -> str:
        # What has a finding says it in a line; else its tables are what it says.
        tables = [] if self._words() else [f".{key}: {table!r}" for key, table in self._tables()]
        return "\n".join([self._head(), *tables])

    def _head(self) -> str:
        words = self._words()
        return f"{type(self).__name__}({self._data.get('schema', '')}{': ' if words else ''}{', '.join(words)})"

    def _words(self) -> list[str]:
        """The finding in words; none of what has none."""
        words = [str(self._data[key]) for key in ("verdict", "conclusion") if key in self._data]
        if "adequate" in self._data:
            words.append("adequate" if self._data["adequate"] else "inadequate")
        warnings = record.get("warnings") if isinstance(record := self._data.get("record"), Mapping) else None
        if warnings is not None:
            words.append(f"{len(warnings)} warning{'' if len(warnings) == 1 else 's'} of the record")
        candidates = self._data.get("candidates")
        # Rivals that explain the record as well are told one by one in the table.
        if candidates and candidates[0].get("supported"):
            words.append(f"first of {len(candidates)}: {candidates[0]['effect']}")
        steps = self._data.get("steps")
        if steps:
            added = [step["added"] for step in steps if step.get("added")]
            words.append(", ".join(added) or "nothing added")
            words.append(f"{_short(steps[0]['check_rmse'])}x -> {_short(steps[-1]['check_rmse'])}x the sensor noise on the check record")
        if isinstance(self._data.get("times_noise"), (int, float)):
            words.append(f"{_short(self._data['times_noise'])}x the sensor noise")
        if isinstance(scores := self._data.get("scores"), Mapping):
            for key in ("detected", "isolated", "false_alarms"):
                rate = scores["all"][key]
                words.append(f"{key.replace('_', ' ')} {rate['count']} of {rate['of']}")
        if "ambiguity_groups" in self._data:
            faults, detectable = self._data["faults"], self._data["detectable"]
            words.append(f"{sum(detectable)} of {len(faults)} faults detectable")
            groups = ["{" + ", ".join(group) + "}" for group in self._data["ambiguity_groups"]]
            words.append(f"not isolable from each other: {'; '.join(groups)}" if groups else "no ambiguity groups")
        return words


class Diagnosis(Result):
    """What is wrong in a record, how large, how sure: ``borescope.diagnosis/1``."""

    faults: Table

    @property
    def present(self) -> list[Item]:
        """The faults that are there, the surest first; of those as sure to a tenth of a per cent in the order of the rig."""

        def doubt(fault: Item) -> int:
            thousandths: float = 1e3 * (1.0 - fault["probability"])
            return round(thousandths) if thousandths >= 1.0 else 0

        return sorted((fault for fault in self["faults"] if fault["present"]), key=doubt)

    @property
    def params(self) -> Table:
        """What was fitted, by name: ``params["cylinder.clearance"].value``, ``.standard_error``, ``.unit``, ``.fault``."""
        return Table(self._data["fit"]["parameters"])

    @property
    def correl(self) -> list[list[float]]:
        """Correlation of ``params``, row by row in their order."""
        return [list(row) for row in self._data["fit"]["correlation"]]

    @property
    def covar(self) -> list[list[float]]:
        """Covariance of ``params``, row by row in their order and units."""
        errors = [one["standard_error"] for one in self._data["fit"]["parameters"]]
        return [
            [share * errors[i] * errors[j] for j, share in enumerate(row)]
            for i, row in enumerate(self._data["fit"]["correlation"])
        ]

    @property
    def profiles(self) -> dict[str, list[tuple[float, float]]]:
        """Of each fault that is present: values, and the rise of chi-square where it is held there."""
        return {one["id"]: [(value, rise) for value, rise in one["points"]] for one in self._data["fit"]["profiles"]}

    def to_pandas(self) -> Any:
        """Every fault of the rig with ``fault``, ``value``, ``low``, ``high``, ``unit``, ``probability`` and more."""
        return self["faults"].to_pandas().rename(columns={"id": "fault"})

    def to_polars(self) -> Any:
        """The same as a DataFrame of polars."""
        return self["faults"].to_polars().rename({"id": "fault"})

    def __repr__(self) -> str:
        def told(fault: Item) -> str:
            low, high = ("open" if end is None else f"{end:.5g}" for end in fault["ci95"])
            # Nothing is wholly certain, which a rounded 100 % would say.
            sure = "> 99.9 %" if fault["probability"] > 0.999 else f"{100 * fault['probability']:.1f} %"
            return f"{fault['id']} {fault['value']:.5g} {fault['unit']} (95 %: {low} to {high}, {sure})"

        found = "; ".join(told(fault) for fault in self.present)
        # A record that could not have shown a fault says nothing of it.
        healthy = self["verdict"] == "healthy"
        unseen = [fault["id"] for fault in self["faults"] if healthy and fault["identifiable"] is False and fault["remark"]]
        open = f"; the record does not determine {', '.join(unseen)}" if unseen else ""
        return f"{self['verdict'].upper()}{': ' if found else ''}{found}{open}"


class Improvement(Result):
    """Physics that was added to a model, and what each addition bought; ``rig`` is the rig with it."""

    def __init__(self, text: str, page: str | None, curves: str | None, rig: Rig) -> None:
        super().__init__(text, page, curves)
        self.rig = rig

    @property
    def ledger(self) -> Table:
        """The steps: your model, then each addition."""
        return Table(self._data["steps"])


class Calibration(Result):
    """What healthy records say of a rig; ``rig`` is the rig with it."""

    def __init__(self, text: str, page: str | None, rig: Rig) -> None:
        super().__init__(text, page)
        self.rig = rig
