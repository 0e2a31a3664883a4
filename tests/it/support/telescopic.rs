//! The telescopic rig with its open records: each diagnosis and the calibration worked out once for all tests.

use std::collections::BTreeMap;
use std::sync::{Mutex, OnceLock};

use borescope::internals::calibration::{Calibrated, CalibrationOptions, calibrate};
use borescope::internals::diagnosis::{Diagnosis, DiagnosisOptions, diagnose};
use borescope::{Context, Model, Record, Rig};

pub const RIG: &str = "fixtures/telescopic/rig.toml";

/// A result with what it took: simulations and linearisations.
pub struct Worked<T> {
    pub result: T,
    pub effort: [u64; 2],
}

fn rig() -> Rig {
    Rig::read(RIG).unwrap().with_context(&Context::new())
}

pub fn record(name: &str) -> Record {
    Record::read(format!("fixtures/telescopic/{name}.csv")).unwrap()
}

fn worked<T>(rig: &Rig, result: T) -> Worked<T> {
    let effort = rig.context().effort();
    Worked { result, effort: [effort.simulations(), effort.linearisations()] }
}

/// The diagnosis of an open record, with the whole rig file.
pub fn diagnosis(name: &'static str) -> &'static Worked<Diagnosis> {
    static ALL: Mutex<BTreeMap<&str, &OnceLock<Worked<Diagnosis>>>> = Mutex::new(BTreeMap::new());
    let one = *ALL.lock().unwrap().entry(name).or_insert_with(|| Box::leak(Box::default()));
    one.get_or_init(|| {
        let rig = rig();
        let found = diagnose(&Model::new(rig.clone()), &record(name), &DiagnosisOptions::default());
        worked(&rig, found.unwrap().diagnosis)
    })
}

/// The rig calibrated on its first healthy record.
pub fn calibrated() -> &'static Worked<Calibrated> {
    static CALIBRATED: OnceLock<Worked<Calibrated>> = OnceLock::new();
    CALIBRATED.get_or_init(|| {
        let (rig, text) = (rig(), std::fs::read_to_string(RIG).unwrap());
        let found = calibrate(&text, &rig, &[record("healthy_1")], &CalibrationOptions::default());
        worked(&rig, found.unwrap())
    })
}
