"""Work on a cluster whose workers and scheduler are killed: what is merged is what one process gives."""

import csv
import os
import sys
from pathlib import Path

import pytest

import borescope as bs
from borescope.distributed import campaign, diagnose_fleet

pytest.importorskip("distributed")
sys.path.insert(0, str(Path(__file__).parent))

from processes import Processes  # noqa: E402

ROOT = Path(os.environ.get("BORESCOPE_ROOT", Path(__file__).parents[2]))
TANKS = ROOT / "fixtures/two_tanks/rig.toml"
SLOW = pytest.mark.skipif("BORESCOPE_SLOW" not in os.environ, reason="takes minutes: set BORESCOPE_SLOW=1")


def rows(path, without):
    with open(path, newline="") as file:
        return [{key: value for key, value in row.items() if key not in without} for row in csv.DictReader(file)]


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
    merged, whole = folder / "campaign/merged/cases.csv", folder / "whole/cases.csv"
    assert rows(merged, ["time [s]"]) == rows(whole, ["time [s]"])
    # The time is the last column: without it the tables are the same bytes.
    cut = [[line.rpartition(b",")[0] for line in path.read_bytes().splitlines()] for path in (merged, whole)]
    assert cut[0] == cut[1]


def test_a_campaign_outlives_two_workers_and_the_scheduler(tmp_path):
    check_campaign(bs.Rig(TANKS), tmp_path, 120, {"seed": 7, "rigs": 60})


@SLOW
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
        other = bs.Rig(text=rig.text.replace('diameter = "8 mm"', 'diameter = "7.9 mm"', 1))
        with pytest.raises(bs.Complaint, match="another rig file"):
            diagnose_fleet(client, other, records, tmp_path / "fleet", shards=5)
        with pytest.raises(bs.Complaint, match="no such file"):
            diagnose_fleet(client, rig, tmp_path / "no_list.csv", tmp_path / "other", shards=5)
    assert (result.counts.records, result.counts.healthy, result.counts.faulty, result.counts.failed) == (14, 8, 4, 2)
    assert [Path(failure.record).name for failure in result.failures] == ["torn.csv", "gone.csv"]
    states = {one.rig: one.state for one in bs.fleet(tmp_path / "fleet/fleet.parquet").rigs}
    assert len(states) == 12 and states["tank 3"] == "faulty" and states["tank 4"] == "healthy"


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
    assert rows(table, ["diagnosed_at"]) == rows(tmp_path / "whole.csv", ["diagnosed_at"])
