//! Whether one effect explains outright what the declared faults of a rig miss.
//!
//! Where physics is missing, the search for a value that nobody declared, for a beginning within the record and for parts that deviate
//! takes minutes and ends in nonsense. So the library is asked first, as cheaply as that can be told: effects scored where the faults
//! have ended and where there are none, the first few of them fitted. One that leaves nothing but noise is what [`suggest`](super::suggest)
//! goes into; values are tried in the same way, and one that does nearly as well is asked about first.

use std::sync::OnceLock;

use rayon::prelude::*;

use super::candidate::Candidate;
use super::fitted_model::{FittedModel, run_under};
use super::lack_of_fit::with_lack_of_fit;
use super::opened::opened;
use super::refit::{BasePoint, PreliminaryModel, quick, refitted};
use super::scoring::{candidates, worth};
use super::trial_steps::ScoreContext;
use crate::complaint::Complaint;
use crate::diagnosis::Physics;
use crate::diagnosis::estimate::{self, Estimate};
use crate::diagnosis::misstated::may_be_misstated;
use crate::diagnosis::search::ROUGH;
use crate::diagnosis::undeclared::fault;
use crate::model::Model;
use crate::record::Record;
use crate::rig::{FaultSet, Location, Rig};

/// What explains a record outright that declared faults miss.
enum Outright {
    /// No single effect.
    Nothing,
    /// An effect, and nearly as well values that nobody declared, each alone: their ids.
    Values(Vec<String>),
    /// An effect alone.
    Physics,
}

/// The question, with its answer once it was asked: a record has one.
#[derive(Default)]
pub(super) struct Asked(OnceLock<Outright>);

impl Asked {
    /// Values that nobody declared, each of which does nearly as well as an effect: their ids.
    pub fn as_good(&self) -> &[String] {
        match self.0.get() {
            Some(Outright::Values(values)) => values,
            _ => &[],
        }
    }
}

impl Physics for Asked {
    fn explains(&self, first: &Estimate<'_>) -> Result<bool, Complaint> {
        if self.0.get().is_none() {
            let found = outright(first)?;
            self.0.get_or_init(|| found);
        }
        Ok(self.has_explained())
    }

    fn has_explained(&self) -> bool {
        matches!(self.0.get(), Some(Outright::Physics))
    }
}

/// What explains a record outright that the declared faults of `first` miss: one effect of the library, where no value that nobody declared
/// does nearly as well. What cannot be fitted explains nothing.
///
/// # Errors
/// A [context](crate::Context) that was cancelled.
fn outright(first: &Estimate<'_>) -> Result<Outright, Complaint> {
    let found = fitted_outright(first);
    first.case.rig().context().check()?;
    Ok(found.unwrap_or(Outright::Nothing))
}

/// The same with the errors of the fits.
fn fitted_outright(first: &Estimate<'_>) -> Result<Outright, Complaint> {
    let (rig, record, full) = (first.case.rig(), first.case.record, &first.case.full);
    let settings = &rig.settings().learn;
    rig.context().stage("effects that explain it outright");
    let model = Model::new(with_lack_of_fit(&opened(rig), &FittedModel::of(first)?.fit));
    let start = (&first.isolation.best.theta[..], first.isolation.set());
    let few = rig.settings().diagnosis.first_linearisations;
    let with = estimate::held_at(&model, record, full.drive, start, few)?;
    let base = FittedModel::of(&with)?;
    let samples = base.fit.weights.all_samples() as f64;
    // Faults that take less than half of what is missed may be bent to it: what they hide shows where there are none.
    let without = if base.set.is_empty() { None } else { with.without_faults(few).ok() };
    let without = without.filter(|without| without.isolation.best.cost < 2.0 * with.isolation.best.cost);
    let estimates: Vec<Estimate<'_>> = std::iter::once(with).chain(without).collect();
    let base_points: Vec<BasePoint> = estimates.iter().map(|estimate| BasePoint::of(estimate, samples)).collect();
    let tried: Vec<Candidate> = estimates.iter().enumerate().flat_map(promising_effects).collect();
    let adequate = |fitted: PreliminaryModel| {
        let run = run_under(&fitted.rig, record, &fitted.values, None).ok()?;
        run.is_adequate.then(|| fitted.priced(samples))
    };
    let fitted = |effect: Candidate| {
        let first = refitted(&base, &base_points, &[], record, &[effect], None)?;
        let start = (first.set, settings.linearisations);
        adequate(quick(&first.rig, record, &first.values, start, Some(ROUGH)).unwrap_or(first))
    };
    let left = tried.into_par_iter().filter_map(fitted).reduce_with(f64::min);
    let Some(left) = left else { return Ok(Outright::Nothing) };
    let given = base_points[0].cost;
    let enough = given - settings.rival_share * (given - left);
    let mut values: Vec<(usize, &BasePoint)> = Vec::new();
    for (estimate, point) in estimates.iter().zip(&base_points) {
        let Some(promising) = promising_values(estimate) else { return Ok(Outright::Nothing) };
        values.extend(promising.into_iter().map(|value| (value, point)));
    }
    let as_good = |&(value, point): &(usize, &BasePoint)| {
        let left = adequate(with_value(&base.rig, record, point, value)?)?;
        (left <= enough).then(|| base.rig.parameters[value].id.clone())
    };
    let as_good: Vec<String> = values.par_iter().filter_map(as_good).collect();
    rig.context().check()?;
    Ok(if as_good.is_empty() { Outright::Physics } else { Outright::Values(as_good) })
}

/// The first few effects of the circuit where one of several estimates stands, by the fall of the cost that they promise there, if that is more
/// than chance.
fn promising_effects((place, estimate): (usize, &Estimate<'_>)) -> Vec<Candidate> {
    let all = candidates(estimate, place, 0.0);
    let least = worth(all.len(), 0.0);
    let is_of_circuit = |one: &Candidate| !matches!(one.placed.spot, Location::Sensor(_));
    let promising = all.into_iter().filter(|one| one.score > least && is_of_circuit(one));
    promising.take(estimate.case.rig().settings().learn.rivals_fitted).collect()
}

/// The first few values that are no declared faults, by the fall of the cost that they promise in the local model, as free as faults; `None`
/// where the model cannot be solved.
fn promising_values(estimate: &Estimate<'_>) -> Option<Vec<usize>> {
    let full = &estimate.case.full;
    let by: Vec<usize> = may_be_misstated(&full.model.rig).collect();
    let values = full.parameters(&estimate.isolation.local.theta);
    let here = ScoreContext::of(estimate, 0.0)?;
    let solved = full.model.sensitivities(&values, &by, full.drive, full.times).ok()?;
    let promised = |(&value, derivative): (&usize, &Vec<Vec<f64>>)| {
        let mut change = derivative.concat();
        full.weights.apply(&mut change);
        let score = here.scoring.of(&change);
        (score.fall_at(score.factor), value)
    };
    let mut promised: Vec<(f64, usize)> = by.iter().zip(&solved.derivatives).map(promised).collect();
    promised.retain(|(fall, _)| fall.is_finite());
    promised.sort_by(|a, b| b.0.total_cmp(&a.0));
    let few = full.model.rig.settings().learn.rivals_fitted;
    Some(promised.into_iter().map(|(_, value)| value).take(few).collect())
}

/// The model with a value as free as a fault, fitted; `None` where it cannot be solved.
fn with_value(rig: &Rig, record: &Record, point: &BasePoint, value: usize) -> Option<PreliminaryModel> {
    if rig.faults.len() == FaultSet::CAPACITY {
        return None;
    }
    let mut rig = rig.clone();
    let set = point.set.with(rig.faults.len());
    rig.faults.push(fault(&rig, value));
    quick(&rig, record, &point.values, (set, rig.settings().learn.linearisations), Some(ROUGH))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::InputSignals;
    use crate::simulation::{SimulationOptions, simulate};

    const FIXTURE: &str = "fixtures/telescopic/rig.toml";

    /// What explains outright a record of the circuit with something changed in its file.
    fn of(changed: impl Fn(&str) -> String) -> Outright {
        let text = std::fs::read_to_string(FIXTURE).unwrap();
        let model = |text: String| Model::new(Rig::parse(FIXTURE, text).unwrap());
        let options = SimulationOptions { seed: Some(1), ..SimulationOptions::default() };
        let record = simulate(&model(changed(&text)), None, &options).unwrap().record;
        let model = model(text);
        let drive = InputSignals::from_record(&model.rig, &record).unwrap();
        let first = estimate::from_start(&model, &record, &drive, None).unwrap();
        outright(&first).unwrap()
    }

    #[test]
    fn an_effect_explains_outright_what_no_value_does() {
        let air = "\n[effects]\n\"entrained-air\" = { air_fraction = \"2 %\" }\n";
        assert!(matches!(of(|text| text.to_owned() + air), Outright::Physics));
    }

    #[test]
    fn a_value_that_does_as_well_as_an_effect_is_told() {
        let found =
            of(|text| text.replacen("viscous_friction = \"800 N.s/m\"", "viscous_friction = \"4000 N.s/m\"", 1));
        let Outright::Values(values) = found else { panic!("no value does as well") };
        assert!(values.iter().any(|one| one == "cylinder.viscous_friction"), "{values:?}");
    }

    #[test]
    fn nothing_explains_outright_what_two_effects_hide() {
        let both = "\n[effects]\n\"entrained-air\" = { air_fraction = \"2 %\" }\n\"seal-friction@cylinder\" = { coulomb = \"1500 N\" }\n";
        assert!(matches!(of(|text| text.to_owned() + both), Outright::Nothing));
    }
}
