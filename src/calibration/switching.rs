//! How spools follow their commands, as healthy records together show it.
//!
//! The weights of events forgive what mass and dead time of a spool do, and values that a record tells by its transients, such as the
//! bulk modulus, would take their place. Other dynamics are therefore asked for by the [plain error](super::plain_error).

use super::first_fits::{FIRST, first_fits};
use super::joint::Solutions;
use super::plain_error::{Profile, missed_by};
use super::{open, taken};
use crate::diagnosis::switching::{self as spools, DYNAMICS, Open};
use crate::estimation::Gaussian;
use crate::estimation::criteria::bic;
use crate::model::Model;
use crate::rig::Rig;

/// The rig of the model with spools that follow as the records show, and the fit with them; `None` where they may be as stated, or the
/// model cannot be solved with others. They are believed where they take away most of what the model misses beyond noise.
pub(super) fn with_other_spools(solutions: &Solutions<'_>, prior: &Gaussian, theta: &[f64]) -> Option<(Rig, Vec<f64>)> {
    let stated = &solutions.model.rig;
    // The search costs a linearisation, which a rig without spools has no use for.
    stated.followers().find(|follower| stated.is_alone(follower))?;
    stated.context().stage("how spools follow");
    let missed = missed_by(stated, &solutions.errors(theta).ok()?);
    let found = followed(stated, (solutions, theta, missed), prior, stated.settings().calibration.dynamics_rounds)?;
    (found.missed < stated.settings().diagnosis.dynamics_left_share * missed).then_some((found.rig, found.theta))
}

/// A fit with other spools.
struct Found {
    rig: Rig,
    theta: Vec<f64>,
    /// Beyond noise.
    missed: f64,
}

/// From a fit and what it misses beyond noise: the best of so many rounds of search and fit.
fn followed(
    stated: &Rig,
    (solutions, theta, missed): (&Solutions<'_>, &[f64], f64),
    prior: &Gaussian,
    rounds: usize,
) -> Option<Found> {
    let rounds = rounds.checked_sub(1)?;
    let rig = searched(stated, solutions, prior, theta)?;
    let model = Model::new(rig);
    let taken = taken(&model.rig, solutions.records.iter().map(|one| one.record)).ok()?;
    let other = Solutions::new(&model, &taken, open(&model.rig));
    // Values that have bent to spools as stated may lead into another valley than those of the data sheet.
    let begun = [(theta, &[stated.settings().calibration.search_reach; 3][..]), (&prior.mean[..], &FIRST[..])];
    let fits = begun.into_iter().filter_map(|(start, reaches)| first_fits(&other, prior, start, reaches).ok());
    let (theta, _) = fits.min_by(|a, b| a.1.total_cmp(&b.1))?;
    let reached = missed_by(&model.rig, &other.errors(&theta).ok()?);
    if reached >= missed {
        return None;
    }
    let further = followed(stated, (&other, &theta, reached), prior, rounds);
    drop(other);
    Some(further.unwrap_or_else(|| Found { rig: model.rig, theta, missed: reached }))
}

/// The rig of the model with the spools with which it would miss the records by least; `None` where those that it has are as good.
fn searched(stated: &Rig, solutions: &Solutions<'_>, prior: &Gaussian, theta: &[f64]) -> Option<Rig> {
    let rig = &solutions.model.rig;
    let profile = Profile::at(solutions, prior, theta).ok()??;
    let fall = |other: &Rig| {
        let fall = profile.cost - profile.of(&profile.curves(other, theta)?);
        fall.is_finite().then_some(fall)
    };
    let excess = profile.cost - profile.samples;
    let worth = |gain: f64| {
        gain > stated.settings().diagnosis.dynamics_gain_share * excess && bic(-gain, DYNAMICS, profile.samples) < 0.0
    };
    Some(spools::searched(stated, rig, &fall, (|_: &[Rig]| true, worth), Open::All)?.0)
}
