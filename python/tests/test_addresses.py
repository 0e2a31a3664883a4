"""Records at https:// and s3:// addresses, from servers of this machine."""

import functools
import http.server
import os
import threading
from pathlib import Path

import pytest

import borescope as bs

ROOT = Path(os.environ.get("BORESCOPE_ROOT", Path(__file__).parents[2]))
TANKS = str(ROOT / "fixtures/two_tanks/rig.toml")
fsspec = pytest.importorskip("fsspec", reason="records at addresses were not tried: `pip install fsspec`")


@pytest.fixture(scope="module")
def record(tmp_path_factory):
    path = tmp_path_factory.mktemp("records") / "clogged.csv"
    path.write_text(bs.Rig(TANKS).simulate(set={"upper_outlet.diameter": "6.5 mm"}, seed=1).to_csv())
    return path


def check(address, record):
    rig = bs.Rig(TANKS)
    there, here = rig.diagnose(address), rig.diagnose(record)
    assert there.record == "clogged.csv" and there.verdict == "faulty"
    assert there.faults.to_pandas().equals(here.faults.to_pandas())
    with pytest.raises(bs.Complaint, match="cannot be read") as caught:
        rig.diagnose(address.replace("clogged", "gone"))
    assert caught.value.file.endswith("gone.csv") and caught.value.remedy


def test_a_record_from_a_web_server(record):
    pytest.importorskip("aiohttp", reason="https:// was not tried: `pip install aiohttp`")

    class Quiet(http.server.SimpleHTTPRequestHandler):
        def log_message(self, *_):
            pass

    handler = functools.partial(Quiet, directory=str(record.parent))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        check(f"http://127.0.0.1:{server.server_address[1]}/clogged.csv", record)
        server.shutdown()


def test_a_list_of_records_at_addresses(record, tmp_path):
    system = fsspec.filesystem("memory")
    for name in ("one", "two"):
        system.pipe(f"/fleet/{name}.csv", record.read_bytes())
    wrong = bs.diagnose_fleet("memory://fleet/*.csv", rig=TANKS, out=tmp_path / "rows")
    assert wrong == []
    listed = (tmp_path / "rows/list.csv").read_text().splitlines()
    assert len(listed) == 3 and listed[1].endswith("Z") and "/one.csv" in listed[1]
    # Files and addresses in one list, one of them gone: named and counted once.
    (tmp_path / "list.csv").write_text(f"record;rig\n{record};first\nmemory://fleet/two.csv;second\nmemory://fleet/gone.csv;third\n")
    with pytest.warns(bs.Note, match="gone.csv: the record cannot be read"):
        wrong = bs.diagnose_fleet(tmp_path / "list.csv", rig=TANKS, out=tmp_path / "more")
    assert len(wrong) == 1 and "gone.csv" in str(wrong[0])
    bs._complaint.call(["diagnose", "--merge", str(tmp_path / "more"), "-o", str(tmp_path / "fleet.csv")])
    assert {one.rig: one.state for one in bs.fleet(tmp_path / "fleet.csv").rigs} == {"first": "faulty", "second": "faulty"}
    with pytest.raises(bs.Complaint, match="no records of this pattern"):
        bs.diagnose_fleet("memory://nowhere/*.csv", rig=TANKS, out=tmp_path / "none")


def test_a_record_from_a_bucket(record, monkeypatch):
    pytest.importorskip("s3fs", reason="s3:// was not tried: `pip install s3fs`")
    moto = pytest.importorskip("moto.server", reason='s3:// was not tried: `pip install "moto[s3,server]"`')
    server = moto.ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
    server.start()
    host, port = server.get_host_and_port()
    # On a busy machine the server may need longer than what s3fs waits for a cloud.
    patient = {"connect_timeout": 600, "read_timeout": 600}
    options = {"endpoint_url": f"http://{host}:{port}", "key": "key", "secret": "secret", "config_kwargs": patient}
    monkeypatch.setitem(fsspec.config.conf, "s3", options)
    try:
        bucket = fsspec.filesystem("s3", skip_instance_cache=True)
        bucket.mkdir("rigs")
        bucket.put(str(record), "rigs/2026/clogged.csv")
        check("s3://rigs/2026/clogged.csv", record)
    finally:
        server.stop()
