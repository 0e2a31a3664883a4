"""Look inside a hydraulic circuit through its records: detect, isolate and size faults.

Everything is what the command ``borescope`` does, with the same numbers; see the book in ``docs/``.

>>> import borescope as bs
>>> rig = bs.Rig("../fixtures/two_tanks/rig.toml")
>>> record = rig.simulate(set={"upper_outlet.diameter": "6.5 mm"}, seed=1)
>>> diagnosis = rig.diagnose(record)
>>> diagnosis.verdict
'faulty'
>>> fault = diagnosis.faults["upper_outlet.diameter"]
>>> fault.ci95[0] < 6.5 < fault.ci95[1], fault.unit
(True, 'mm')
"""

from borescope._borescope import __version__
from borescope._complaint import Complaint, Note
from borescope._record import Record
from borescope._result import Calibration, Diagnosis, Improvement, Item, Result, Table
from borescope._rig import Rig, Store, components, diagnose_fleet, draft, effects, example, fleet, history

__all__ = [
    "Calibration",
    "Complaint",
    "Diagnosis",
    "Improvement",
    "Item",
    "Note",
    "Record",
    "Result",
    "Rig",
    "Store",
    "Table",
    "__version__",
    "components",
    "diagnose_fleet",
    "draft",
    "effects",
    "example",
    "fleet",
    "history",
]
