"""Work on a cluster whose workers and scheduler are killed: what is merged is what one process gives."""

import os
import sys
import threading
from pathlib import Path

import pytest

import borescope as bs
from borescope.distributed import campaign, diagnose_fleet

pytest.importorskip("distributed")
sys.path.insert(0, str(Path(__file__).parent))

from processes import Processes  # noqa: E402

ROOT = Path(os.environ.get("BORESCOPE_ROOT", Path(__file__).parents[2]))
TANKS = ROOT / "fixtures/two_tanks/rig.toml"
# The campaign of the tanks is the same test; this one has calibrations of half a minute.
SLOWEST = pytest.mark.skipif(os.environ.get("BORESCOPE_SLOW") != "2", reason="takes half an hour: set BORESCOPE_SLOW=2")
SLOW = pytest.mark.skipif("BORESCOPE_SLOW" not in os.environ, reason="takes minutes: set BORESCOPE_SLOW=1")


def campaign_bytes(path):
    """The bytes of a table of cases without the time of each, its last column."""
    lines = path.read_bytes().splitlines()
    assert lines[0].endswith(b",time [s]")
    return [line.rpartition(b",")[0] for line in lines]


def fleet_bytes(path):
    """The bytes of a table of runs without when they were diagnosed, its fourth column; the ones before it hold no commas."""
    lines = [line.split(b",", 4) for line in path.read_bytes().splitlines()]
    assert lines[0][3] == b"diagnosed_at" and all(line[3].startswith(b"20") for line in lines[1:])
    return [line[:3] + line[4:] for line in lines]


def outlives(work):
    """Does ``work(client, progress)`` with three workers and 60 shards: SIGKILL for a worker after a third, for another after two
    thirds, and for the scheduler five shards before the end; then once more, with another scheduler."""
    killed, reached = [], []
    with Processes(3) as cluster:

        def kill(done, of):
            reached.append(done)
            if done in (of // 3, 2 * of // 3):
                killed.append(cluster.kill_worker())
            if done == of - 5:
                cluster.kill_scheduler()

        with cluster.client(timeout="5s") as client:
            with pytest.raises(bs.Complaint, match="the scheduler") as caught:
                work(client, kill)
    assert len(set(killed)) == 2
    assert "the same call" in caught.value.remedy
    # What was under way when the scheduler died is not counted, and nothing after it.
    assert reached == list(range(1, 56)), reached
    again = []
    with Processes(3) as cluster, cluster.client() as client:
        result = work(client, lambda done, of: again.append((done, of)))
    assert again[-1] == (60, 60)
    return result


def check_campaign(rig, folder, cases, options):
    result = outlives(
        lambda client, progress: campaign(client, rig, cases, folder / "campaign", shards=60, progress=progress, **options)
    )
    assert len(result.cases) == cases
    (folder / "whole").mkdir()
    words = ["campaign", str(folder / "campaign/rig.toml"), "--cases", str(cases)]
    words += [word for name, value in options.items() for word in (f"--{name}", str(value))]
    bs._complaint.call([*words, "-o", str(folder / "whole")])
    merged, whole = (campaign_bytes(folder / table) for table in ("campaign/merged/cases.csv", "whole/cases.csv"))
    assert len(whole) == cases + 1 and merged == whole


def test_a_campaign_outlives_two_workers_and_the_scheduler(tmp_path):
    check_campaign(bs.Rig(TANKS), tmp_path, 120, {"seed": 7, "rigs": 60})


@SLOWEST
def test_a_campaign_of_the_telescopic_rig_outlives_them_too(tmp_path):
    check_campaign(bs.Rig(ROOT / "fixtures/telescopic/rig.toml"), tmp_path, 60, {"seed": 7, "rigs": 60})


def a_fleet(folder, count):
    """A list of so many records of tanks, two of them damaged."""
    rig, lines = bs.Rig(TANKS), ["record,rig"]
    for number in range(count - 2):
        record = rig.simulate(seed=number, set={"upper_outlet.diameter": "6.5 mm" if number % 3 == 0 else "8 mm"})
        (folder / f"{number}.csv").write_text(record.to_csv())
        lines.append(f"{number}.csv,tank {number}")
    (folder / "torn.csv").write_text("time [s],level_1")
    (folder / "list.csv").write_text("\n".join([*lines, "torn.csv,tank 0", "gone.csv,tank 1", ""]))
    return rig, folder / "list.csv"


def test_a_fleet_with_damaged_records(tmp_path):
    rig, records = a_fleet(tmp_path, 14)
    with Processes(3) as cluster, cluster.client() as client:
        result = diagnose_fleet(client, rig, records, tmp_path / "fleet", shards=5)
        # A call that goes on keeps the number of shards, and is told of another one.
        assert diagnose_fleet(client, rig, records, tmp_path / "fleet").json == result.json
        with pytest.raises(bs.Complaint, match="in 5 shards, not 6"):
            diagnose_fleet(client, rig, records, tmp_path / "fleet", shards=6)
        other = bs.Rig(text=rig.text.replace('diameter = "8 mm"', 'diameter = "7.9 mm"', 1))
        with pytest.raises(bs.Complaint, match="another rig file"):
            diagnose_fleet(client, other, records, tmp_path / "fleet", shards=5)
        with pytest.raises(bs.Complaint, match="no such file"):
            diagnose_fleet(client, rig, tmp_path / "no_list.csv", tmp_path / "other", shards=5)
    assert (result.counts.records, result.counts.healthy, result.counts.faulty, result.counts.failed) == (14, 8, 4, 2)
    assert [Path(failure.record).name for failure in result.failures] == ["torn.csv", "gone.csv"]
    states = {one.rig: one.state for one in bs.fleet(tmp_path / "fleet/fleet.parquet").rigs}
    assert len(states) == 12 and states["tank 3"] == "faulty" and states["tank 4"] == "healthy"


def test_a_cluster_that_grows_from_nothing(tmp_path):
    """An adaptive one may have no worker when it is asked for the first time."""
    with Processes(0) as cluster, cluster.client() as client:
        threading.Timer(1.0, lambda: [cluster.start_worker() for _ in range(2)]).start()
        result = campaign(client, TANKS, 6, tmp_path / "campaign", rigs=6)
    assert len(result.cases) == 6 and len(list((tmp_path / "campaign/shards").iterdir())) == 6


def test_a_worker_of_another_version_says_so(tmp_path, monkeypatch):
    """Before it does anything: its shards could not be merged with those of the others."""
    monkeypatch.setattr("borescope.distributed.__version__", "99.0.0")
    with Processes(1) as cluster, cluster.client() as client:
        with pytest.raises(bs.Complaint, match=f"has version {bs.__version__} of the package, and this program has 99.0.0") as caught:
            campaign(client, TANKS, 2, tmp_path / "campaign", shards=2)
    assert "the same version on all workers" in caught.value.remedy
    assert not list(tmp_path.glob("campaign/shards/*/done.json"))


@SLOW
def test_a_fleet_of_300_records_outlives_two_workers_and_the_scheduler(tmp_path):
    rig, records = a_fleet(tmp_path, 300)
    table = tmp_path / "fleet.csv"
    result = outlives(
        lambda client, progress: diagnose_fleet(
            client, rig, records, tmp_path / "fleet", table=table, shards=60, progress=progress
        )
    )
    assert (result.counts.records, result.counts.failed) == (300, 2)
    assert sorted(Path(failure.record).name for failure in result.failures) == ["gone.csv", "torn.csv"]
    # Tables name the rig file.
    wrong = bs.diagnose_fleet(records, rig=tmp_path / "fleet/rig.toml", out=tmp_path / "whole")
    assert len(wrong) == 2
    bs._complaint.call(["diagnose", "--merge", str(tmp_path / "whole"), "-o", str(tmp_path / "whole.csv")])
    whole = fleet_bytes(tmp_path / "whole.csv")
    assert len(whole) == 298 + 1 and fleet_bytes(table) == whole
