//! What is missing, as a picture: the flow or the force that would explain the misfit, over the state that it goes with.
//!
//! A [curve without a formula](super::free_curve) is put where it may act and fitted to first order. It leads to the term (Kristensen,
//! Madsen and Jorgensen, Computers and Chemical Engineering 28 (2004) 1431); effects are judged by their own fits, never by it.

use rayon::prelude::*;

use super::candidate::empirical;
use super::fitted_model::FittedModel;
use super::free_curve::{FreeCurve, Slopes, basis};
use super::law_on_axis::{Found, LawOnAxis};
use super::states::{Axis, piece, stays};
use crate::complaint::Complaint;
use crate::estimation::profile::QUANTILE;
use crate::model::InputSignals;
use crate::record::Record;
use crate::rig::{EffectInstance, Rig};

/// Points of a picture over the whole axis.
const POINTS: usize = 120;

/// A quantity with its unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Named {
    pub name: String,
    pub unit: String,
}

/// What is missing at one place, as far as a record shows it.
#[derive(Debug, Clone, PartialEq)]
pub struct Missing {
    /// Where it acts: a node or a component.
    pub at: String,
    pub what: Named,
    pub over: Named,
    /// Share that it takes away of what is missed beyond noise and tolerance, to first order.
    pub explains: f64,
    /// State, value and half of its 95 % band, over what the record visited; NaN between states where it never stays.
    pub curve: Vec<(f64, f64, f64)>,
    /// State and value of the law that was found: where the curve stands for it as it is, elsewhere what the record would make of it
    /// there, with the gaps of the curve; empty without one.
    pub law: Vec<(f64, f64)>,
    /// Share of the law that the state determines where the curve acts at the same nodes; `None` where it does not stand for the law.
    pub stands_for_law: Option<f64>,
}

/// What may be missing at every place of a rig, what explains most first: beside the faults and all else as `base` has them,
/// so that what these have taken over is not in it. `found` is what was found to be missing in it.
///
/// # Errors
/// Columns that are missing, or a model that cannot be solved.
pub fn missing(base: &FittedModel, record: &Record, found: Option<Found<'_>>) -> Result<Vec<Missing>, Complaint> {
    base.rig.context().run(|| missing_here(base, record, found))
}

fn missing_here(base: &FittedModel, record: &Record, found: Option<Found<'_>>) -> Result<Vec<Missing>, Complaint> {
    let own = Slopes::of_fitted(base, record)?;
    let lacking = found.map(|found| {
        let pairs = found.model.fit.outputs.iter().flatten().zip(base.fit.outputs.iter().flatten());
        let mut change: Vec<f64> = pairs.map(|(with, without)| without - with).collect();
        base.fit.weights.apply(&mut change);
        (found, change)
    });
    let curves: Vec<EffectInstance> = empirical(&base.rig).into_iter().map(|curve| curve.placed).collect();
    let mut all: Vec<Missing> =
        curves.par_iter().filter_map(|placed| one(base, record, &own, placed, lacking.as_ref())).collect();
    all.sort_by(|a, b| b.explains.total_cmp(&a.explains));
    Ok(all)
}

/// The curve at one place; `None` where the record shows nothing of it.
fn one(
    base: &FittedModel,
    record: &Record,
    own: &Slopes,
    placed: &EffectInstance,
    lacking: Option<&(Found<'_>, Vec<f64>)>,
) -> Option<Missing> {
    let drive = InputSignals::from_record(&base.rig, record).ok()?;
    let run = (&drive, record.time.as_slice());
    let free = FreeCurve::of(base, record, &drive, placed)?;
    let FreeCurve { told, quantity, rig, indices, values, unit, .. } = &free;
    let visited = free.visited()?;
    let fitted = free.fitted(base, own)?;
    let (step, spread) = fitted.curve(&fitted.pull);
    let seen = lacking.map(|(found, change)| (fitted.curve(&fitted.slope(change)).0, found.lacking));
    let axis = Axis::of(rig, *quantity, told.both_sides)?;
    let shares_of_rows = axis.shares(rig, values, run, placed)?;
    let stays = stays(&shares_of_rows);
    let law = lacking.and_then(|(found, _)| LawOnAxis::of(found, run, rig, indices, &axis));
    let (from, to) = match &law {
        None => visited,
        Some(_) => {
            let within = |from: f64, pick: fn(f64, f64) -> f64| {
                shares_of_rows.iter().filter(|share| share.is_finite()).copied().fold(from, pick).clamp(0.0, 1.0)
            };
            (within(f64::INFINITY, f64::min), within(f64::NEG_INFINITY, f64::max))
        }
    };
    let shown = |si: f64| unit.difference_from_si(si);
    let there = |share: f64, si: f64| {
        let asked = stays[piece(share)] && (visited.0..=visited.1).contains(&share);
        if asked { si } else { f64::NAN }
    };
    let mut one = Missing {
        at: placed_name(rig, placed),
        what: Named { name: told.what.to_owned(), unit: unit.symbol.clone() },
        over: Named { name: told.over.to_owned(), unit: axis.unit.symbol.clone() },
        explains: fitted.explains,
        curve: Vec::new(),
        law: Vec::new(),
        stands_for_law: law.as_ref().map(|law| law.determined),
    };
    for k in 0..=POINTS {
        let share = from + (to - from) * k as f64 / POINTS as f64;
        let (at, basis) = (axis.at(share), basis(share));
        let half = QUANTILE * (basis.transpose() * &spread * &basis)[0].sqrt();
        // The record asks for the law that was found, and for what it wants beside what is lacking of it.
        let asked = match &seen {
            None => basis.dot(&step),
            Some((seen, lacking)) => {
                let seen = basis.dot(seen);
                let is = law.as_ref().map_or(there(share, seen / lacking), |law| law.at(axis.unit.to_si(at)));
                one.law.push((at, shown(is)));
                is + basis.dot(&step) - seen
            }
        };
        one.curve.push((at, there(share, shown(asked)), there(share, shown(half))));
    }
    one.curve.iter().any(|point| !point.1.is_nan()).then_some(one)
}

/// The place behind the `@` of an effect.
fn placed_name(rig: &Rig, placed: &EffectInstance) -> String {
    let id = rig.effect_id(placed);
    id.split_once('@').map_or(id.clone(), |(_, at)| at.to_owned())
}
