//! The values of a fault in the unit of today's rig file, and how sure each is.

use statrs::distribution::{ContinuousCDF, Normal};

use super::RunValue;
use crate::number::rounded;
use crate::store::{StoredFault, StoredRun};
use crate::units::Unit;

/// Digits of what is told.
const DIGITS: usize = 7;

pub(super) fn short(value: f64) -> f64 {
    rounded(value, DIGITS)
}

/// The stored value of a run in `unit`, at its place on the axis; `None` where it was of another dimension or not finite.
pub(super) fn in_unit(stored: &StoredFault, unit: &Unit, (run, x): (&StoredRun, f64)) -> Option<RunValue> {
    let own = Unit::parse_as(&stored.unit, unit.dimension).ok()?;
    let to = |value: f64| if own.symbol == unit.symbol { value } else { unit.from_si(own.to_si(value)) };
    Some(RunValue {
        run: run.id,
        x,
        measured_at: run.measured_at.to_string(),
        value: short(to(stored.value?)),
        ci95: [stored.low, stored.high].map(|end| end.map(|end| short(to(end)))),
        present: stored.present,
        probability: stored.probability,
    })
}

/// The standard error of a value: the longer side of its interval. An open side counts only where that end of the search is no
/// further off than the other end of the interval, as in a part without the fault; otherwise the record does not bound the value.
pub(super) fn sigma(value: &RunValue, bounds: Option<[f64; 2]>) -> Option<f64> {
    let near = bounds.map_or(0.0, |[low, high]| 1e-6 * (high - low).abs());
    let known = value.ci95.map(|end| end.map(|end| (end - value.value).abs()));
    let side = |own: usize, other: usize| {
        known[own].or_else(|| {
            let reach = (value.value - bounds?[own]).abs();
            (reach <= known[other].unwrap_or(0.0).max(near)).then_some(reach)
        })
    };
    let length = side(0, 1)?.max(side(1, 0)?);
    let factor = Normal::standard().inverse_cdf(0.975);
    // An interval without width would overrule all others.
    let sigma = (length / factor).max(near);
    (sigma > 0.0).then_some(sigma)
}
