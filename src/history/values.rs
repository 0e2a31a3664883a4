//! The values of a fault in the unit of today's rig file, and how sure each is.

use statrs::distribution::{ContinuousCDF, Normal};

use super::RunValue;
use crate::number::rounded;
use crate::rig::{Fault, Rig};
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
pub(super) fn sigma(value: &RunValue, rig: &Rig, fault: &Fault) -> Option<f64> {
    let unit = &rig.parameters[fault.parameter].unit;
    let (low, high) = (unit.from_si(fault.bounds.0), unit.from_si(fault.bounds.1));
    let near = 1e-6 * (high - low).abs();
    let known = value.ci95.map(|end| end.map(|end| (end - value.value).abs()));
    let side = |own: Option<f64>, other: Option<f64>, bound: f64| {
        let reach = (value.value - bound).abs();
        own.or_else(|| (reach <= other.unwrap_or(0.0).max(near)).then_some(reach))
    };
    let length = side(known[0], known[1], low)?.max(side(known[1], known[0], high)?);
    let factor = Normal::standard().inverse_cdf(0.975);
    // An interval without width would overrule all others.
    Some((length / factor).max(near))
}
