//! The residuals on records whose clock jitters or that have lost rows.

use borescope::Record;
use borescope::Rig;
use borescope::internals::model::{InputSignals, Model};
use borescope::internals::residual::{Detection, Gate, Generator, Variant, detect, generators};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

use crate::support::cycle::Run;

const WINDOW: f64 = 0.1;

/// The record without the rows that `left_out` names, its times moved by up to `jitter` intervals.
fn irregular(rig: &Rig, set: &[(&str, f64)], jitter: f64, left_out: impl Fn(usize) -> bool) -> (Record, InputSignals) {
    let cycle = rig.cycle.as_ref().unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(17);
    let rows = (cycle.duration() / cycle.interval).round() as usize;
    let mut shift = || {
        let normal: f64 = StandardNormal.sample(&mut rng);
        jitter * normal.clamp(-1.0, 1.0)
    };
    let all = 1..=rows;
    let time: Vec<f64> =
        all.map(|row| (row as f64 + if row < rows { shift() } else { 0.0 }) * cycle.interval).collect();
    let time: Vec<f64> =
        time.into_iter().enumerate().filter(|(row, _)| !left_out(*row)).map(|(_, time)| time).collect();
    let model = Model::new(rig.clone());
    let run = Run::of(&model).with(set).at(time);
    let drive = run.drive();
    (run.record("irregular"), drive)
}

#[test]
fn windows_follow_the_time_stamps() {
    let rig = Rig::read("fixtures/telescopic/rig.toml").unwrap_or_else(|complaint| panic!("{complaint}"));
    let leak = [("cylinder.clearance", 0.1e-3)];
    let found = |generator: &Generator| generator.id == "cylinder.flow_A" && generator.variant == Variant::Corrected;
    let generator = generators(&rig).into_iter().find(found).unwrap();
    let counted = |record: &Record, drive: &InputSignals| {
        let series = generator.blocks(&rig, record, drive, WINDOW).unwrap();
        let open: Vec<usize> = (0..series.time.len()).filter(|&at| series.gate[at] == Gate::Open).collect();
        for &at in &open {
            let (from, to) = (series.start[at], series.time[at]);
            assert!(to - from < 1.5 * WINDOW, "a window from {from} s to {to} s");
        }
        open.len()
    };
    let (regular, drive) = irregular(&rig, &leak, 0.0, |_| false);
    let usual = counted(&regular, &drive);
    type LeftOut = fn(usize) -> bool;
    let ways: [(&str, f64, LeftOut); 4] = [
        ("clock that jitters by 30 %", 0.3, |_| false),
        ("every fourth row lost", 0.0, |row| row % 4 == 0),
        ("four rows of twelve lost", 0.0, |row| row % 12 < 4),
        ("half a second lost", 0.0, |row| (400..525).contains(&row)),
    ];
    for (name, jitter, left_out) in ways {
        let (record, drive) = irregular(&rig, &leak, jitter, left_out);
        let count = counted(&record, &drive);
        let reports = detect(&rig, &record, &drive, &Detection::default()).unwrap();
        let fired: Vec<&str> = reports.iter().filter(|report| report.fired).map(|report| report.id.as_str()).collect();
        println!("{name}: {count} windows of {usual}, fired {fired:?}");
        assert!(count + 12 >= usual, "{name}: {count} windows of {usual}");
        assert_eq!(fired, ["cylinder.leakage", "cylinder.flow_A", "cylinder.flow_B"], "{name}");
    }
}
