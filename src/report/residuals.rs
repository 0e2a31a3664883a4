//! The table of residuals of a diagnosis, as text and as a page have it.

use super::table::Head;
use crate::diagnosis::Diagnosis;
use crate::number::{rounded, text};
use crate::residual::Detection;

pub(super) const HEADS: [Head; 8] = [
    ("residual", false),
    ("equation", false),
    ("mean", true),
    ("sigma", true),
    ("allowed", true),
    ("unit", false),
    ("alarm", false),
    ("onset", true),
];

pub(super) fn rows(diagnosis: &Diagnosis) -> Vec<Vec<String>> {
    let number = |value: Option<f64>| value.map_or("-".to_owned(), |value| text(rounded(value, 3)));
    diagnosis
        .residuals
        .iter()
        .map(|residual| {
            vec![
                residual.id.clone(),
                residual.equation.to_owned(),
                number(residual.mean),
                number(residual.sigma),
                number(residual.allowed),
                residual.unit.clone(),
                if residual.fired { "yes" } else { "no" }.to_owned(),
                residual.onset_s.map_or("-".to_owned(), |onset| format!("{onset:.2} s")),
            ]
        })
        .collect()
}

/// What the columns of the table of residuals mean, a line each.
pub(super) fn words() -> Vec<String> {
    let Detection { hours_between_false_alarms: hours, coverage, .. } = Detection::default();
    vec![
        "mean: mean error of the balance; with an alarm, in the phase of the alarm".to_owned(),
        "sigma: standard error of the mean from sensor noise alone; it does not decide the alarm".to_owned(),
        format!(
            "allowed: what the uncertain values of the rig file can cause in a healthy circuit ({} standard deviations)",
            text(coverage)
        ),
        format!(
            "alarm: the excess over it, summed from window to window (CUSUM), passed the threshold of one false alarm in {} h",
            text(hours)
        ),
    ]
}
