//! Values that nobody declared as faults and that do what a fault does.
//!
//! Two motors drive one shaft, and the rig file declares the friction of the first: the record has more of it, and does not say in which. A
//! search among declared faults finds the one that it knows. So for each value of another part that is also estimated it is
//! computed how well that would explain the record in place of the fault.

use nalgebra::{DMatrix, DVector};

use super::estimate::Estimate;
use super::undeclared::{fault, may_be_a_fault};
use crate::estimation::profile::QUANTILE;

/// How many are named, the likest first.
const NAMED: usize = 3;

/// For each fault that is present, by its index: parameters of the rig with which, free in its place, the record is explained as well (95 %),
/// the likest first; faults that have none are left out.
///
/// Let `C` be the covariance of all that is estimated beside the fault `f`, `P` the precision of what was known before, and `m` its mean. A
/// value `u` that nothing is known of any more has `k = CP_u` and `w = (P - PCP)_uu`. The fit then moves by `k g/w` with
/// `g = P_u (theta - m)` and costs `g²/w` less; the covariance grows by `k k'/w`. Without the deviation `d` that the fault then has it costs
/// `d²/C_ff` more, and the value moves by `-d C_uf/C_ff`, with those as they then are.
/// Worked: two columns that are the same, of information 4, and a value known to 0.1: `C_ff = 1/4 + 1/100`, `P = 100`, `(CP)_fu = -1`,
/// `w = 0`: any deviation of the fault may as well be one of the value.
pub(super) fn alike(estimate: &Estimate<'_>, present: &[usize]) -> Vec<(usize, Vec<usize>)> {
    let (case, isolation) = (&estimate.case, &estimate.isolation);
    let (rig, full, set) = (case.rig(), &case.full, isolation.set());
    let Ok(information) = isolation.local.information(&case.problem(set)) else { return Vec::new() };
    let scale = &isolation.local.scale;
    let covariance = information.covariance().map_with_location(|i, j, value| value * scale[i] * scale[j]);
    let known = case.prior(set);
    let (members, precision) = (&known.members, known.precision());
    // (CP) of the members, and P - PCP.
    let of_members = DMatrix::from_fn(covariance.nrows(), members.len(), |i, k| covariance[(i, members[k])]);
    let gain = &of_members * &precision;
    let inside = DMatrix::from_fn(members.len(), members.len(), |i, k| covariance[(members[i], members[k])]);
    let left = &precision - &precision * inside * &precision;
    // What a part has otherwise is its fault, whichever of its values says so.
    let is_of_one_part = |fault: usize, value: usize| {
        let fault = rig.faults[fault].parameter;
        rig.parts().any(|(_, part)| part.owns(fault) && part.owns(value))
            || rig.sensors.iter().any(|sensor| sensor.owns(fault) && sensor.owns(value))
    };
    let theta = &isolation.best.theta;
    let away = DVector::from_fn(members.len(), |k, _| theta[members[k]] - known.mean[k]);
    let pulls = &precision * away;
    let one = |&f: &usize| {
        let of_value = |(place, &u): (usize, &usize)| {
            let parameter = full.estimated[u].parameter;
            if u < case.faults() || !may_be_a_fault(rig, parameter) || is_of_one_part(f, parameter) {
                return None;
            }
            let own = left[(place, place)].max(0.0);
            let (of_fault, across) = (covariance[(f, f)], covariance[(u, f)]);
            let (on_fault, on_value, pull) = (gain[(f, place)], gain[(u, place)], pulls[place]);
            // All over `w`, which is 0 of twins.
            let over = of_fault * own + on_fault * on_fault;
            let deviation = theta[f] - case.mean[f];
            let rise = (deviation * (deviation * own + 2.0 * on_fault * pull) - pull * pull * of_fault) / over;
            let moved = pull * (on_value * of_fault - on_fault * across);
            let there = theta[u] + (moved - deviation * (own * across + on_value * on_fault)) / over;
            let (low, high) = fault(rig, parameter).bounds;
            let does = rise < QUANTILE * QUANTILE * isolation.inflation[f] && (low..=high).contains(&there);
            does.then_some((rise, parameter))
        };
        let mut values: Vec<(f64, usize)> = members.iter().enumerate().filter_map(of_value).collect();
        values.sort_by(|a, b| a.0.total_cmp(&b.0));
        let values: Vec<usize> = values.into_iter().take(NAMED).map(|(_, parameter)| parameter).collect();
        (!values.is_empty()).then_some((f, values))
    };
    present.iter().filter_map(one).collect()
}
