//! Other valleys of the plain error.
//!
//! A mass that rings on a stiff line does so at a frequency of its own. With a stiffness by which the model is half a period off before the
//! ring has died, no derivative leads to the right one, and weights that forgive a shift in time where a curve is steep see nothing
//! wrong. So where the model stays far from the records, each value is tried elsewhere, everything else following along its derivatives.

use rayon::prelude::*;

use super::first_fits::{FIRST, first_fits};
use super::joint::Solutions;
use super::plain_error::Profile;
use crate::estimation::criteria::bic;
use crate::estimation::{FitError, Gaussian};

/// Plain error, as a square over that of the noise, from which on another valley is sought: three times the noise.
const FAR: f64 = 9.0;
/// How far from what was known before a value is tried, in standard deviations.
const REACH: f64 = 2.0;
/// The least step, in the same: steps are as long as it takes to change the curves by what is missed, which is the width of a valley.
const LEAST_STEP: f64 = 0.1;
/// Valleys that are gone to, one after the other.
const MOST: usize = 3;

/// A fit and its cost, or those that a start in another valley leads to where their plain error is less.
pub(super) fn lowest(
    solutions: &Solutions<'_>,
    prior: &Gaussian,
    (mut theta, mut cost): (Vec<f64>, f64),
) -> Result<(Vec<f64>, f64), FitError> {
    let mut here = Profile::at(solutions, prior, &theta)?;
    for _ in 0..MOST {
        let Some((profile, start)) = here.as_ref().and_then(|here| Some((here, start(here, prior, &theta)?))) else {
            break;
        };
        // The widest boxes of the first fits: narrow ones hold what was known before.
        let (next, next_cost) = first_fits(solutions, prior, &start, &FIRST[FIRST.len() - 3..])?;
        let there = Profile::at(solutions, prior, &next)?;
        if there.as_ref().is_none_or(|there| there.cost >= profile.cost) {
            break;
        }
        (theta, cost, here) = (next, next_cost, there);
    }
    Ok((theta, cost))
}

/// Where another valley begins: one value elsewhere and everything else after it; `None` where the model follows the records, and where
/// nothing is less.
fn start(here: &Profile<'_, '_>, prior: &Gaussian, theta: &[f64]) -> Option<Vec<f64>> {
    if here.cost < FAR * here.samples {
        return None;
    }
    here.solutions.model.rig.context().stage("other valleys");
    let values = |index: usize| {
        let (mean, sigma, (low, high)) =
            (prior.mean[index], prior.sigma[index], here.solutions.estimated[index].bounds);
        let step = (here.cost.sqrt() / here.size(index)).max(LEAST_STEP);
        let steps = (REACH / step) as i32;
        let one = move |k: i32| (index, (mean + f64::from(k) * step * sigma).clamp(low, high));
        (-steps..=steps).map(one)
    };
    let tried: Vec<(usize, f64)> = here.solutions.of_machine().flat_map(values).collect();
    let one = |(index, value)| here.held(index, value, theta, prior).filter(|(cost, _)| cost.is_finite());
    let found = tried.into_par_iter().filter_map(one).min_by(|a, b| a.0.total_cmp(&b.0));
    found.filter(|(cost, _)| bic(cost - here.cost, 1, here.samples) < 0.0).map(|(_, start)| start)
}
