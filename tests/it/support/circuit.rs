//! Small circuits and what they read, against what they should.

use borescope::Complaint;
use borescope::Rig;
use borescope::internals::model::{InputSignals, Model, Outputs, Tolerance, cycle_times};

/// The model of a rig, at this relative and absolute tolerance.
pub fn model(rig: Result<Rig, Complaint>, tolerance: f64) -> Model {
    let mut model = Model::new(rig.unwrap_or_else(|complaint| panic!("{complaint}")));
    model.tolerance = Tolerance { relative: tolerance, absolute: tolerance };
    model
}

/// Times and readings over the cycle of the rig.
pub fn run(model: &Model) -> (Vec<f64>, Outputs) {
    let cycle = model.rig.cycle.as_ref().unwrap();
    let times = cycle_times(&model.rig, cycle);
    let outputs = model.solve(&model.rig.nominal(), &InputSignals::from_cycle(&model.rig, cycle), &times).unwrap();
    (times, outputs)
}

/// Digits in which a series agrees with its closed form, counted from the form's greatest magnitude.
pub fn digits(what: &str, series: &[f64], closed: impl IntoIterator<Item = f64>) -> f64 {
    let closed: Vec<f64> = closed.into_iter().collect();
    assert_eq!(series.len(), closed.len());
    let greatest = closed.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    let worst = series.iter().zip(&closed).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let digits = -(worst / greatest).max(1e-16).log10();
    println!("{what}: {digits:.1} digits");
    digits
}
