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


def test_a_record_from_a_bucket(record, monkeypatch):
    pytest.importorskip("s3fs", reason="s3:// was not tried: `pip install s3fs`")
    moto = pytest.importorskip("moto.server", reason='s3:// was not tried: `pip install "moto[s3,server]"`')
    server = moto.ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
    server.start()
    host, port = server.get_host_and_port()
    options = {"endpoint_url": f"http://{host}:{port}", "key": "key", "secret": "secret"}
    monkeypatch.setitem(fsspec.config.conf, "s3", options)
    try:
        bucket = fsspec.filesystem("s3", skip_instance_cache=True)
        bucket.mkdir("rigs")
        bucket.put(str(record), "rigs/2026/clogged.csv")
        check("s3://rigs/2026/clogged.csv", record)
    finally:
        server.stop()
