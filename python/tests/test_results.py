"""Results as Python has them: copies, tables, texts, and the words in them."""

import builtins
import copy
import json
import multiprocessing
import os
import pickle
import re
import warnings
from pathlib import Path

import pytest

import borescope as bs
from borescope._result import TABLES
from borescope._words import in_python

ROOT = Path(os.environ.get("BORESCOPE_ROOT", Path(__file__).parents[2]))
TANKS = ROOT / "fixtures/two_tanks/rig.toml"


@pytest.fixture(scope="module")
def results(tanks, clogged):
    """One of every type, with items and tables of it."""
    healthy, check = tanks.simulate(seed=2), tanks.simulate(seed=3)
    diagnosis, improvement = tanks.diagnose(clogged), tanks.improve(healthy, check)
    calibration, found = tanks.calibrate([healthy]), tanks.suggest(healthy, check)
    several = [diagnosis, improvement, calibration, found, tanks.check(clogged), tanks.isolability(), tanks.campaign(1)]
    parts = [diagnosis.faults, diagnosis.params[0], diagnosis.findings[0].next, improvement.ledger, found.candidates]
    return [*several, *parts, bs.effects(), bs.components(), clogged]


def test_results_can_be_pickled_and_copied(results):
    for one in results:
        for other in (pickle.loads(pickle.dumps(one)), copy.copy(one), copy.deepcopy(one)):
            assert type(other) is type(one) and repr(other) == repr(one)
            if not isinstance(one, bs.Record):
                assert other == one
    improvement = pickle.loads(pickle.dumps(results[1]))
    assert improvement.rig.text == results[1].rig.text and improvement.page == results[1].page
    with pytest.raises(AttributeError, match="there is no `verdicts` here, but schema, "):
        results[0].verdicts


def _diagnosed(seed):
    rig = bs.Rig(TANKS)
    return rig.diagnose(rig.simulate(seed=seed))


def test_a_pool_gives_results_back():
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        verdicts = [one.verdict for one in pool.map_async(_diagnosed, [1, 2]).get(timeout=300)]
    assert verdicts == ["healthy", "healthy"]


def test_lists_without_objects_are_tables_as_the_schemas_have_them(tanks, results):
    objects = set()

    def kinds(schema, kind):
        kind = schema["$defs"][kind["$ref"].removeprefix("#/$defs/")] if "$ref" in kind else kind
        return [kind] + [each for form in ("anyOf", "oneOf") for one in kind.get(form, []) for each in kinds(schema, one)]

    def has_objects(schema, value):
        lists = [kind["items"] for kind in kinds(schema, value) if isinstance(kind.get("items"), dict)]
        return any("properties" in item for items in lists for item in kinds(schema, items))

    def walk(schema, node):
        if isinstance(node, dict):
            # A key may be called `properties` itself; then its value is a schema, with strings.
            own = node.get("properties", {}).items()
            objects.update(key for key, value in own if isinstance(value, dict) and has_objects(schema, value))
        for value in node.values() if isinstance(node, dict) else node if isinstance(node, list) else []:
            walk(schema, value)

    for path in (ROOT / "docs/schema").glob("*.json"):
        schema = json.loads(path.read_text(encoding="utf-8"))
        walk(schema, schema)
    assert objects == TABLES
    found = results[3]
    assert found.conclusion == "adequate" and isinstance(found.candidates, bs.Table) and found.candidates == []
    assert len(found.candidates.to_pandas()) == 0 and found.candidates.names() == []
    assert isinstance(found.faults, bs.Table) and isinstance(found.dynamics, bs.Table)
    # Texts are none.
    assert tanks.check().rig.warnings == [] and not isinstance(tanks.check().rig.warnings, bs.Table)


def test_what_is_printed_has_the_content(tanks, clogged, results):
    diagnosis = results[0]
    assert re.search(r"\nupper_outlet\.diameter +.*True", repr(diagnosis.faults)), diagnosis.faults
    page = diagnosis.faults._repr_html_()
    assert "<th>low</th>" in page and "<td>upper_outlet.diameter</td>" in page
    assert re.search(r"\nlevel_2 ", repr(tanks.compare(clogged).channels))
    assert "sensors: level_1, level_2" in repr(tanks) and "upper_outlet.diameter" in tanks._repr_html_()
    assert "line-resistance" in repr(bs.effects()) and "line-resistance" in bs.effects()._repr_html_()
    isolability = tanks.isolability()
    assert "faults detectable" in repr(isolability)
    assert list(isolability.tests.to_pandas().columns) == ["faults", "signals", "equations"]
    assert "detected " in repr(results[6]) and "false alarms " in repr(results[6])


def test_a_history_prints_its_trends(tanks, tmp_path):
    store = bs.Store(tmp_path / "tanks.db")
    with warnings.catch_warnings(action="ignore"):
        for day in (1, 2, 3):
            store.diagnose(tanks, tanks.simulate(seed=day), at=f"2026-05-0{day}")
    told = store.history(tanks)
    assert "upper_outlet.diameter" in repr(told) and "trend.slope" in told.faults.to_pandas().columns
    # The folder of the call is gone when the store is read.
    assert store.runs()["record"] == ["simulated.csv"] * 3
    nameless = bs.Rig(text=tanks.text.replace('name = "two tanks"', 'name = ""'))
    with warnings.catch_warnings(action="ignore"):
        store.diagnose(nameless, nameless.simulate(seed=1))
    assert len(store.history(nameless).runs) == 1 and "rig.toml" in store.runs()["rig"]


def test_a_record_that_shows_nothing_is_not_simply_healthy(tanks):
    columns = {"time [s]": [0.0, 1.0], "u [V]": [1.0, 1.0], "level_1 [mm]": [0.0, 0.1], "level_2 [mm]": [0.0, 0.0]}
    record = bs.Record(columns)
    with pytest.warns(bs.Note, match="2 rows give 4 samples of sensors, no more than the"):
        diagnosis = tanks.diagnose(record)
    assert repr(diagnosis) == "HEALTHY; the record does not determine upper_outlet.diameter"


def test_a_path_is_no_record_and_says_where_it_is_taken():
    for path in ("stroke.csv", Path("stroke.csv")):
        with pytest.raises(bs.Complaint, match=r"give the path itself to `rig.diagnose\(path\)`"):
            bs.Record(path)
    with pytest.raises(bs.Complaint, match="give the bytes themselves"):
        bs.Record(b"time [s]")


def test_without_tqdm_a_call_goes_on(tanks, clogged, monkeypatch):
    real = builtins.__import__

    def without(name, *rest):
        if name.startswith("tqdm"):
            raise ImportError(name)
        return real(name, *rest)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.warns(bs.Note, match="there is no bar without tqdm"):
        assert tanks.diagnose(clogged, progress=True).verdict == "faulty"


#: What only the command has: its own arguments, and verbs that Python has not.
ONLY_THERE = ("--merge", "--features")


def test_messages_name_what_python_has(tanks, clogged):
    texts = []
    for path in (ROOT / "src").rglob("*.rs"):
        for line in path.read_text(encoding="utf-8").splitlines():
            if not line.strip().startswith("//"):
                texts += re.findall(r'"((?:[^"\\]|\\.)*`(?:--[a-z]|(?:borescope |diagnose )[a-z-])[^`]*`(?:[^"\\]|\\.)*)"', line)
    assert len(texts) > 40
    left = [text for text in texts if re.search("`[^`]*(--[a-z]|borescope [a-z])[^`]*`", in_python(text))]
    assert [text for text in left if not any(there in text for there in ONLY_THERE)] == []
    with pytest.raises(bs.Complaint) as caught:
        tanks.simulate(set={"upper_outlet.diametre": "6 mm"})
    assert '`set={"upper_outlet.diametre": "6 mm"}`' in str(caught.value)
    with pytest.raises(bs.Complaint) as caught:
        tanks.simulate(set={"upper_outlet.diameter": 6.0})
    assert '`set={"upper_outlet.diameter": "6.0"}`: `6.0` has no unit' in str(caught.value)
    diagnosis = tanks.diagnose(clogged)
    assert diagnosis.findings[0].next.command.startswith("rig.")
    assert "borescope diagnose" in diagnosis.json and not re.search("borescope (check|diagnose|suggest|isolability) ", diagnosis.page)


@pytest.mark.parametrize(
    ("command", "call"),
    [
        ("borescope suggest a.toml b.csv --check ANOTHER_RECORD", "rig.suggest(record, another_record)"),
        ("borescope improve a.toml --fit a.csv --check b.csv -o better.toml", "rig.improve(record, check)"),
        ("borescope add a.toml x@A --fit b.csv -o better.toml", 'rig.add("x@A", record)'),
        ("borescope compare new.toml c.csv --before a.toml", "result.rig.compare(check)"),
        ("borescope diagnose a.toml 'my record.csv' --report d.html", 'rig.diagnose(record).save("d.html")'),
        ("borescope calibrate a.toml HEALTHY_RECORD -o calibrated.toml", "rig.calibrate([healthy_record]).rig"),
        ("borescope history a.toml --store runs.db", 'bs.history("runs.db", rig)'),
        # Python has no single case of a campaign.
        ("borescope campaign a.toml --cases 9 --case 3", "borescope campaign a.toml --cases 9 --case 3"),
    ],
)
def test_the_next_command_is_a_call(command, call):
    assert in_python(f"Next: {command}") == f"Next: {call}"


def test_what_is_in_memory_is_named_by_rows_and_lines(tanks):
    columns = {"time [s]": [0.0, 1.0, 0.5], "u [V]": [1.0] * 3, "level_1 [mm]": [0.0] * 3, "level_2 [mm]": [0.0] * 3}
    with pytest.raises(bs.Complaint, match="row 2 of the record `stroke`: the time runs backwards"):
        tanks.diagnose(bs.Record(columns, name="stroke"))
    columns |= {"time [s]": [0.0, 1.0, 2.0], "level_2 [bar]": columns.pop("level_2 [mm]")}
    with pytest.raises(bs.Complaint) as caught:
        tanks.diagnose(bs.Record(columns, name="stroke"))
    assert "the record `stroke`" in str(caught.value) and "stroke.csv" not in str(caught.value)
    # The lines of a file are lines.
    with pytest.raises(bs.Complaint, match="record.csv:3 and record.csv:4: the time runs backwards"):
        tanks.diagnose(b"time [s],u [V],level_1 [mm],level_2 [mm]\n0,1,0,0\n1,1,0,0\n0.5,1,0,0\n")
    with pytest.raises(bs.Complaint, match=r"line \d+ of the text of the rig: "):
        bs.Rig(text=tanks.text.replace("[nodes]", "[node]"))


def test_a_draft_takes_the_scatter_of_columns_without_fixed_decimals():
    import math

    turn = [math.sin(1e4 * row * row) + math.sin(7e3 * row * row + 1) for row in range(3000)]
    ram = [300 * min(row / 2000, 1) + 0.05 * noise for row, noise in enumerate(turn)]
    record = bs.Record({"t": [0.01 * row for row in range(3000)], "ram": ram}, units={"t": "s", "ram": "mm"})
    stated = re.search(r'ram = .*noise = "([0-9.]+) mm"', bs.draft(record).text)
    assert stated and 0.03 < float(stated[1]) < 0.07
