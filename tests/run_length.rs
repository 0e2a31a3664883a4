//! The time between false alarms of the whole chain: simulated healthy readings with the sensors' noise and rounding, through
//! windows, gates, propagated noise and CUSUMs, against the time that was asked for.
//!
//! The long form, 100 alarms at each of 0.1 to 1 hour, writes the table of `docs/theory/false-alarms.md`:
//! `UPDATE_DOCS=1 cargo test --release --test run_length -- --ignored`.

use std::fs;

use borescope::model::{Drive, Model, Outputs, input_columns, recording};
use borescope::record::Record;
use borescope::residual::{Detection, detect};
use borescope::rig::Rig;

const PAGE: &str = "docs/theory/false-alarms.md";
const DESIGN: f64 = 1000.0;

/// A healthy rig in steady repetition of its cycle.
struct Bench {
    rig: Rig,
    drive: Drive,
    times: Vec<f64>,
    inputs: Vec<Vec<f64>>,
    outputs: Outputs,
}

impl Bench {
    /// At least so many hours of whole cycles.
    fn of(hours: f64) -> Self {
        let mut rig = Rig::read("fixtures/telescopic/rig.toml").unwrap_or_else(|complaint| panic!("{complaint}"));
        let cycle = rig.cycle.clone().unwrap();
        let count = (hours * 3600.0 / cycle.duration()).ceil() as usize;
        let per_cycle = (cycle.duration() / cycle.interval).round() as usize;
        // The second of two cycles begins as the first one ends, and so would all that follow.
        let repeated = |count: usize| vec![cycle.phases.clone(); count].concat();
        let drive = Drive::from_cycle(&rig, &borescope::rig::Cycle { phases: repeated(2), ..cycle.clone() });
        let times: Vec<f64> = (1..=2 * per_cycle).map(|row| row as f64 * cycle.interval).collect();
        let model = Model::new(rig.clone());
        let solved = model.simulate(&rig.nominal(), &drive, &times).unwrap();
        let inputs = input_columns(&rig, &drive, &times);
        let repeat = |column: &Vec<f64>| column[per_cycle..].repeat(count);
        let values = solved.values.iter().map(repeat).collect();
        let inputs = inputs.iter().map(repeat).collect();
        let times = (1..=count * per_cycle).map(|row| row as f64 * cycle.interval).collect();
        let all = borescope::rig::Cycle { phases: repeated(count), ..cycle.clone() };
        let drive = Drive::from_cycle(&rig, &all);
        rig.cycle = Some(all);
        Self { rig, drive, times, inputs, outputs: Outputs { values, effort: solved.effort } }
    }

    fn record(&self, seed: u64) -> Record {
        recording(&self.rig, "healthy", self.times.clone(), self.inputs.clone(), &self.outputs, Some(seed))
    }

    /// Time of the first alarm of any residual, h; `None` where the record ends without one.
    fn first_alarm(&self, record: &Record, detection: &Detection) -> Option<f64> {
        let reports = detect(&self.rig, record, &self.drive, detection).unwrap();
        reports.iter().filter_map(|report| report.alarm_at_s).reduce(f64::min).map(|alarm| alarm / 3600.0)
    }
}

/// Records of white noise that ran until their first alarm or their end.
#[derive(Debug, Clone, Copy)]
struct Found {
    asked: f64,
    threshold: f64,
    /// Hours of record up to the alarms or ends, and alarms: the rate is their ratio for exponential run lengths.
    exposure: f64,
    alarms: usize,
}

impl Found {
    fn hours(&self) -> f64 {
        self.exposure / self.alarms as f64
    }

    /// 95 % limits of the mean time between alarms, from those of a Poisson count (Ulm 1990; Wilson-Hilferty quantiles).
    fn limits(&self) -> (f64, f64) {
        let n = self.alarms as f64;
        let quantile = |shape: f64, z: f64| shape * (1.0 - 1.0 / (9.0 * shape) + z / (3.0 * shape.sqrt())).powi(3);
        (self.exposure / quantile(n + 1.0, 1.96), self.exposure / quantile(n, -1.96))
    }
}

/// `seeds` records for each of the times asked for, with no allowance for tolerance: what is tested is the noise.
fn run(asked: &[f64], seeds: u64, hours: f64) -> Vec<Found> {
    let bench = Bench::of(hours);
    let residuals = detect(&bench.rig, &bench.record(0), &bench.drive, &Detection::default()).unwrap().len();
    let detection = |asked: f64| Detection { hours_between_false_alarms: asked, coverage: 0.0, ..Detection::default() };
    let half = |parity: u64| {
        let mut counts = vec![(0.0, 0); asked.len()];
        for seed in (0..seeds).filter(|seed| seed % 2 == parity) {
            let record = bench.record(seed);
            for (count, &asked) in counts.iter_mut().zip(asked) {
                let alarm = bench.first_alarm(&record, &detection(asked));
                count.0 += alarm.unwrap_or(*bench.times.last().unwrap() / 3600.0);
                count.1 += usize::from(alarm.is_some());
            }
        }
        counts
    };
    let halves = std::thread::scope(|scope| {
        let running: Vec<_> = (0..2).map(|parity| scope.spawn(move || half(parity))).collect();
        running.into_iter().map(|thread| thread.join().unwrap()).collect::<Vec<_>>()
    });
    let found = |(index, &asked): (usize, &f64)| Found {
        asked,
        threshold: detection(asked).threshold(residuals, detection(asked).window),
        exposure: halves.iter().map(|counts| counts[index].0).sum(),
        alarms: halves.iter().map(|counts| counts[index].1).sum(),
    };
    asked.iter().enumerate().map(found).collect()
}

#[test]
#[ignore = "probe"]
fn probe() {
    let start = std::time::Instant::now();
    for found in run(&[0.1], 2, 0.1) {
        println!("{found:?} {:.3} {:?}", found.hours(), found.limits());
    }
    println!("{:?}", start.elapsed());
}
