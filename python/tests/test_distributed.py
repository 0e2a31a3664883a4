"""Work on a cluster whose workers and scheduler are killed: what is merged is what one process gives."""

import csv
import os
import signal
from pathlib import Path

import pytest

import borescope as bs
from borescope.distributed import campaign, diagnose_fleet

distributed = pytest.importorskip("distributed")

ROOT = Path(os.environ.get("BORESCOPE_ROOT", Path(__file__).parents[2]))
TANKS = ROOT / "fixtures/two_tanks/rig.toml"


def cluster():
    return distributed.LocalCluster(n_workers=3, threads_per_worker=1, dashboard_address=None)


def rows(path, without):
    with open(path, newline="") as file:
        return [{key: value for key, value in row.items() if key not in without} for row in csv.DictReader(file)]


def test_a_campaign_outlives_two_workers_and_the_scheduler(tmp_path):
    rig = bs.Rig(TANKS)
    options = {"seed": 7, "rigs": 60}
    killed = []

    with cluster() as own, distributed.Client(own) as client:

        def kill(done, of):
            if done in (of // 3, 2 * of // 3):
                pid = next(iter(client.run(os.getpid).values()))
                os.kill(pid, signal.SIGKILL)
                killed.append(pid)
            if done == of - 5:
                raise InterruptedError("the scheduler dies")

        with pytest.raises(InterruptedError):
            campaign(client, rig, 120, tmp_path / "campaign", shards=60, progress=kill, **options)
    assert len(killed) == 2

    again = []
    with cluster() as own, distributed.Client(own) as client:
        result = campaign(
            client, rig, 120, tmp_path / "campaign", shards=60, progress=lambda done, of: again.append(done), **options
        )
    assert again[-1] == 60
    assert len(result.cases) == 120

    (tmp_path / "whole").mkdir()
    words = ["campaign", str(tmp_path / "campaign/rig.toml"), "--cases", "120", "--seed", "7", "--rigs", "60"]
    bs._complaint.call([*words, "-o", str(tmp_path / "whole")])
    assert rows(tmp_path / "campaign/merged/cases.csv", ["time [s]"]) == rows(tmp_path / "whole/cases.csv", ["time [s]"])


def test_a_fleet_with_damaged_records(tmp_path):
    rig = bs.Rig(TANKS)
    lines = ["record,rig"]
    for number in range(12):
        record = rig.simulate(seed=number, set={"upper_outlet.diameter": "6.5 mm" if number % 3 == 0 else "8 mm"})
        (tmp_path / f"{number}.csv").write_text(record.to_csv())
        lines.append(f"{number}.csv,tank {number}")
    (tmp_path / "torn.csv").write_text("time [s],level_1")
    (tmp_path / "list.csv").write_text("\n".join([*lines, "torn.csv,tank 0", "gone.csv,tank 1", ""]))
    with cluster() as own, distributed.Client(own) as client:
        result = diagnose_fleet(client, rig, tmp_path / "list.csv", tmp_path / "fleet", shards=5)
        other = bs.Rig(text=rig.text.replace('diameter = "8 mm"', 'diameter = "7.9 mm"', 1))
        with pytest.raises(bs.Complaint, match="another rig file"):
            diagnose_fleet(client, other, tmp_path / "list.csv", tmp_path / "fleet", shards=5)
        with pytest.raises(bs.Complaint, match="no such file"):
            diagnose_fleet(client, rig, tmp_path / "no_list.csv", tmp_path / "other", shards=5)
    assert (result.counts.records, result.counts.healthy, result.counts.faulty, result.counts.failed) == (14, 8, 4, 2)
    assert [Path(failure.record).name for failure in result.failures] == ["torn.csv", "gone.csv"]
    states = {one.rig: one.state for one in bs.fleet(tmp_path / "fleet/fleet.parquet").rigs}
    assert len(states) == 12 and states["tank 3"] == "faulty" and states["tank 4"] == "healthy"
