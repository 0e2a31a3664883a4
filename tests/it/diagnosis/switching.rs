//! Spools with mass and dead time, which no data sheet states, make neither faults nor a misfit; nor does a slow logger.

use crate::support::plant;

use borescope::Model;
use borescope::Record;
use borescope::Rig;
use borescope::internals::campaign::random::Stream;
use borescope::internals::diagnosis::{Diagnosis, DiagnosisOptions, Verdict, diagnose};
use plant::Plant;
use plant::record::{cycle, record};

const RIG: &str = "fixtures/telescopic/rig.toml";

fn diagnosed(record: &Record) -> Diagnosis {
    let model = Model::new(Rig::read(RIG).unwrap());
    diagnose(&model, record, &DiagnosisOptions::default()).unwrap().diagnosis
}

fn of_plant(plant: &Plant, seed: u64) -> Diagnosis {
    let mut random = Stream::numbered(seed, 0);
    let phases = cycle(&mut random, 1.0);
    diagnosed(&record("plant", plant, &phases, &mut random))
}

fn present(diagnosis: &Diagnosis) -> Vec<&str> {
    diagnosis.present().map(|fault| fault.id.as_str()).collect()
}

/// Spools of usual damping, the first as quick as the lag of the model, the others slower and later.
fn spools() -> [Plant; 3] {
    let spool =
        |spool_damping, lag, dead_rows| Plant { spool_damping, spool_lags: [lag, 0.0], dead_rows, ..Plant::default() };
    [spool(0.85, 8e-3, 0), spool(0.7, 9e-3, 1), spool(1.0, 10e-3, 2)]
}

#[test]
fn a_healthy_rig_is_healthy_whatever_its_spool_does() {
    for (seed, spool) in (11..).zip(spools()) {
        let diagnosis = of_plant(&spool, seed);
        assert_eq!((diagnosis.verdict, present(&diagnosis)), (Verdict::Healthy, vec![]), "seed {seed}");
    }
}

#[test]
fn a_leak_is_found_alone_whatever_the_spool_does() {
    for (seed, spool) in (21..).zip(spools()) {
        let diagnosis = of_plant(&Plant { clearance: 0.15e-3, ..spool }, seed);
        assert_eq!(present(&diagnosis), ["cylinder.clearance"], "seed {seed}");
        let clearance = &diagnosis.faults[0];
        let [Some(low), Some(high)] = clearance.ci95 else { panic!("open: {clearance:?}") };
        assert!(low <= 0.15 && 0.15 <= high && high - low < 0.01, "seed {seed}: {low} to {high}");
    }
}

/// A record as a logger of so many rows less would have written it.
fn thinned(record: &Record, every: usize) -> Record {
    let rows = |values: &[f64]| values.iter().skip(every - 1).step_by(every).copied().collect::<Vec<f64>>();
    let mut thinned = record.clone();
    thinned.time = rows(&record.time);
    for (channel, whole) in thinned.channels.iter_mut().zip(&record.channels) {
        channel.values = rows(&whole.values);
    }
    thinned
}

#[test]
fn a_slow_logger_moves_no_sensor() {
    let record = Record::read("fixtures/telescopic/healthy_1.csv").unwrap();
    // 25, 12.5 and 5 Hz: the edges of the command lie anywhere between two rows.
    for every in [10, 20, 50] {
        let diagnosis = diagnosed(&thinned(&record, every));
        assert_eq!((diagnosis.verdict, present(&diagnosis)), (Verdict::Healthy, vec![]), "every {every}th row");
    }
}
