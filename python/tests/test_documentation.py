"""What the README shows runs as it stands there, in a folder with the files that it names."""

import os
import re
import warnings
from pathlib import Path

import pytest

import borescope as bs

ROOT = Path(os.environ.get("BORESCOPE_ROOT", Path(__file__).parents[2]))
PRESS = ROOT / "fixtures/press"


def blocks(path):
    return re.findall(r"```python\n(.*?)```", path.read_text(encoding="utf-8"), re.DOTALL)


@pytest.mark.parametrize("number", range(len(blocks(ROOT / "python/README.md"))))
def test_the_readme(number, tmp_path, monkeypatch):
    pytest.importorskip("pandas")
    block = blocks(ROOT / "python/README.md")[number]
    if "improve" in block and "BORESCOPE_SLOW" not in os.environ:
        pytest.skip("takes minutes: set BORESCOPE_SLOW=1")
    monkeypatch.chdir(tmp_path)
    press = bs.Rig(bs.example(tmp_path / "made") / "rig.toml")
    press.save(tmp_path / "press.toml")
    for name, seed in [("ok_1", 1), ("ok_2", 2)]:
        # What a file is, its bytes say.
        (tmp_path / f"{name}.mf4").write_text(press.simulate(seed=seed).to_csv())
    lacking = press.add("external-leakage@A")
    leak = next(one.id for one in lacking.check().rig.parameters if one.id.startswith("external-leakage"))
    for name, seed in [("stroke", 3), ("check", 4)]:
        record = lacking.simulate(set={leak: "0.02 L/min/bar", "cylinder.clearance": "0.1 mm"}, seed=seed)
        (tmp_path / f"{name}.csv").write_text(record.to_csv())
    with warnings.catch_warnings(action="ignore"):
        exec(compile(block, "README.md", "exec"), {})


def test_what_there_is_to_begin_with(tmp_path):
    folder = bs.example(tmp_path / "press")
    with pytest.raises(bs.Complaint, match="there is such a file"):
        bs.example(folder)
    drafted = bs.draft(folder / "healthy.csv", bore="63 mm", rod="36 mm", stroke="200 mm")
    assert "63" in drafted.text and drafted.check(folder / "healthy.csv").schema == "borescope.check/1"
    assert any(component["kind"] == "pump" for component in bs.components()["components"])
    watched = bs.Rig(folder / "rig.toml").monitor(folder / "leak.csv", 2.0, fits=1)
    assert watched.schema == "borescope.windows/1" and watched.windows
