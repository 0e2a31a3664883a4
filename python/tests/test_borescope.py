"""The package beside the command: the same numbers, and a guest that behaves within Python."""

import array
import json
import math
import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

import borescope as bs

ROOT = Path(os.environ.get("BORESCOPE_ROOT", Path(__file__).parents[2]))
TANKS = str(ROOT / "fixtures/two_tanks/rig.toml")
TELESCOPIC = str(ROOT / "fixtures/telescopic/rig.toml")
LEAK = str(ROOT / "fixtures/telescopic/leak_020.csv")


def command(*words):
    return subprocess.run([sys.executable, "-m", "borescope", *words], capture_output=True, text=True)


def test_a_diagnosis_is_that_of_the_command(tanks):
    ran = command("diagnose", TELESCOPIC, LEAK, "--format", "json")
    assert ran.returncode == 0, ran.stderr
    diagnosis = bs.Rig(TELESCOPIC).diagnose(LEAK)
    clearance = diagnosis.params["cylinder.clearance"]
    assert clearance.fault and abs(clearance.value - diagnosis.faults["cylinder.clearance"].value) < 1e-3
    at = diagnosis.params.names().index("cylinder.clearance")
    assert abs(diagnosis.covar[at][at] - clearance.standard_error**2) <= 1e-9 * clearance.standard_error**2
    assert all(abs(row[i] - 1) < 1e-6 for i, row in enumerate(diagnosis.correl))
    assert min(rise for _, rise in diagnosis.profiles["cylinder.clearance"]) == 0
    assert diagnosis.json == ran.stdout
    clearance = diagnosis.faults["cylinder.clearance"]
    assert diagnosis.verdict == "faulty" and clearance.present
    assert clearance.ci95[0] < 0.2 < clearance.ci95[1] and clearance.unit == "mm"
    assert repr(diagnosis).startswith("FAULTY: cylinder.clearance 0.19997 mm (95 %: ")
    assert [fault.id for fault in diagnosis.present] == ["cylinder.clearance"]
    curves = diagnosis.curves
    assert len(curves["time [s]"]) == len(curves["p_A.measured [bar]"]) > 500
    frame = diagnosis.to_pandas()
    row = frame[frame.fault == "cylinder.clearance"].iloc[0]
    assert row.low == clearance.ci95[0] and row.high == clearance.ci95[1]
    assert diagnosis.to_polars().height == len(diagnosis.faults)
    assert "<iframe" in diagnosis._repr_html_() and "cylinder.clearance" in diagnosis.page


def test_columns_frames_bytes_and_paths_give_the_same(tanks, clogged, tmp_path):
    path = tmp_path / "record.csv"
    path.write_text(clogged.to_csv())
    columns = {f"{name} [{clogged.units[name]}]": clogged[name] for name in clogged.keys()}
    bare = {name: clogged[name] for name in clogged.keys()}
    frame = clogged.to_pandas()
    forms = [
        path,
        path.read_bytes(),
        clogged,
        columns,
        bs.Record(bare, units=clogged.units),
        # As MATLAB hands over a structure of vectors.
        bs.Record({name: array.array("d", bare[name]) for name in bare}, units=dict(zip(clogged.units, clogged.units.values()))),
        frame,
        frame.set_index("time [s]"),
        clogged.to_polars(),
    ]
    values = [tanks.diagnose(form).faults["upper_outlet.diameter"].to_dict() for form in forms]
    assert all(value == values[0] for value in values)
    assert values[0]["present"] and values[0]["ci95"][0] < 6.5 < values[0]["ci95"][1]


def test_times_may_be_dates(tanks, clogged):
    import pandas

    frame = clogged.to_pandas()
    seconds = frame.pop("time [s]")
    start = pandas.Timestamp("2026-05-01T12:00:00")
    apart = pandas.to_timedelta(seconds - seconds[0], unit="s").dt.round("us")
    wanted = [round(value, 6) for value in seconds - seconds[0]]
    dated = frame.assign(timestamp=start + apart)
    forms = [
        frame.set_index(pandas.DatetimeIndex(start + apart)),
        frame.set_index(pandas.DatetimeIndex(start + apart, tz="Europe/Berlin", name="time")),
        frame.set_index(pandas.TimedeltaIndex(apart, name="time [s]")),
        dated,
    ]
    for form in forms:
        record = bs.Record(form)
        time = next(name for name in record.keys() if name in ("time", "timestamp"))
        assert record.units[time] == "s"
        assert [round(value, 6) for value in record[time]] == wanted
        assert tanks.diagnose(record).verdict == "faulty"
    gap = dated.assign(timestamp=dated["timestamp"].where(dated.index != 3))
    with pytest.raises(bs.Complaint, match="rows without a time"):
        bs.Record(gap)


def test_a_time_of_dates_may_have_any_name_and_place(clogged):
    import pandas

    frame = clogged.to_pandas()
    seconds = frame.pop("time [s]")
    frame.insert(1, "Zeit", pandas.Timestamp("2026-05-01") + pandas.to_timedelta(seconds - seconds[0], unit="s"))
    record = bs.Record(frame)
    assert record.keys()[0] == "Zeit" and record.units["Zeit"] == "s" and record["Zeit"][0] == 0
    with pytest.raises(bs.Complaint, match="the column `Kauf` has no unit"):
        bs.Record(frame.assign(Kauf=frame["Zeit"]))
    with pytest.raises(bs.Complaint, match="no number") as caught:
        bs.Record(frame.assign(Kauf=frame["Zeit"]), units={"Kauf": "-"})
    assert "only one column of dates" in caught.value.remedy


def test_units_in_names_are_those_of_files(tanks, clogged):
    frame = clogged.to_pandas()
    wanted = tanks.diagnose(frame).faults[0].value
    for names in (["time (s)", "u (V)", "level_1 (mm)", "level_2 (mm)"], ["t_s", "u_V", "level_1_mm", "level_2_mm"]):
        named = bs.Record(frame.set_axis(names, axis=1))
        assert list(named.units.values()) == ["s", "V", "mm", "mm"] and named.keys()[1:] == ["u", "level_1", "level_2"]
        assert tanks.diagnose(named).faults[0].value == wanted
    # What is given beside the name is not looked for in it; beside square brackets `_` and round ones are part of the name.
    own = bs.Record({"t_s": [0.0], "x_mm": [1.0]}, units={"t_s": "s", "x_mm": "mm"})
    assert own.keys() == ["t_s", "x_mm"]
    assert bs.Record({"time [s]": [0.0], "level_mm [mm]": [1.0]}).keys() == ["time", "level_mm"]


def test_columns_without_units_are_told_at_once(tanks):
    import pandas

    frame = tanks.simulate(seed=1).to_pandas()
    frame.columns = ["t_s", "valve", "upper", "lower"]
    with pytest.raises(bs.Complaint, match="3 columns have no unit: `valve`, `upper`, `lower`") as caught:
        tanks.diagnose(frame)
    assert 'units={"valve": "...", "upper": "..."' in caught.value.remedy
    with pytest.raises(bs.Complaint, match="4 columns have no unit") as caught:
        tanks.diagnose(frame.rename(columns={"t_s": "t"}))
    assert 'units={"t": "s", "valve": "..."' in caught.value.remedy
    with pytest.raises(bs.Complaint, match="a Series is no record"):
        bs.Record(frame["upper"])
    units = {"t_s": "s", "valve": "V", "upper": "mm", "lower": "mm"}
    for column, told in [
        (frame["upper"].astype(object).where(frame.index != 3, "dry"), "row 3 of the column `upper` is 'dry', no number"),
        (frame["upper"].map(lambda value: f"{value:.1f}".replace(".", ",")), "no number"),
    ]:
        with pytest.raises(bs.Complaint, match=told) as caught:
            bs.Record(frame.assign(upper=column), units=units)
        assert "pandas.to_numeric" in caught.value.remedy
    gap = frame.assign(upper=frame["upper"].astype("Float64").where(frame.index != 3, pandas.NA))
    assert math.isnan(bs.Record(gap, units=units)["upper"][3])
    twice = pandas.concat([frame, frame["upper"]], axis=1)
    with pytest.raises(bs.Complaint, match="`upper` comes twice"):
        bs.Record(twice, units=units)


def test_what_the_command_says_beside_its_result_comes_too(tmp_path):
    """Keys of the JSON are attributes as they stand, and warnings are notes."""
    rig = bs.Rig(TELESCOPIC)
    ran = command("compare", TELESCOPIC, LEAK, "--format", "json")
    compared = rig.compare(LEAK)
    assert compared.json == ran.stdout and compared.as_stated.times_noise > 1
    # A load that pulls.
    pulled = rig.text.replace('"5400 N"', '"-9000 N"').replace('"0.3 bar"', '"60 bar"')
    with pytest.warns(bs.Note, match="below vacuum"):
        bs.Rig(text=pulled).simulate()


def test_the_learning_loop_on_a_frame(tanks):
    leaking = tanks.add("external-leakage@lower")
    leak = next(one.id for one in leaking.check().rig.parameters if "leak" in one.id)
    unit = next(one.unit for one in leaking.check().rig.parameters if one.id == leak)
    assert unit == "L/min/bar"
    truth = {leak: "100 L/min/bar"}
    fit, check = (leaking.simulate(set=truth, seed=seed).to_pandas() for seed in (1, 2))
    assert not tanks.compare(fit).adequate
    found = tanks.suggest(fit, check=check)
    assert found.conclusion in ("effect-found", "confounded", "partly-explained")
    assert found.candidates[0].supported
    better = tanks.improve(fit, check)
    assert len(better.ledger) >= 2 and better.ledger[1].added in repr(better)
    assert found.candidates[0].effect in repr(found)
    errors = [step["check_rmse"] for step in better.ledger]
    assert errors[-1] < 0.5 * errors[0]
    assert better.rig.compare(check).times_noise < 1.3


def test_calibration_isolability_effects_campaign(tanks, tmp_path):
    healthy = [tanks.simulate(seed=seed) for seed in (1, 2)]
    calibrated = tanks.calibrate(healthy).rig
    # One record alone needs no list around it.
    assert tanks.calibrate(healthy[0].to_pandas()).json == tanks.calibrate([healthy[0].to_pandas()]).json
    assert "[calibration]" in calibrated.text and "[calibration]" not in tanks.text
    calibrated.save(tmp_path / "rig.toml")
    with pytest.raises(bs.Complaint, match="the file exists"):
        calibrated.save(tmp_path / "rig.toml")
    assert calibrated.diagnose(healthy[0]).verdict == "healthy"
    assert tanks.isolability().schema == "borescope.isolability/1"
    assert any(effect["name"] == "external-leakage" for effect in bs.effects()["effects"])
    assert len(tanks.campaign(2, rigs=1).cases) == 2


def test_a_rig_that_names_files_may_be_saved_anywhere(tmp_path):
    boom = bs.Rig(ROOT / "fixtures/boom/rig.toml")
    sensor = boom.check().rig.sensors[0].name
    more = boom.add(f"sensor-gain@{sensor}")
    for number, rig in enumerate([boom, more, bs.Rig(text=more.text)]):
        folder = tmp_path.joinpath(*"abc"[: number + 1])
        folder.mkdir(parents=True)
        rig.save(folder / "rig.toml")
        assert "linkage.csv" in bs.Rig(folder / "rig.toml").text
    wrong = bs.diagnose_fleet([str(ROOT / "fixtures/boom/leak.csv")], rig=more, out=tmp_path / "rows")
    assert wrong == []


def test_what_is_wrong_is_one_complaint_with_its_place(tanks, tmp_path):
    path = tmp_path / "rig.toml"
    path.write_text(tanks.text.replace("diameter = \"8 mm\"", "diameter = \"8 bar\"", 1))
    with pytest.raises(bs.Complaint) as caught:
        bs.Rig(path)
    assert caught.value.file == str(path) and caught.value.line > 1 and caught.value.remedy
    assert isinstance(caught.value, ValueError)
    again = pickle.loads(pickle.dumps(caught.value))
    assert (again.what, again.line, str(again)) == (caught.value.what, caught.value.line, str(caught.value))
    columns = {"time [s]": [0.0, 1.0], "u [V]": [1.0, 1.0], "level_1 [mm]": [1.0, 1.0], "level_2 [mm]": [1.0, 1.0]}
    for change, told in [
        ({"level_1 [mm]": [1.0]}, "unequal length"),
        ({"level_1 [mm]": [1.0, "dry"]}, "row 1 of the column `level_1` is 'dry', no number"),
        ({"more": [1.0, 1.0]}, "the column `more` has no unit"),
        ({"level_1 [m]": [1.0, 1.0]}, "the column `level_1` comes twice"),
    ]:
        with pytest.raises(bs.Complaint, match=told):
            tanks.diagnose({**columns, **change})
    with pytest.raises(bs.Complaint, match="the text of a rig file, not its name"):
        bs.Rig(tanks.text)
    with pytest.raises(bs.Complaint, match="no record to calibrate on"):
        tanks.calibrate([])
    with pytest.raises(bs.Complaint, match="bore"):
        bs.draft({"time [s]": [0.0, 1.0, 2.0], "u [-]": [0.0, 1.0, 1.0], "p [bar]": [1.0, 2.0, 3.0]}, bore=50)
    with pytest.raises(bs.Complaint, match="a set is no record"):
        tanks.diagnose({1, 2})
    with pytest.raises(bs.Complaint, match="u") as caught:
        tanks.diagnose({"time [s]": [0.0, 1.0]})
    assert "/tmp" not in str(caught.value)
    assert math.isnan(bs.Record({"time [s]": [0.0], "u [V]": [None]})["u"][0])


def test_a_full_disk_is_one_complaint(tanks, clogged, tmp_path):
    """A limit on the size of files is the full disk of everyone: nothing half written is left."""
    program = f"""
import resource, signal, borescope as bs
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
rig, clogged = bs.Rig({TANKS!r}), bs.Record.read_csv({str(tmp_path / "clogged.csv")!r})
diagnosis = rig.diagnose(clogged)
resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
for call in (lambda: diagnosis.save({str(tmp_path / "page.html")!r}), lambda: rig.save({str(tmp_path / "new.toml")!r})):
    try:
        call()
    except bs.Complaint as complaint:
        print(complaint.what, complaint.remedy)
"""
    (tmp_path / "clogged.csv").write_text(clogged.to_csv())
    ran = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert ran.returncode == 0, ran.stderr
    assert ran.stdout.count("cannot be written: File too large") == 2, ran.stdout
    assert [path.name for path in tmp_path.iterdir()] == ["clogged.csv"]
    with pytest.raises(bs.Complaint, match="cannot be written"):
        tanks.save(tmp_path / "gone/rig.toml")


@pytest.fixture
def interruptible():
    """Ctrl-C as in a terminal: what is started in the background of a shell may come with SIGINT ignored."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def interrupted(call):
    """Sends Ctrl-C once a call has used half a second of processor time; gives what passed from there on to the end of the call:
    seconds of the processor, seconds of the clock, and the part of one processor that the call had before."""
    sent = []

    def interrupt():
        begun, used = time.monotonic(), time.process_time()
        while time.process_time() - used < 0.5:
            time.sleep(0.01)
        now, used_now = time.monotonic(), time.process_time()
        sent.extend([now, used_now, (used_now - used) / (now - begun)])
        os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=interrupt)
    thread.start()
    with pytest.raises(KeyboardInterrupt):
        call()
    end, used = time.monotonic(), time.process_time()
    thread.join()
    return used - sent[1], end - sent[0], sent[2]


def test_ctrl_c_ends_a_call_soon(tanks, interruptible):
    # A call of one thread works without a pause, so that its processor time is what the clock would show were the machine its own.
    ends = [interrupted(lambda: tanks.campaign(100_000, threads=1)) for _ in range(3)]
    assert max(used for used, _, _ in ends) < 0.2 + 0.1
    # Nor does it wait: of the clock counts the part in which the call would have been let work. Load that begins between is no fault of it.
    assert min(passed * min(part, 1) for _, passed, part in ends) < 0.2 + 0.1
    with pytest.raises(KeyboardInterrupt):
        threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
        tanks.campaign(100_000)
    assert tanks.check().schema == "borescope.check/1"


def waits(thread):
    """Seconds that a thread has waited for a processor that others had; where the system does not say it, none."""
    try:
        return int(Path(f"/proc/self/task/{thread.native_id}/schedstat").read_text().split()[1]) / 1e9
    except OSError:
        return 0.0


def test_other_threads_work_meanwhile_and_progress_is_told(tanks, clogged):
    stop, turns, heard = threading.Event(), [0], []

    def count():
        while not stop.is_set():
            turns[0] += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    both = (thread, threading.main_thread())
    rig = bs.Rig(TELESCOPIC)
    begun, first, waited = time.monotonic(), turns[0], sum(map(waits, both))
    rig.diagnose(LEAK, progress=lambda stage, done, of: heard.append(stage))
    took = time.monotonic() - begun
    turned, waited = turns[0] - first, sum(map(waits, both)) - waited
    stop.set()
    thread.join()
    # Time in which the machine let one of the two not work says nothing of the call.
    assert turned > 200 * (took - waited)
    assert took < 0.1 or heard
    with pytest.raises(ZeroDivisionError):
        rig.diagnose(LEAK, progress=lambda *_: 1 / 0)


def diagnose_in_a_child(record):
    return bs.Rig(TANKS).diagnose(record).verdict


@pytest.mark.parametrize("way", ["fork", "spawn"])
def test_processes_work_before_and_after(tanks, clogged, way):
    assert tanks.diagnose(clogged).verdict == "faulty"
    with multiprocessing.get_context(way).Pool(2) as pool:
        assert pool.map_async(diagnose_in_a_child, [clogged, clogged]).get(300) == ["faulty", "faulty"]


def test_a_fleet(tanks, clogged, tmp_path):
    for name, record in [("a", tanks.simulate(seed=3)), ("b", clogged)]:
        (tmp_path / f"{name}.csv").write_text(record.to_csv())
    (tmp_path / "list.csv").write_text("record,rig\na.csv,one\nb.csv,two\ngone.csv,three\n")
    wrong = bs.diagnose_fleet(tmp_path / "list.csv", rig=TANKS, out=tmp_path / "rows")
    assert len(wrong) == 1 and "gone.csv" in str(wrong[0])
    assert bs.diagnose_fleet(tmp_path / "list.csv", rig=TANKS, out=tmp_path / "rows") == []
    ran = command("diagnose", "--merge", str(tmp_path / "rows"), "-o", str(tmp_path / "table.parquet"))
    assert ran.returncode == 0, ran.stderr
    stands = bs.fleet(tmp_path / "table.parquet")
    assert [(rig.rig, rig.state) for rig in stands.rigs] == [("two", "faulty"), ("one", "healthy")]
    # A rig that is no file gets one among the rows.
    assert bs.diagnose_fleet([str(tmp_path / "a.csv")], rig=bs.Rig(text=tanks.text), out=tmp_path / "text") == []
    assert (tmp_path / "text/rig.toml").read_text() == tanks.text
    (tmp_path / "twice.csv").write_text("record\na.csv\n./a.csv\n")
    with pytest.raises(bs.Complaint, match="`./a.csv` comes twice"):
        bs.diagnose_fleet(tmp_path / "twice.csv", rig=TANKS, out=tmp_path / "twice")
    with pytest.raises(bs.Complaint, match="shards of 2 count from 1 to 2") as caught:
        bs.diagnose_fleet(tmp_path / "list.csv", rig=TANKS, out=tmp_path / "rows", shard="3/2")
    assert "--help" not in str(caught.value) and "\n" not in caught.value.what
    with pytest.raises(bs.Complaint, match="no such file"):
        bs.diagnose_fleet(tmp_path / "nowhere.csv", rig=TANKS, out=tmp_path / "rows")


def test_the_command_comes_along():
    ran = command("--version")
    assert (ran.returncode, ran.stdout) == (0, f"borescope {bs.__version__}\n")
    assert command("diagnose", TANKS, "gone.csv").returncode == 2
    assert json.loads(command("effects", "--format", "json").stdout)["schema"] == "borescope.effects/1"


def test_records_are_fetched_from_addresses(tanks, clogged, tmp_path):
    fsspec = pytest.importorskip("fsspec")
    with fsspec.open("memory://rigs/clogged.csv", "w") as file:
        file.write(clogged.to_csv())
    path = tmp_path / "clogged.csv"
    path.write_text(clogged.to_csv())
    here = tanks.diagnose(path).faults.to_pandas()
    for address in ("memory://rigs/clogged.csv", path.as_uri()):
        diagnosis = tanks.diagnose(address)
        assert diagnosis.record == "clogged.csv" and diagnosis.faults.to_pandas().equals(here)
    # Two of one name do not stand in each other's place.
    with fsspec.open("memory://other/clogged.csv", "w") as file:
        file.write(tanks.simulate(seed=2).to_csv())
    both = tanks.calibrate(["memory://rigs/clogged.csv", "memory://other/clogged.csv"])
    assert {record["record"] for record in both["records"]} == {"clogged.csv", "2_clogged.csv"}
    for address, told in [("memory://rigs/none.csv", "cannot be read"), ("nosuch://a/b.csv", "cannot be read")]:
        with pytest.raises(bs.Complaint, match=told) as caught:
            tanks.diagnose(address)
        assert caught.value.file == address and caught.value.remedy


def test_without_fsspec_an_address_says_what_to_install(tanks, monkeypatch):
    monkeypatch.setitem(sys.modules, "fsspec", None)
    with pytest.raises(bs.Complaint, match="fsspec") as caught:
        tanks.diagnose("s3://rigs/stroke.csv")
    assert "pip install" in caught.value.remedy


def test_a_store_is_that_of_the_command(tanks, tmp_path):
    path = tmp_path / "tanks.db"
    store = bs.Store(path)
    for day in (1, 2, 3):
        with pytest.warns(bs.Note, match="kept in .* as run"):
            store.diagnose(tanks, tanks.simulate(seed=day), at=f"2026-05-0{day}T12:00:00Z")
    ran = command("history", TANKS, "--store", str(path), "--format", "json")
    assert bs.history(path, tanks).json == ran.stdout == store.history(tanks).json
    assert store.history(tanks).page and len(store.history(tanks, by="run").runs) == 3
    assert len(store.to_pandas()) == len(store.runs()["run"]) == 3
    assert len(store.fleet().rigs) == 1
    with pytest.raises(bs.Complaint, match="no such store"):
        bs.Store(tmp_path / "none.db").history(tanks)


def test_notes_are_warnings_where_they_were_asked_for(tanks, clogged):
    german = clogged.to_csv().replace(",", ";").replace(".", ",").encode()
    with pytest.warns(bs.Note, match="columns between semicolons, decimal commas") as caught:
        tanks.diagnose(german)
    assert caught[0].filename == __file__
    assert str(caught[0].message).startswith("record.csv: ")
