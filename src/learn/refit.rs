//! A model with effects in it, fitted with the faults as they were.

use super::candidate::Candidate;
use super::departure::{nothing, size};
use super::evaluated::EvaluatedModel;
use super::fitted_model::{FittedModel, effect_parameters};
use crate::complaint::Complaint;
use crate::diagnosis::estimate::{self, Estimate};
use crate::diagnosis::noise::Weights;
use crate::diagnosis::preliminary::{self, PreliminaryFit};
use crate::diagnosis::search::ROUGH;
use crate::estimation::criteria::bic;
use crate::model::{InputSignals, Model, Tolerance};
use crate::physics::effect::{FreeParameter, InitialGuess};
use crate::record::Record;
use crate::rig::FaultSet;
use crate::rig::{ParameterSetting, Rig};
use crate::units::Unit;

/// A model with some effects, fitted with the faults as they were.
#[derive(Clone)]
pub(super) struct PreliminaryModel {
    pub rig: Rig,
    /// All parameters of the rig, SI.
    pub values: Vec<f64>,
    pub set: FaultSet,
    /// `2 F` of record and prior.
    pub cost: f64,
    /// By how much the last form of its fit lowered it.
    pub gained: f64,
}

impl PreliminaryModel {
    /// The cost with its faults and the parameters of its effects priced.
    pub fn priced(&self, samples: f64) -> f64 {
        charged(&self.rig, self.cost, self.set, samples)
    }
}

/// A cost (`2 F` of record and prior) with faults and parameters of effects priced alike, as the information criterion does.
pub(super) fn charged(rig: &Rig, cost: f64, set: FaultSet, samples: f64) -> f64 {
    bic(cost, set.len(), samples) + effect_parameters(rig) as f64 * samples.ln()
}

/// Where a model without the effects stands.
pub(super) struct BasePoint {
    /// All of its parameters, SI.
    pub values: Vec<f64>,
    /// Faults that are present.
    pub set: FaultSet,
    /// What it costs there, faults and effects priced.
    pub cost: f64,
}

impl BasePoint {
    /// An estimate on so many samples.
    pub fn of(estimate: &Estimate<'_>, samples: f64) -> Self {
        let (isolation, full) = (&estimate.isolation, &estimate.case.full);
        let set = isolation.set();
        Self {
            values: full.parameters(&isolation.best.theta),
            set,
            cost: charged(estimate.case.rig(), isolation.best.cost, set, samples),
        }
    }

    /// The data sheet, which was not fitted.
    pub fn healthy(rig: &Rig) -> Self {
        Self { values: rig.healthy(), set: FaultSet::EMPTY, cost: f64::INFINITY }
    }
}

/// Everything fitted jointly with some effects, from the base points where they were scored; from all where they were not. Of several
/// effects also from the fits with some of them, `smaller`: with one effect more a model is never worse. Under given weights, or those of
/// the model's events at each start.
pub(super) fn refitted(
    base: &FittedModel,
    base_points: &[BasePoint],
    smaller: &[&EvaluatedModel],
    record: &Record,
    effects: &[Candidate],
    weights: Option<&Weights>,
) -> Option<PreliminaryModel> {
    let (rig, starts) = with_effects(&base.rig, effects)?;
    let samples = base.fit.weights.all_samples() as f64;
    let fitted = |values: &[f64], set: FaultSet, starts: &[&Start], at_size: bool| {
        let mut values = values.to_vec();
        values.extend(rig.parameters[values.len()..].iter().map(|parameter| parameter.value));
        for start in starts {
            values[start.parameter] = if at_size { start.tried } else { start.neutral };
        }
        let model = Model::new(rig.clone()).with_tolerance(ROUGH);
        quick_under(model, record, &values, (set, rig.settings().diagnosis.first_linearisations), weights)
    };
    // At its neutral value an effect is nothing: a fit that ends above the one without it has gone astray from its start.
    let not_above = |without: f64, begun: &dyn Fn(bool) -> Option<PreliminaryModel>| {
        let first = begun(true);
        if first.as_ref().is_some_and(|first| first.cost <= without) {
            return first;
        }
        [first, begun(false)].into_iter().flatten().min_by(|a, b| a.cost.total_cmp(&b.cost))
    };
    let all: Vec<&Start> = starts.iter().collect();
    let asked = |base_point: usize| effects.iter().any(|effect| effect.base_point.is_none_or(|own| own == base_point));
    let of_base_points = base_points.iter().enumerate().filter(|(base_point, _)| asked(*base_point));
    let of_base_points = of_base_points.filter_map(|(_, base_point)| {
        not_above(base_point.cost, &|at_size| fitted(&base_point.values, base_point.set, &all, at_size))
    });
    let of_smaller = smaller.iter().filter_map(|one| {
        let FittedModel { rig: own, values: found, set, .. } = &one.trial;
        let fitted_there = |index: usize| {
            let id = &rig.parameters[index].id;
            own.parameters.iter().position(|parameter| parameter.id == *id).filter(|&at| own.is_of_effect(at))
        };
        let mut values: Vec<f64> = found[..base.values.len()].to_vec();
        values.extend(rig.parameters[values.len()..].iter().map(|parameter| parameter.value));
        let (there, new): (Vec<&Start>, Vec<&Start>) =
            starts.iter().partition(|start| fitted_there(start.parameter).is_some());
        for start in there {
            values[start.parameter] = fitted_there(start.parameter).map_or(start.tried, |at| found[at]);
        }
        not_above(one.preliminary, &|at_size| fitted(&values, *set, &new, at_size))
    });
    of_base_points.chain(of_smaller).min_by(|a, b| a.priced(samples).total_cmp(&b.priced(samples)))
}

/// Where the fit of a parameter of an effect starts.
struct Start {
    /// As an index into the rig's parameters.
    parameter: usize,
    /// SI.
    tried: f64,
    /// At which the effect is nothing, SI; the tried one where there is none.
    neutral: f64,
}

/// Standard deviation of a value of which no more is known than its range, SI: that of a uniform distribution. For parameters that
/// begin at nothing, such as one that may have either sign.
pub(super) fn range_deviation(unit: &Unit, free: &FreeParameter) -> f64 {
    let (low, high) = free.plausible;
    unit.difference_to_si(high - low) / 12.0_f64.sqrt()
}

/// A rig with some effects more, and where their parameters start; `None` where it cannot have them.
fn with_effects(rig: &Rig, effects: &[Candidate]) -> Option<(Rig, Vec<Start>)> {
    let mut rig = rig.clone();
    let mut starts = Vec::new();
    for effect in effects {
        // What the circuit has anyway, before the effect is there.
        let of = |free: &FreeParameter| free.neutral.and_then(|_| nothing(&rig, &effect.placed, free));
        let neutrals: Vec<Option<f64>> = effect.placed.effect.parameters.iter().map(of).collect();
        let given: Vec<ParameterSetting> = effect
            .placed
            .effect
            .parameters
            .iter()
            .zip(&effect.tried)
            .zip(&neutrals)
            .map(|((free, tried), &neutral)| {
                let unit = rig.effect_unit(&effect.placed, free.name);
                // What was tried may be far smaller than what such an effect often is.
                let typical = size(&rig, &effect.placed, free);
                let size = (tried.value - neutral.unwrap_or(0.0)).abs().max(typical);
                let absolute = matches!(free.first, InitialGuess::Range(_));
                let sigma = match neutral {
                    _ if size == 0.0 => range_deviation(&unit, free),
                    Some(_) => rig.settings().learn.effect_sigma * size,
                    None if absolute => 0.3 * rig.settings().learn.shape_sigma * size,
                    None => rig.settings().learn.shape_sigma * size,
                };
                ParameterSetting { name: free.name.to_owned(), value: neutral.unwrap_or(tried.value), sigma }
            })
            .collect();
        let indices = rig.give_effect(&effect.placed, &given).ok()?;
        for (place, ((&neutral, tried), &index)) in neutrals.iter().zip(&effect.tried).zip(&indices).enumerate() {
            let start = match neutral {
                // A curve starts flat.
                Some(neutral) if effect.placed.effect.empirical => neutral,
                // Its size; others are where they were tried.
                Some(neutral) if place == 0 => neutral + effect.factor * (tried.value - neutral),
                _ => tried.value,
            };
            let (low, high) = rig.parameters[index].bounds;
            let [tried, neutral] = [start, neutral.unwrap_or(start)].map(|value| value.clamp(low, high));
            starts.push(Start { parameter: index, tried, neutral });
        }
    }
    Some((rig, starts))
}

/// All parameters of a rig (SI) with the faults of `set` and what is uncertain fitted from there, and the fit.
///
/// # Errors
/// Columns that are missing, or a model that cannot be solved there.
pub(super) fn fitted(
    model: &Model,
    record: &Record,
    drive: &InputSignals,
    values: &[f64],
    (set, forms): (FaultSet, usize),
    weights: Option<&Weights>,
) -> Result<(Vec<f64>, PreliminaryFit), Complaint> {
    let start = estimate::picked(&model.rig, values);
    let fit = preliminary::quick(model, record, drive, (&start, set), forms, weights)?;
    let mut values = values.to_vec();
    for (parameter, value) in estimate::estimated_parameters(&model.rig).into_iter().zip(&fit.theta) {
        values[parameter] = *value;
    }
    Ok((values, fit))
}

/// Fits a rig with the faults of `set`, from values of all of its parameters (SI); `None` where it cannot be solved.
/// Simulated as accurately as asked for.
pub(super) fn quick(
    rig: &Rig,
    record: &Record,
    values: &[f64],
    fitted: (FaultSet, usize),
    tolerance: Option<Tolerance>,
) -> Option<PreliminaryModel> {
    let model = Model::new(rig.clone()).with_tolerance(tolerance.unwrap_or_default());
    quick_under(model, record, values, fitted, None)
}

/// The same with a model as it is, under given weights or those of its events there.
pub(super) fn quick_under(
    model: Model,
    record: &Record,
    values: &[f64],
    (set, forms): (FaultSet, usize),
    weights: Option<&Weights>,
) -> Option<PreliminaryModel> {
    let drive = InputSignals::from_record(&model.rig, record).ok()?;
    let (values, PreliminaryFit { cost, gained, .. }) =
        fitted(&model, record, &drive, values, (set, forms), weights).ok()?;
    Some(PreliminaryModel { rig: model.rig, values, set, cost, gained })
}
