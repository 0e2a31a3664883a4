//! Sizes and levels at which an effect is tried, and what the score test says of each.

use super::candidate::Candidate;
use super::departure::{nothing, typical};
use super::highest::highest;
use crate::diagnosis::estimate::Estimate;
use crate::diagnosis::search::{ROUGH, roughly};
use crate::estimation::{Score, ScoreTest};
use crate::model::{InputSignals, Model};
use crate::physics::effect::{self, Form, FreeParameter, InitialGuess};
use crate::rig::{EffectInstance, Location, ParameterSetting, Quantity, Rig};
use crate::settings::LearningSettings;

/// Sizes that are tried, in typical ones. What shifts the time at which the piston arrives is straight only where the shift is
/// less than a row.
pub(super) const SIZES: &[f64] = &[0.1, 1.0, 5.0, 25.0];
/// The same of an effect that is not straight: it shows itself only near its own size.
const BENT_SIZES: &[f64] = &[0.1, 1.0, 1.8, 3.0, 5.0, 9.0, 15.0, 25.0];
/// Shares of the highest pressure from which on an effect is tried, where it has one that has to be found: a valve stands at few
/// pressures, and from each place between two of them another one is found.
pub(super) const ONSETS: &[f64] = &[0.8, 0.65, 0.5, 0.35];
/// Where both have the typical one.
pub(super) const TYPICAL: usize = 1;

/// Where candidates are scored.
pub(super) struct ScoreContext<'a, 'e> {
    pub estimate: &'a Estimate<'e>,
    pub scoring: ScoreTest<'a>,
    /// What the sensors show there, `[sensor][row]`, SI, solved as roughly as what it is compared with.
    plain: Vec<Vec<f64>>,
    /// Fall of chi-square from which on an effect is looked at.
    worth: f64,
}

impl<'a, 'e> ScoreContext<'a, 'e> {
    /// `None` where the model cannot be solved.
    pub fn of(estimate: &'a Estimate<'e>, worth: f64) -> Option<Self> {
        let (case, isolation) = (&estimate.case, &estimate.isolation);
        let (full, best) = (&case.full, &isolation.best);
        let plain = roughly(full.model).solve(&full.parameters(&best.theta), full.drive, full.times).ok()?.values;
        let scoring = isolation.local.score_test(&case.problem(isolation.set()), &best.theta, &best.misfit).ok()?;
        Some(Self { estimate, scoring, plain, worth })
    }

    /// By how much other values of the rig's parameters, SI, change the weighted misfits; `None` where the model cannot be solved.
    pub fn change_of(&self, parameters: &[f64]) -> Option<Vec<f64>> {
        let full = &self.estimate.case.full;
        let with = roughly(full.model).solve(parameters, full.drive, full.times).ok()?.values;
        Some(full.weights.change(&with, &self.plain))
    }

    fn settings(&self) -> &'e LearningSettings {
        &self.estimate.case.rig().settings().learn
    }

    /// Whether a try changes the misfits so much that it raises the cost, however it points.
    fn is_hopeless(&self, tried: &TrialStep) -> bool {
        let most = self.settings().change_ratio;
        tried.information() > most * most * self.estimate.isolation.best.cost
    }
}

/// Whether an effect begins at a pressure that has to be found.
pub(super) fn begins_at_a_level(placed: &EffectInstance) -> bool {
    placed.effect.parameters.iter().any(|free| matches!(free.first, InitialGuess::Onset(_)))
}

/// The try of an effect that promises most.
pub(super) fn best_try(here: &ScoreContext<'_, '_>, placed: &EffectInstance) -> Option<Candidate> {
    let highest = |quantity| highest(here.estimate, placed.spot, quantity);
    let groups: Vec<Vec<TrialStep>> = if let Some(levels) = levels(placed) {
        let top = highest(Quantity::Level);
        let mut tried = levels.iter().filter_map(|&level| TrialStep::at(here, placed, (level, level * top), None));
        let first = tried.next()?;
        if !first.candidate.excited {
            return Some(first.candidate);
        }
        std::iter::once(first).chain(tried).map(|one| vec![one]).collect()
    } else if let Some(onset) =
        placed.effect.parameters.iter().find(|free| matches!(free.first, InitialGuess::Onset(_)))
    {
        let top = highest(Quantity::Pressure);
        if top > 0.0 {
            ONSETS.iter().map(|share| sizes(here, placed, share * top)).collect()
        } else {
            vec![sizes(here, placed, here.estimate.case.rig().first_size(placed, onset)?)]
        }
    } else {
        vec![sizes(here, placed, 0.0)]
    };
    let mut best: Vec<Candidate> =
        groups.into_iter().filter_map(|group| best_of(here.estimate.case.rig(), group)).collect();
    // Of those that promise as much the first.
    best.sort_by(|a, b| b.score.total_cmp(&a.score));
    let others = best.split_off(best.len().min(1));
    Some(Candidate { others, ..best.pop()? })
}

/// Of tries in the order of their sizes the one that promises most, with the smallest size that the record could show.
fn best_of(rig: &Rig, tried: Vec<TrialStep>) -> Option<Candidate> {
    if let Some(typical) = tried.iter().position(|one| one.step == SIZES[TYPICAL] && !one.candidate.excited) {
        return tried.into_iter().nth(typical).map(|one| one.candidate);
    }
    let mut tried: Vec<Candidate> = tried.into_iter().map(|one| one.candidate).collect();
    let smallest = smallest(tried.iter().filter_map(|one| Some((distance(rig, one)?, one.smallest))));
    let best =
        (0..tried.len()).reduce(|best, other| if tried[other].score > tried[best].score { other } else { best })?;
    let mut best = tried.swap_remove(best);
    if let (Some(smallest), Some(own)) = (smallest, distance(rig, &best)) {
        best.smallest = smallest / own;
    }
    Some(best)
}

/// The smallest distance from doing nothing that the record could show, by tries in the order of their sizes, each with its
/// distance and the factor on that which could be shown: from the first that is large enough down along a straight line, but
/// not to one that is too small.
fn smallest(tried: impl IntoIterator<Item = (f64, f64)>) -> Option<f64> {
    let mut least = None;
    let mut too_small = 0.0_f64;
    for (distance, factor) in tried {
        least = Some((factor * distance).max(too_small));
        if factor <= 1.0 {
            break;
        }
        too_small = distance;
    }
    least
}

/// A size or level that is tried.
pub(super) struct TrialStep {
    step: f64,
    /// Of the weighted misfits.
    pub change: Vec<f64>,
    /// `None` of one that changes next to nothing.
    pub score: Option<Score>,
    pub candidate: Candidate,
}

impl TrialStep {
    /// `None` where the model cannot be solved with it.
    pub fn at(
        here: &ScoreContext<'_, '_>,
        placed: &EffectInstance,
        (step, onset): (f64, f64),
        reach: Option<f64>,
    ) -> Option<Self> {
        let change = change(here, placed, &attempt(here.estimate, placed, (step, onset)))?;
        Some(Self::of(here, placed, (step, onset), change, reach))
    }

    /// One of which it is known what it changes.
    pub fn of(
        here: &ScoreContext<'_, '_>,
        placed: &EffectInstance,
        (step, onset): (f64, f64),
        change: Vec<f64>,
        reach: Option<f64>,
    ) -> Self {
        let attempt = attempt(here.estimate, placed, (step, onset));
        let (candidate, score) = scored(here, placed, attempt, &change, reach);
        Self { step, change, score, candidate }
    }

    /// Squares of what of the change nothing fitted can take over.
    fn information(&self) -> f64 {
        self.score.as_ref().map_or(0.0, |score| score.information)
    }
}

/// Sizes of an effect, as many as it takes to see whether one of them explains what is missed.
fn sizes(here: &ScoreContext<'_, '_>, placed: &EffectInstance, onset: f64) -> Vec<TrialStep> {
    let mut tried: Vec<TrialStep> = Vec::new();
    for (place, &step) in SIZES.iter().enumerate() {
        let Some(one) = TrialStep::at(here, placed, (step, onset), Some(here.settings().size_factor)) else { continue };
        let bent = place == TYPICAL
            && tried.first().is_some_and(|least| cosine(&least.change, &one.change) < here.settings().straight_cosine)
            && one.candidate.excited;
        if bent {
            // The least is near enough to nothing to be straight, but not far beyond itself.
            for least in &mut tried {
                let attempt = std::mem::take(&mut least.candidate.tried);
                (least.candidate, least.score) =
                    scored(here, placed, attempt, &least.change, Some(here.settings().larger_factor));
            }
            break;
        }
        // A size on a straight line that asks for no larger one has none that promises more.
        let enough =
            place >= TYPICAL && !asks_for_more(here.settings().larger_factor, &one.candidate, place == TYPICAL);
        tried.push(one);
        if enough || (place == TYPICAL && !tried[tried.len() - 1].candidate.excited) {
            return tried;
        }
    }
    if tried.len() > TYPICAL {
        return tried;
    }
    for &step in &BENT_SIZES[TYPICAL..] {
        let Some(one) = TrialStep::at(here, placed, (step, onset), None) else { continue };
        let hopeless = here.is_hopeless(&one);
        tried.push(one);
        // Larger ones change more still.
        if hopeless {
            break;
        }
    }
    let unlike = |pair: &[TrialStep]| {
        let between = !here.is_hopeless(&pair[0]) && pair.iter().all(|one| one.candidate.excited);
        between
            && pair[1].step > here.settings().size_ratio * pair[0].step
            && cosine(&pair[0].change, &pair[1].change) < here.settings().neighbour_cosine
    };
    while tried.len() < here.settings().sizes {
        // The small ones first: they are likelier.
        let Some(place) = tried.windows(2).position(unlike) else { break };
        let step = (tried[place].step * tried[place + 1].step).sqrt();
        let Some(between) = TrialStep::at(here, placed, (step, onset), None) else { break };
        tried.insert(place + 1, between);
    }
    tried
}

/// How far the tried size is from doing nothing, SI; `None` of a level, which is where it is.
pub(super) fn distance(rig: &Rig, candidate: &Candidate) -> Option<f64> {
    let (free, tried) = candidate.placed.effect.parameters.first().zip(candidate.tried.first())?;
    Some((tried.value - nothing(rig, &candidate.placed, free)?).abs()).filter(|distance| *distance > 0.0)
}

/// Cosine between two changes of the misfits; 0 where one is none.
fn cosine(a: &[f64], b: &[f64]) -> f64 {
    let (mut along, mut of_a, mut of_b) = (0.0, 0.0, 0.0);
    for (a, b) in a.iter().zip(b) {
        (along, of_a, of_b) = (along + a * b, of_a + a * a, of_b + b * b);
    }
    if of_a > 0.0 && of_b > 0.0 { along / (of_a * of_b).sqrt() } else { 0.0 }
}

/// Whether the best size lies beyond the one that was tried. A typical one of the wrong sign does not say that.
fn asks_for_more(larger: f64, tried: &Candidate, typical: bool) -> bool {
    if tried.score > 0.0 { tried.factor.abs() > larger } else { typical }
}

/// Shares or distances at which a level is tried, where an effect has one that has to be found.
pub(super) fn levels(placed: &EffectInstance) -> Option<&'static [f64]> {
    placed.effect.has_level().then_some(match placed.spot {
        // Readings pile up at a limit, noise above it.
        Location::Sensor(_) => &[0.0, 2.0],
        _ => &[0.6, 0.75, 0.85, 0.95],
    })
}

/// What is tried of each parameter at a step, SI: so many typical sizes, from a level or pressure on where it has one.
pub(super) fn attempt(
    estimate: &Estimate<'_>,
    placed: &EffectInstance,
    (step, onset): (f64, f64),
) -> Vec<ParameterSetting> {
    let rig = estimate.case.rig();
    let of_level = levels(placed).is_some();
    let one = |free: &FreeParameter| {
        let value = match (rig.first_size(placed, free), placed.spot) {
            (Some(_), _) if matches!(free.first, InitialGuess::Onset(_)) => onset,
            (Some(first), _) if of_level => first,
            // What only shapes the effect stays.
            (Some(first), _) => {
                let typical = typical(rig, placed, free);
                nothing(rig, placed, free).zip(typical).map_or(first, |(from, typical)| from + step * typical)
            }
            (None, Location::Sensor(sensor)) => {
                ends(estimate.case.full.measured[sensor]).1 - step * rig.sensors[sensor].noise
            }
            (None, _) => onset,
        };
        ParameterSetting { name: free.name.to_owned(), value, sigma: 0.0 }
    };
    placed.effect.parameters.iter().map(one).collect()
}

fn ends(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(*value), high.max(*value)))
}

/// By how much a try changes the weighted misfits; `None` where the model cannot be solved with it.
fn change(here: &ScoreContext<'_, '_>, placed: &EffectInstance, tried: &[ParameterSetting]) -> Option<Vec<f64>> {
    let ScoreContext { estimate, plain, .. } = here;
    let (case, full) = (&estimate.case, &estimate.case.full);
    let mut rig = full.model.rig.clone();
    let indices = rig.give_effect(placed, tried).ok()?;
    let mut values = full.parameters(&estimate.isolation.best.theta);
    values.extend(rig.parameters[values.len()..].iter().map(|parameter| parameter.value));
    for (given, &index) in tried.iter().zip(&indices) {
        values[index] = given.value;
    }
    let with = if let (Form::Reading { card }, Location::Sensor(sensor)) = (placed.effect.form, placed.spot) {
        // What a sensor does to its readings changes nothing else.
        let (does, mut with) = (rig.readings.last()?, plain.clone());
        effect::read(
            card,
            &values[does.first_parameter..][..card.parameters.len()],
            full.drive.begun,
            full.times,
            with.get_mut(sensor)?,
        );
        with
    } else {
        let drive = InputSignals::from_record(&rig, case.record).ok()?;
        Model::new(rig).with_tolerance(ROUGH).solve(&values, &drive, full.times).ok()?.values
    };
    Some(full.weights.change(&with, plain))
}

/// A try with the score of its change; believed where it lies, or along a straight line through it as far as `reach` times its
/// size. Of one that changes next to nothing no score is taken.
fn scored(
    here: &ScoreContext<'_, '_>,
    placed: &EffectInstance,
    tried: Vec<ParameterSetting>,
    change: &[f64],
    reach: Option<f64>,
) -> (Candidate, Option<Score>) {
    let full = &here.estimate.case.full;
    let size = change.iter().map(|c| c * c).sum::<f64>().sqrt();
    let mut candidate = Candidate {
        id: full.model.rig.effect_id(placed),
        placed: *placed,
        tried,
        score: 0.0,
        base_point: None,
        factor: 0.0,
        smallest: f64::INFINITY,
        own: 0.0,
        absorbed_by: None,
        excited: size > here.settings().excited_change,
        others: Vec::new(),
    };
    if !candidate.excited {
        return (candidate, None);
    }
    let score = here.scoring.of(change);
    candidate.own = score.own;
    candidate.smallest = if score.information > 0.0 { (here.worth / score.information).sqrt() } else { f64::INFINITY };
    if score.own < here.settings().absorbed_share {
        candidate.absorbed_by = score.absorbed_by.map(|index| {
            let parameter = full.estimated[index].parameter;
            full.model.rig.parameters[parameter].id.clone()
        });
    }
    // A size of the wrong sign has no sense, one far beyond what was tried no straight line to it.
    candidate.factor = reach.map_or(1.0, |reach| score.factor.clamp(-reach, reach));
    candidate.score =
        if sign_fits(&full.model.rig, placed, score.factor) { score.fall_at(candidate.factor) } else { 0.0 };
    (candidate, Some(score))
}

/// Whether an effect may have a size of the sign of this factor on a try.
pub(super) fn sign_fits(rig: &Rig, placed: &EffectInstance, factor: f64) -> bool {
    let two_sided = |free: &FreeParameter| {
        let from = nothing(rig, placed, free).filter(|_| free.neutral.is_some()).unwrap_or(0.0);
        rig.effect_unit(placed, free.name).difference_to_si(free.plausible.0) < from
    };
    factor > 0.0 || placed.effect.parameters.first().is_some_and(two_sided)
}

#[cfg(test)]
mod tests {
    use super::smallest;

    #[test]
    fn the_smallest_size_lies_between_one_too_small_and_one_large_enough() {
        // A straight line: all say the same, and the first is large enough.
        assert_eq!(smallest([(2.0, 0.25), (20.0, 0.025)]), Some(0.5));
        // What is felt late: a line from 20 would say 4, but 5 is seen to be too small.
        assert_eq!(smallest([(1.0, 90.0), (5.0, 3.0), (20.0, 0.2)]), Some(5.0));
        assert_eq!(smallest([(1.0, 90.0), (5.0, 3.0), (20.0, 0.5)]), Some(10.0));
        // Nothing is large enough: along a line from the largest.
        assert_eq!(smallest([(1.0, 90.0), (5.0, 3.0)]), Some(15.0));
        assert_eq!(smallest([]), None);
    }
}
