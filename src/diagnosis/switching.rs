//! How spools follow their commands, as a record shows it: lag, mass and dead time, which no data sheet states.
//!
//! A spool that overshoots opens the wrong edges for a moment, and trapped oil remembers it: readings far from straight in the
//! spool's mass, which the weights of events span near the rig file's values only ([`super::events`]). Where faults are found or none
//! explain a record, other dynamics of the spools are therefore asked for at the explanation at hand: by how much the cost would
//! fall with each, everything estimated following ([`crate::estimation::Score`]). The record is then explained again with those found.

use rayon::prelude::*;

use super::case::Case;
use super::estimate::Estimate;
use super::result::DynamicsReport;
use crate::estimation::ScoreTest;
use crate::estimation::criteria::bic;
use crate::estimation::pattern::{Patience, least, pattern_search};
use crate::model::InputSignals;
use crate::number::rounded;
use crate::rig::{Follower, Rig};

/// What is searched of a spool: logarithm of its lag over the stated one, `(T/tau)²`, and dead time over the stated lag.
type Dynamics = [f64; DYNAMICS];
pub(crate) const DYNAMICS: usize = 3;
/// From half to twice the stated lag; to a damping of 0.4, whose overshoot is a quarter of the stroke; dead times to three lags.
const BOUNDS: [(f64, f64); 3] = [(-std::f64::consts::LN_2, std::f64::consts::LN_2), (0.0, 1.5625), (0.0, 3.0)];
/// Where the search begins: lags two thirds of the stated one, as stated and half as long again; no mass, and dampings of 0.8 and 0.6;
/// no dead time, and half a lag. Between them a search by small steps finds its way.
const LAGS: [f64; 3] = [-0.4, 0.0, 0.4];
const SHARES: [f64; 3] = [0.0, 0.39, 0.69];
const DEAD_TIMES: [f64; 2] = [0.0, 0.5];
/// First steps of the search, which are halved where none leads on.
const STEPS: Dynamics = [0.2, 0.15, 0.25];
/// The small ones among the first, as a share: 5 % of the lag, 4 % of the damping.
const SMALL: f64 = 0.25;
/// What an error, times the sensor noise, is beyond noise, as a square.
pub(crate) fn beyond_noise(times_noise: f64) -> f64 {
    (times_noise * times_noise - 1.0).max(0.0)
}

/// Digits of a reported time constant.
const DIGITS: usize = 4;

/// How spools follow as a record shows, explained as `near` has it: parameters by index with their values, SI. `None` where nothing
/// speaks against the rig file.
pub(super) fn found(near: &Estimate<'_>) -> Option<Vec<(usize, f64)>> {
    let rig = near.case.rig();
    let asked = Asked::of(near)?;
    let samples = near.case.full.weights.all_samples() as f64;
    let worth = |gain: f64| bic(-gain, DYNAMICS, samples) < 0.0;
    let speaks = |others: &[Rig]| asked.most(others).is_none_or(&worth);
    let (other, reached) = searched(rig, rig, &|other| asked.fall(other), (speaks, worth), Open::All)?;
    (reached > near.case.settings().dynamics_gain_share * (near.isolation.best.cost - samples))
        .then(|| values(rig, &other, Open::All))
}

/// What of the dynamics of spools is searched.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Open {
    All,
    /// The lag as stated.
    MassAndDeadTime,
}

/// The rig at hand, stated but for how its spools follow, with others as `fall` says that they are better, one after the other, and that
/// fall; each has to gain what is `worth` it. A spool of which a few others do not `speak` is not searched. `None` where none is better.
pub(crate) fn searched(
    stated: &Rig,
    at_hand: &Rig,
    fall: &(impl Fn(&Rig) -> Option<f64> + Sync),
    (speaks, worth): (impl Fn(&[Rig]) -> bool, impl Fn(f64) -> bool),
    open: Open,
) -> Option<(Rig, f64)> {
    let (mut other, mut reached) = (at_hand.clone(), 0.0);
    for follower in stated.followers().filter(|follower| stated.is_alone(follower)) {
        let search = Search { fall, stated, rig: &other, follower, open };
        if !search.probes().is_some_and(|probes| speaks(&probes)) {
            continue;
        }
        let Some((dynamics, fallen)) = search.best() else { continue };
        if worth(fallen - reached) {
            (other, reached) = (search.with(dynamics)?, fallen);
        }
    }
    (!changed(at_hand, &other, open).is_empty()).then_some((other, reached))
}

/// How long how parts follow is searched.
pub(crate) fn patience(rig: &Rig) -> Patience {
    let settings = &rig.settings().diagnosis;
    Patience { moves: settings.dynamics_steps, halvings: settings.dynamics_halvings }
}

/// How spools follow in a rig otherwise than as stated, for [`applied`]: parameters by index with their values, SI.
pub(crate) fn values(stated: &Rig, found: &Rig, open: Open) -> Vec<(usize, f64)> {
    changed(stated, found, open).into_iter().map(|own| (own, found.parameters[own].value)).collect()
}

/// A rig whose spools follow, or whose parts lag, as found. What `found` has been asked with may have further parameters behind those of the rig, such as
/// what faults were before they began.
pub(crate) fn applied(rig: &Rig, found: &[(usize, f64)]) -> Rig {
    let mut other = rig.clone();
    found.iter().for_each(|&(own, value)| other.parameters[own].value = value);
    other
}

/// Parameters of how spools follow that a rig has otherwise than as stated, of those that were searched.
pub(crate) fn changed(stated: &Rig, found: &Rig, open: Open) -> Vec<usize> {
    let of = |follower: Follower| {
        let lag = (open == Open::All).then_some(follower.lag);
        [lag, follower.inertia_time, follower.dead_time].into_iter().flatten()
    };
    let all = stated.followers().flat_map(of);
    all.filter(|&own| stated.parameters[own].value != found.parameters[own].value).collect()
}

/// What of its spools a rig has otherwise than the rig file.
pub(crate) fn report(stated: &Rig, found: &Rig, open: Open) -> Vec<DynamicsReport> {
    let report = |own: usize| {
        let parameter = &stated.parameters[own];
        let shown = |si: f64| rounded(parameter.unit.difference_from_si(si), DIGITS);
        DynamicsReport {
            id: parameter.id.clone(),
            value: shown(found.parameters[own].value),
            unit: parameter.unit.to_string(),
            nominal: shown(parameter.value),
        }
    };
    changed(stated, found, open).into_iter().map(report).collect()
}

/// An explanation at which other dynamics are asked for.
struct Asked<'e, 'a> {
    case: &'e Case<'a>,
    /// All of the rig's, SI.
    parameters: Vec<f64>,
    /// What its sensors read, `[sensor][row]`, SI.
    plain: Vec<Vec<f64>>,
    test: ScoreTest<'e>,
}

impl<'e, 'a> Asked<'e, 'a> {
    /// At an explanation; `None` where the model cannot be solved there.
    fn of(near: &'e Estimate<'a>) -> Option<Self> {
        let (case, isolation) = (&near.case, &near.isolation);
        let best = &isolation.best;
        let parameters = case.full.parameters(&best.theta);
        let plain = case.full.outputs(&parameters, case.full.drive).ok()?;
        let test = isolation.local.score_test(&case.problem(isolation.set()), &best.theta, &best.misfit).ok()?;
        Some(Self { case, parameters, plain, test })
    }

    /// By how much the cost would fall with the spools of another rig.
    fn fall(&self, other: &Rig) -> Option<f64> {
        let fall = self.test.of(&self.change(other)?).fall_at(1.0);
        fall.is_finite().then_some(fall)
    }

    /// The most that any sum of what the spools of some rigs change could bring.
    fn most(&self, others: &[Rig]) -> Option<f64> {
        let changes: Option<Vec<_>> = others.par_iter().map(|other| self.change(other)).collect();
        Some(self.test.most(&changes?)).filter(|most| most.is_finite())
    }

    /// What the spools of another rig change of the misfits.
    fn change(&self, other: &Rig) -> Option<Vec<f64>> {
        let full = &self.case.full;
        let drive = InputSignals::from_record(other, self.case.record).ok()?.in_run_of(full.drive);
        let mut parameters = self.parameters.clone();
        for lag in other.followers().map(|follower| follower.lag).filter(|&lag| !self.case.rig().is_fault(lag)) {
            parameters[lag] = other.parameters[lag].value;
        }
        let with = full.outputs(&parameters, &drive).ok()?;
        Some(full.weights.change(&with, &self.plain))
    }
}

/// A way to search.
#[derive(Debug, Clone, Copy)]
enum Way {
    Lag,
    Mass,
    DeadTime,
    /// What the lag loses the dead time gains: the valley that all of them leave, as the whole delay is what readings show best.
    LagToDeadTime,
}

impl Way {
    const ALL: [Self; 4] = [Self::Lag, Self::Mass, Self::DeadTime, Self::LagToDeadTime];

    fn step(self, [lag, share, dead]: Dynamics, [of_lag, of_share, of_dead]: Dynamics, sign: f64) -> Dynamics {
        let moved = match self {
            Self::Lag => [sign.mul_add(of_lag, lag), share, dead],
            Self::Mass => [lag, sign.mul_add(of_share, share), dead],
            Self::DeadTime => [lag, share, sign.mul_add(of_dead, dead)],
            Self::LagToDeadTime => {
                let shorter = sign.mul_add(-of_lag, lag);
                [shorter, share, dead + lag.exp() - shorter.exp()]
            }
        };
        std::array::from_fn(|one| moved[one].clamp(BOUNDS[one].0, BOUNDS[one].1))
    }
}

/// The search for how one part follows, the others as a rig has them.
struct Search<'s, F> {
    fall: &'s F,
    /// Around whose lag is searched.
    stated: &'s Rig,
    rig: &'s Rig,
    follower: Follower,
    open: Open,
}

impl<F: Fn(&Rig) -> Option<f64> + Sync> Search<'_, F> {
    /// The rig with other dynamics of this part; `None` where its card does not know them.
    fn with(&self, [lag, share, dead]: Dynamics) -> Option<Rig> {
        let mut other = self.rig.clone();
        let stated = self.stated.parameters[self.follower.lag].value;
        other.parameters[self.follower.lag].value = stated * lag.exp();
        other.parameters[self.follower.inertia_time?].value = stated * lag.exp() * share.sqrt();
        other.parameters[self.follower.dead_time?].value = stated * dead;
        Some(other)
    }

    /// The rig with each of the dynamics otherwise, the others as they are: where no sum of what these change explains anything of a
    /// record, the spool does not stand out in it.
    fn probes(&self) -> Option<Vec<Rig>> {
        let at = self.of(self.rig)?;
        let farthest = |of: usize| {
            let [low, high] = [BOUNDS[of].0, BOUNDS[of].1];
            let other = if at[of] < 0.5 * (low + high) { high } else { low };
            std::array::from_fn(|one| if one == of { 0.5 * (at[of] + other) } else { at[one] })
        };
        let asked = if self.is_lag_open() { 0..DYNAMICS } else { 1..DYNAMICS };
        asked.map(|of| self.with(farthest(of))).collect()
    }

    /// Where the search begins for a spool that is still as stated: that, and what others do.
    fn grid(&self) -> Vec<Dynamics> {
        let lags: &[f64] = if self.is_lag_open() { &LAGS } else { &[0.0] };
        let grid = lags.iter().flat_map(|&lag| SHARES.map(|share| DEAD_TIMES.map(|dead| [lag, share, dead])));
        grid.flatten().chain(self.of(self.stated).filter(|&[_, share, dead]| share + dead > 0.0)).collect()
    }

    /// Those of the rig at hand, where they are not the stated ones.
    fn at_hand(&self) -> Option<Dynamics> {
        let at_hand = self.of(self.rig)?;
        (Some(at_hand) != self.of(self.stated)).then_some(at_hand)
    }

    /// Those of a rig.
    fn of(&self, rig: &Rig) -> Option<Dynamics> {
        let own = [self.follower.lag, self.follower.inertia_time?, self.follower.dead_time?];
        let [lag, inertia_time, dead_time] = own.map(|own| rig.parameters[own].value);
        let stated = self.stated.parameters[self.follower.lag].value;
        Some([(lag / stated).ln(), (inertia_time / lag).powi(2), dead_time / stated])
    }

    /// Whether the lag may be another than stated: it is asked about, and neither exact nor estimated itself.
    fn is_lag_open(&self) -> bool {
        let lag = &self.stated.parameters[self.follower.lag];
        self.open == Open::All && lag.varies() && !self.stated.is_fault(self.follower.lag)
    }

    /// The dynamics with which the cost falls most, and by how much; `None` where nothing is worth a search.
    fn best(&self) -> Option<(Dynamics, f64)> {
        let ways: &[Way] = if self.is_lag_open() { &Way::ALL } else { &[Way::Mass, Way::DeadTime] };
        let around = |&best: &Dynamics, share: f64| -> Vec<Dynamics> {
            let steps = STEPS.map(|step| share * step);
            ways.iter().flat_map(|way| [-1.0, 1.0].map(|sign| way.step(best, steps, sign))).collect()
        };
        let begin = match self.at_hand() {
            Some(at_hand) => vec![at_hand],
            // A lag that is off by less than half of the grid's step is worse at every point of it, and one by less than half of a step
            // at every first step.
            None => {
                let stated = self.of(self.stated)?;
                self.grid().into_iter().chain(around(&stated, 1.0)).chain(around(&stated, SMALL)).collect()
            }
        };
        let cost = |&dynamics: &Dynamics| (self.fall)(&self.with(dynamics)?).map(|fall| -fall);
        let start = least(begin, &cost)?;
        // Where nothing around the stated spool does better, the search has nowhere to go.
        if start.1 >= 0.0 && self.at_hand().is_none() {
            return None;
        }
        let (best, cost) = pattern_search(start, patience(self.stated), around, cost);
        (cost < 0.0).then_some((best, -cost))
    }
}
