//! What is fuzzed: every reader of what strangers write. A target may refuse its input, but not panic, hang or eat the machine.

use borescope::Rig;
use borescope::internals::expression::{Expression, Name};
use borescope::internals::record::Asked;
use borescope::internals::record::survey::{Scatter, survey};
use borescope::internals::units::{Dimension, Quantity, Unit};

/// A target by its name, with the fixtures that it starts from.
pub struct Target {
    pub name: &'static str,
    pub run: fn(&[u8]),
    #[allow(dead_code, reason = "read where a corpus is given, by the test of all targets")]
    pub corpus: &'static [&'static str],
}

pub const TARGETS: &[Target] = &[
    Target {
        name: "record_text",
        run: record,
        corpus: &["formats/stroke_german.csv", "formats/stroke_units.tsv", "formats/small.csv"],
    },
    Target { name: "record_packed", run: record, corpus: &["formats/stroke.csv.gz", "formats/stroke.csv.zst"] },
    Target { name: "record_mat", run: record, corpus: &["formats/stroke_plain.mat", "formats/stroke_struct.mat"] },
    Target { name: "record_mdf", run: record, corpus: &["formats/stroke.mf4", "formats/stroke_rates.mf4"] },
    Target { name: "record_tdms", run: record, corpus: &["formats/stroke.tdms", "formats/stroke_rates.tdms"] },
    #[cfg(feature = "hdf5")]
    Target {
        name: "record_hdf5",
        run: record,
        corpus: &[
            "formats/stroke.h5",
            "formats/stroke_rates.h5",
            "formats/stroke_frame.h5",
            "formats/stroke_v73.mat",
            "formats/mixed.h5",
        ],
    },
    #[cfg(feature = "excel")]
    Target { name: "record_workbook", run: record, corpus: &["formats/stroke.xlsx", "formats/dates.xlsx"] },
    #[cfg(feature = "parquet")]
    Target { name: "record_parquet", run: record, corpus: &["formats/stroke.parquet"] },
    Target { name: "rig", run: rig, corpus: &["two_tanks/rig.toml", "telescopic/rig.toml"] },
    Target { name: "formula", run: formula, corpus: &["formats/formulas.txt"] },
];

/// A record in whatever format its bytes are, and the survey of it.
fn record(bytes: &[u8]) {
    if let Ok(record) = Asked::default().read_bytes("record", bytes.to_vec()) {
        assert!(record.time.windows(2).all(|pair| pair[0] < pair[1]));
        assert!(record.channels.iter().all(|channel| channel.values.len() == record.time.len()));
        let _ = survey(&record, |_| Some(Scatter { noise: 1.0, resolution: 0.0 }), |_| false);
    }
}

fn rig(bytes: &[u8]) {
    if let Ok(text) = std::str::from_utf8(bytes) {
        let _ = Rig::parse("rig.toml", text.to_owned());
    }
}

/// A formula, a quantity and a unit.
fn formula(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let names =
        [Name::new("p", Dimension::PRESSURE), Name::new("x", Dimension::LENGTH), Name::new("k", Dimension::NONE)];
    for line in text.lines() {
        if let Ok(formula) = Expression::parse(line, &names) {
            let _: f64 = formula.evaluate(&[1e5, 0.5, 2.0]);
        }
        if let Ok(quantity) = Quantity::parse(line) {
            let _ = quantity.in_unit();
        }
        let _ = Unit::parse(line);
    }
}

/// Runs one target.
#[allow(dead_code)] // Of the programs of cargo-fuzz; the test runs them from the list.
pub fn run(name: &str, bytes: &[u8]) {
    if let Some(target) = TARGETS.iter().find(|target| target.name == name) {
        (target.run)(bytes);
    }
}
