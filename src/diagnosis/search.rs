//! Where to start when the healthy rig is far off: few faults of components, those that explain the record best.
//!
//! Far from the truth the cost has many valleys, and with all faults free it is easy to end in one where some stand in for
//! others. Sets are therefore grown from nothing, as in orthogonal matching pursuit (Pati, Rezaiifar, Krishnaprasad, 1993):
//! single faults and pairs are simulated at a few levels, the best are fitted, and the best of those takes one fault more at a
//! time.

use argmin::core::{CostFunction, Error, Executor};
use argmin::solver::brent::BrentOpt;
use rayon::prelude::*;

use super::case::{Case, level, robust};
use super::events::weights;
use super::noise::{self, Weights};
use super::problem::RecordProblem;
use crate::estimation::{self, Linearised, Loss, Options, Problem};
use crate::model::{Model, Tolerance};
use crate::rig::FaultSet;
use crate::settings::DiagnosisSettings;

/// Shares of the way to a bound at which single faults are simulated before any is fitted.
const LEVELS: [f64; 3] = [0.2, 0.5, 0.75];
/// The same for each of a pair.
const PAIRED: [f64; 1] = [0.45];
/// A level that costs this little more or less than none at all does nothing: half a chi-square of one, a standard error.
const NOTHING: f64 = 0.5;
/// Halvings of the way between a level that does nothing and one that acts: to a sixty-fourth of it.
const HALVINGS: usize = 6;
/// Errors of a thousandth of a bar, which is far below what places, or rough fits, differ by.
pub(crate) const ROUGH: Tolerance = Tolerance { relative: 1e-5, absolute: 1e-5 };

/// How far a search goes.
#[derive(Debug, Clone, Copy)]
pub struct Depth {
    /// How many of what is simulated are fitted.
    fitted: usize,
    /// How many of the fitted ones are grown.
    grown: usize,
}

impl Depth {
    /// Single faults, as far as they go.
    pub(crate) fn single(settings: &DiagnosisSettings) -> Self {
        Self { fitted: settings.single_starts_fitted, grown: 0 }
    }

    /// Several faults at once, where neither the healthy rig nor one fault leads to them.
    pub(crate) fn several(settings: &DiagnosisSettings) -> Self {
        Self { fitted: settings.several_starts_fitted, grown: settings.several_starts_grown }
    }
}

/// A model, solved as roughly as places, and fits on the way, need it.
pub(crate) fn roughly(model: &Model) -> Model {
    model.clone().with_tolerance(ROUGH)
}

/// Few faults of components with their values, SI.
#[derive(Debug, Clone)]
pub struct Place {
    pub faults: Vec<(usize, f64)>,
    /// What it leaves of the record, by a loss that large misfits do not rule.
    cost: f64,
    /// The same per sample once its events have got their tolerance; infinite where it is far off or was not asked.
    left: f64,
    /// Those of there with that tolerance, where they were asked.
    pub weights: Option<Weights>,
    /// Whether its values are the best ones near it.
    is_fitted: bool,
}

impl Place {
    /// Whether it leaves so little that nothing further is looked for.
    pub fn leaves_nothing(&self, case: &Case<'_>) -> bool {
        self.left <= case.settings().start_cost_sufficient
    }

    pub fn set(&self) -> FaultSet {
        self.faults.iter().map(|(fault, _)| *fault).collect()
    }

    /// All estimated parameters, SI.
    pub fn theta(&self, case: &Case<'_>) -> Vec<f64> {
        let mut theta = case.mean.clone();
        for &(fault, value) in &self.faults {
            theta[fault] = value;
        }
        theta
    }
}

/// Places that few faults explain best, the best first.
pub fn places(case: &Case<'_>, depth: Depth) -> Vec<Place> {
    let mut search = Search {
        case,
        model: roughly(case.full.model),
        variance: noise::variances(case.rig(), case.record, &case.full.measured, true),
        begins: Vec::new(),
    };
    let mut screened = search.screened(search.singles());
    let begins = search.beginnings(&screened);
    search.begins = begins.iter().map(|place| place.faults[0]).collect();
    screened.extend(begins);
    sort(&mut screened);
    // Of each fault its best level: several of one would take the place of others.
    let mut singles: Vec<Place> = Vec::new();
    for place in &screened {
        if singles.len() < case.settings().single_starts_fitted
            && !singles.iter().any(|known| known.set() == place.set())
        {
            singles.push(place.clone());
        }
    }
    let bracketed = singles.into_par_iter().map(|place| search.bracketed(place)).collect();
    let mut singles = search.all_fitted(bracketed);
    if depth.grown == 0 {
        return singles;
    }
    // One fault that leaves nothing needs no others beside it.
    if let Some(one) = singles.first_mut() {
        search.ask_what_is_left(one);
        if one.leaves_nothing(case) {
            singles.truncate(1);
            return singles;
        }
    }
    screened.extend(search.screened(search.pairs()));
    screened.extend(singles);
    sort(&mut screened);
    screened.truncate(depth.fitted);
    let fitted = search.all_fitted(screened);
    let mut grown: Vec<Place> = Vec::new();
    for place in fitted.into_iter().take(depth.grown) {
        let place = search.grown(place);
        if place.left <= case.settings().start_cost_after {
            return vec![place];
        }
        grown.push(place);
    }
    sort(&mut grown);
    grown.dedup_by_key(|place| place.set());
    grown
}

fn sort(places: &mut [Place]) {
    places.sort_by(|a, b| a.cost.total_cmp(&b.cost));
}

struct Search<'a> {
    case: &'a Case<'a>,
    /// The model, solved as roughly as places need it.
    model: Model,
    /// Of each sample as measured, `[sensor][row]`, SI squared.
    variance: Vec<Vec<f64>>,
    /// Faults that do nothing until they have gone a good part of their way, each where it explains most of what it does first, SI.
    begins: Vec<(usize, f64)>,
}

/// What the sensors would read, `[sensor][row]`, SI.
type Outputs = Vec<Vec<f64>>;

/// A fault alone between two values, SI.
struct Along<'s, 'a> {
    search: &'s Search<'a>,
    fault: usize,
    from: f64,
    to: f64,
}

impl Along<'_, '_> {
    fn value(&self, share: f64) -> f64 {
        self.from + share * (self.to - self.from)
    }
}

impl CostFunction for &Along<'_, '_> {
    type Param = f64;
    type Output = f64;

    fn cost(&self, share: &f64) -> Result<f64, Error> {
        let place = self.search.simulated(vec![(self.fault, self.value(*share))]);
        // Where the model cannot be solved no minimum is; finite, since Brent draws parabolas.
        Ok(place.map_or(f64::MAX.sqrt(), |place| place.cost))
    }
}

impl Search<'_> {
    /// The problem of these faults alone.
    fn problem(&self, faults: &[(usize, f64)]) -> RecordProblem<'_> {
        let full = &self.case.full;
        let estimated = faults.iter().map(|&(fault, _)| full.estimated[fault].clone()).collect();
        let (measured, weights) = (full.measured.clone(), full.weights.clone());
        let mut problem = RecordProblem::new(&self.model, full.drive, full.times, measured, weights, estimated);
        problem.base.clone_from(&full.base);
        problem
    }

    /// `None` where the model cannot be solved.
    fn simulated(&self, faults: Vec<(usize, f64)>) -> Option<Place> {
        Some(self.solved(faults)?.0)
    }

    /// The same with what the sensors would read there.
    fn solved(&self, faults: Vec<(usize, f64)>) -> Option<(Place, Outputs)> {
        let theta: Vec<f64> = faults.iter().map(|(_, value)| *value).collect();
        let problem = self.problem(&faults);
        let outputs = problem.outputs(&problem.parameters(&theta), problem.drive).ok()?;
        // By how much of the record is explained: a sample that is missed counts, hardly by how much. Position adds up what is wrong
        // before it, and would drown the rest.
        let far = Loss::Cauchy { k: self.case.settings().start_loss_width };
        let cost = far.cost(&problem.weigh(&outputs));
        Some((Place { faults, cost, left: f64::INFINITY, weights: None, is_fitted: false }, outputs))
    }

    /// Values of a fault at shares of the way to each of its bounds, and where it begins to act.
    fn levels<'s>(&'s self, fault: usize, shares: &'s [f64]) -> impl Iterator<Item = f64> + use<'s> {
        let begins = self.begins.iter().filter(move |(own, _)| *own == fault).map(|(_, value)| *value);
        self.case.levels(fault, shares).chain(begins)
    }

    /// Where single faults explain most near the point at which they begin to act, of those that do nothing at the first of their levels: a
    /// relief valve that is set lower does nothing until it opens, and soon after a pump moves nothing any more.
    fn beginnings(&self, screened: &[Place]) -> Vec<Place> {
        let cost =
            |faults: &[(usize, f64)]| screened.iter().find(|place| place.faults == faults).map(|place| place.cost);
        let Some(none) = cost(&[]) else { return Vec::new() };
        let acts = |cost: Option<f64>| cost.is_none_or(|cost| (cost - none).abs() > NOTHING);
        let to_an_end = |(fault, end): (usize, f64)| {
            let levels = LEVELS.map(|share| level(self.case.mean[fault], end, share));
            let first = levels.iter().position(|&level| acts(cost(&[(fault, level)])));
            let (mut idle, mut acting) = match first {
                Some(first) => (levels[first.checked_sub(1)?], levels[first]),
                None => (levels[LEVELS.len() - 1], end),
            };
            if first.is_none() && !acts(self.simulated(vec![(fault, end)]).map(|place| place.cost)) {
                return None;
            }
            let mut best: Option<Place> = None;
            for _ in 0..HALVINGS {
                let between = f64::midpoint(idle, acting);
                let there = self.simulated(vec![(fault, between)]);
                if acts(there.as_ref().map(|place| place.cost)) {
                    acting = between;
                    best = best.into_iter().chain(there).min_by(|a, b| a.cost.total_cmp(&b.cost));
                } else {
                    idle = between;
                }
            }
            best.filter(|best| best.cost < none)
        };
        let ends = |fault: usize| self.case.ends(fault).map(move |end| (fault, end));
        self.components().into_iter().flat_map(ends).collect::<Vec<_>>().into_par_iter().filter_map(to_an_end).collect()
    }

    /// A single fault where it explains most between the levels beside its best one. From there a fit is near: from further away
    /// events of the model and of the record lie apart, and its steps are as short as an event is.
    fn bracketed(&self, place: Place) -> Place {
        let [(fault, best)] = place.faults[..] else { return place };
        let (low, high) = self.case.rig().faults[fault].bounds;
        let ends: Vec<f64> =
            [low, high, self.case.mean[fault]].into_iter().chain(self.case.levels(fault, &LEVELS)).collect();
        let beside = |is_beyond: fn(f64, f64) -> bool, nearest: fn(f64, f64) -> f64| {
            ends.iter().copied().filter(|&end| is_beyond(end, best)).reduce(nearest).unwrap_or(best)
        };
        let along = Along {
            search: self,
            fault,
            from: beside(|end, best| end < best, f64::max),
            to: beside(|end, best| end > best, f64::min),
        };
        let solver = BrentOpt::new(0.0, 1.0).set_tolerance(0.0, self.case.settings().bracket_share);
        let found = Executor::new(&along, solver)
            .configure(|state| state.max_iters(self.case.settings().bracket_simulations))
            .run();
        let share = found.ok().and_then(|found| found.state.best_param);
        let found = share.and_then(|share| self.simulated(vec![(fault, along.value(share))]));
        found.filter(|found| found.cost < place.cost).unwrap_or(place)
    }

    /// A place at the best values of its faults; `None` where the model cannot be solved.
    ///
    /// Where the model has an event its derivatives are as steep as the event, and a fit that saw them at full weight would step no
    /// further than events last. So each round gives the model's own events their tolerance, as the record's have theirs.
    fn fitted(&self, place: Place) -> Option<Place> {
        let (mut best, mut outputs) = self.solved(place.faults)?;
        for _ in 0..self.case.settings().start_fit_rounds {
            let start: Vec<f64> = best.faults.iter().map(|(_, value)| *value).collect();
            let mut problem = self.problem(&best.faults);
            problem.weights = self.tolerant(&outputs);
            let mut sizes: Vec<f64> = problem.weigh(&outputs).into_iter().map(f64::abs).collect();
            let at = ((sizes.len() as f64 * self.case.settings().start_share_within) as usize)
                .min(sizes.len().checked_sub(1)?);
            let loss = Loss::SoftL1 {
                k: sizes.select_nth_unstable_by(at, f64::total_cmp).1.max(self.case.settings().start_loss_width),
            };
            let options = Options {
                function: self.case.settings().start_fit_decrease,
                max_iterations: self.case.settings().start_fit_iterations,
                ..Options::default()
            };
            let Ok(found) = estimation::fit(&problem, &start, loss, options) else { break };
            let faults = best.faults.iter().zip(&found.theta).map(|(&(fault, _), &value)| (fault, value)).collect();
            let Some((next, there)) = self.solved(faults) else { break };
            let fallen = 1.0 - next.cost / best.cost;
            if fallen > 0.0 {
                (best, outputs) = (next, there);
            }
            if fallen < self.case.settings().start_fit_decrease {
                break;
            }
        }
        Some(Place { is_fitted: true, ..best })
    }

    /// Weights that give the events of the record and of what the sensors would read their tolerance.
    fn tolerant(&self, outputs: &Outputs) -> Weights {
        let (rig, record) = (self.case.rig(), self.case.record);
        let curves: Vec<&[f64]> = outputs.iter().map(Vec::as_slice).collect();
        let mut variance = noise::variances(rig, record, &curves, false);
        for (own, measured) in variance.iter_mut().flatten().zip(self.variance.iter().flatten()) {
            *own = own.max(*measured);
        }
        Weights::without_changes(rig, self.case.full.drive, &record.time, &variance)
    }

    /// Asks what a place leaves per sample once its events have got their tolerance, but for one that is far off anyway.
    fn ask_what_is_left(&self, place: &mut Place) {
        let full = &self.case.full;
        let samples = full.weights.all_samples() as f64;
        if place.weights.is_some() || place.cost > self.case.settings().start_cost_before * samples {
            return;
        }
        let Ok(weights) = weights(full, self.case.record, &place.theta(self.case)) else { return };
        let mut there = self.problem(&place.faults);
        there.weights = weights;
        let theta: Vec<f64> = place.faults.iter().map(|(_, value)| *value).collect();
        let misfit = there.misfit(&theta);
        place.left = misfit.map_or(f64::INFINITY, |misfit| robust(self.case.rig()).cost(&misfit) / samples);
        place.weights = Some(there.weights);
    }

    /// With one fault more at a time, or one for another where there are enough, while each change takes away a good share
    /// of the cost.
    fn grown(&self, mut place: Place) -> Place {
        self.ask_what_is_left(&mut place);
        while !place.leaves_nothing(self.case) {
            let bases: Vec<Vec<(usize, f64)>> = if place.faults.len() < self.case.settings().start_faults {
                vec![place.faults.clone()]
            } else {
                // Without each of them in turn: the first ones were chosen while the others still hid what they do.
                let without = |out: usize| place.faults.iter().enumerate().filter(move |(at, _)| *at != out);
                (0..place.faults.len()).map(|out| without(out).map(|(_, fault)| *fault).collect()).collect()
            };
            let others = self.others(&place);
            let pointed: Vec<Vec<(usize, f64)>> = bases.iter().map(|base| self.pointed_at(base)).collect();
            let tried: Vec<(usize, usize)> =
                (0..bases.len()).flat_map(|base| others.iter().map(move |&other| (base, other))).collect();
            let at_its_best_level = |(base, fault): (usize, usize)| {
                let pointed = pointed[base].iter().filter(|(other, _)| *other == fault).map(|(_, value)| *value);
                let levels = self.levels(fault, &LEVELS).chain(pointed).filter_map(|at| {
                    let mut faults = bases[base].clone();
                    faults.push((fault, at));
                    self.simulated(faults)
                });
                levels.min_by(|a, b| a.cost.total_cmp(&b.cost))
            };
            let mut next: Vec<Place> = tried.into_par_iter().filter_map(at_its_best_level).collect();
            sort(&mut next);
            next.truncate(self.case.settings().growth_fits);
            match self.all_fitted(next).into_iter().next() {
                Some(next) if next.cost < (1.0 - self.case.settings().growth_share) * place.cost => place = next,
                _ => break,
            }
            self.ask_what_is_left(&mut place);
        }
        place
    }

    /// Faults of components that a place does not have.
    fn others(&self, place: &Place) -> Vec<usize> {
        let set = place.set();
        self.components().into_iter().filter(|&fault| !set.contains(fault)).collect()
    }

    /// Faults of components.
    fn components(&self) -> Vec<usize> {
        (0..self.case.faults()).filter(|&fault| !self.case.is_of_sensor(fault)).collect()
    }

    /// Nothing, and single faults at a few levels towards each of their bounds and where the derivatives point.
    fn singles(&self) -> Vec<Vec<(usize, f64)>> {
        let one = |fault| self.case.levels(fault, &LEVELS).map(move |at| vec![(fault, at)]);
        let levels = self.components().into_iter().flat_map(one);
        let pointed = self.pointed_at(&[]).into_iter().map(|one| vec![one]);
        std::iter::once(Vec::new()).chain(levels).chain(pointed).collect()
    }

    /// Of each fault of a component the value to which the derivatives at a place point, that fault alone moved: shares of the way to a
    /// bound miss what is small beside bounds that are wide.
    fn pointed_at(&self, place: &[(usize, f64)]) -> Vec<(usize, f64)> {
        let at = |fault: usize| {
            let own = place.iter().find(|(own, _)| *own == fault);
            (fault, own.map_or(self.case.mean[fault], |(_, value)| *value))
        };
        let faults: Vec<(usize, f64)> = self.components().into_iter().map(at).collect();
        let theta: Vec<f64> = faults.iter().map(|(_, value)| *value).collect();
        let Ok(Linearised { misfit, jacobian }) = self.problem(&faults).linearise(&theta) else { return Vec::new() };
        let far = Loss::Cauchy { k: self.case.settings().start_loss_width };
        let weights: Vec<f64> = misfit.iter().map(|&misfit| far.weight(misfit)).collect();
        let step = |column: &[f64]| {
            let (mut slope, mut curvature) = (0.0, 0.0);
            for ((weight, misfit), derivative) in weights.iter().zip(&misfit).zip(column) {
                slope += weight * derivative * misfit;
                curvature += weight * derivative * derivative;
            }
            -slope / curvature
        };
        let pointed = faults.iter().zip(jacobian.column_iter()).filter_map(|(&(fault, from), column)| {
            let (low, high) = self.case.rig().faults[fault].bounds;
            let value = (from + step(column.as_slice())).clamp(low, high);
            (value.is_finite() && value != from).then_some((fault, value))
        });
        pointed.collect()
    }

    /// Pairs of faults, each at a few levels towards each of its bounds.
    fn pairs(&self) -> Vec<Vec<(usize, f64)>> {
        let components = self.components();
        let mut all = Vec::new();
        for (place, &a) in components.iter().enumerate() {
            for at in self.levels(a, &PAIRED) {
                for &b in &components[..place] {
                    all.extend(self.levels(b, &PAIRED).map(|other| vec![(a, at), (b, other)]));
                }
            }
        }
        all
    }

    /// All of them simulated, the best first.
    fn screened(&self, all: Vec<Vec<(usize, f64)>>) -> Vec<Place> {
        let mut screened: Vec<Place> = all.into_par_iter().filter_map(|faults| self.simulated(faults)).collect();
        sort(&mut screened);
        screened
    }

    /// All of them fitted, the best first.
    fn all_fitted(&self, places: Vec<Place>) -> Vec<Place> {
        let fitted = |place: Place| if place.is_fitted { Some(place) } else { self.fitted(place) };
        let mut fitted: Vec<Place> = places.into_par_iter().filter_map(fitted).collect();
        sort(&mut fitted);
        fitted
    }
}
