//! What explains a record: declared faults, as old as it or since a beginning within it, or something in their place.

use super::estimate::Estimate;
use super::{CLEARLY_ABOVE_NOISE, Diagnosed, Physics, onset, search};
use crate::complaint::Complaint;
use crate::model::Model;

/// What explains a record.
pub(super) enum Explained<'a> {
    /// Faults of the rig, as old as the record or since a beginning within it.
    Declared(Box<(Estimate<'a>, Option<onset::Begun>)>),
    /// A mistake in taking the record, or a value that is no declared fault.
    Otherwise(Box<Diagnosed>),
}

/// What explains a record in place of the declared faults.
pub(super) enum Instead {
    Nothing,
    /// A mistake in taking the record, or a value that is no declared fault.
    Found(Box<Diagnosed>),
    /// Physics that the model lacks.
    Physics,
}

/// What an attempt asks of a record.
#[derive(Clone, Copy)]
pub(super) struct Asked {
    /// Whether explanations are looked for everywhere: not where one that was is near.
    pub from_everywhere: bool,
    /// [`super::Attempt::asks_otherwise`].
    pub otherwise: bool,
    /// Whether a beginning is asked for again where the record is explained: the opposite of [`super::Attempt::is_as_old`].
    pub begun: bool,
}

/// The explanation by faults as old as the record, which a first one may miss, and the beginning within the record, if there is one, that
/// explains it better by a model with values before a beginning; or something else than declared faults, which is asked for first: where
/// no place leaves nothing, and where more than noise is left.
pub(super) fn best_explained<'a>(
    mut first: Estimate<'a>,
    before: &Model,
    (asked, physics): (Asked, Option<&dyn Physics>),
    otherwise: impl Fn(&Estimate<'_>, Option<&[search::Place]>, Option<&dyn Physics>) -> Result<Instead, Complaint>,
) -> Result<Explained<'a>, Complaint> {
    let (record, drive) = (first.case.record, first.case.full.drive);
    let settings = first.case.settings();
    let begun = |first: &Estimate<'_>| onset::find(before, record, (drive, !asked.begun), first);
    let (mut was_asked, mut known_places) = (false, Vec::new());
    let is_doubtful = !first.explains() || first.isolation.set().len() >= settings.several_faults;
    if asked.from_everywhere && (first.missed() || is_doubtful) {
        let places = first.places();
        let is_missed = first.missed() && !places.iter().any(|place| place.leaves_nothing(&first.case));
        let before = is_missed.then(|| first.explanation());
        first = first.best_from_places(&places, settings.isolation_rounds);
        // Places know nothing of what is uncertain beside the faults. What leaves nothing once that follows needs neither.
        if let Some(before) = before.filter(|_| !onset::is_believed(&first)) {
            let physics = physics.filter(|_| !first.explains());
            match if asked.otherwise { otherwise(&first, Some(&places), physics)? } else { Instead::Nothing } {
                Instead::Found(found) => return Ok(Explained::Otherwise(found)),
                Instead::Physics => return Ok(Explained::Declared(Box::new((first, None)))),
                Instead::Nothing => {}
            }
            let from_places = first.explained(before);
            if let Some(begun) = begun(&first) {
                return Ok(Explained::Declared(Box::new((first, Some(begun)))));
            }
            was_asked = true;
            first.explained(from_places);
        }
        known_places = places;
    }
    // A better explanation that is not believed either begins where the first one was asked for.
    let was_asked = was_asked || (!asked.begun && first.explains());
    let is_asked = !first.missed() && (!was_asked || onset::is_believed(&first));
    // Events, and values far from where they are expected, excuse much of what a mistake does to a record: one that leaves clearly less
    // without it, or needs no such values, is believed where it takes no more faults. So is one that explains a record which declared faults do
    // not, if it takes no more than these, or one.
    if asked.otherwise && !first.missed() {
        let (left, is_strained) = (first.times_noise(), first.case.is_strained(&first.isolation.best.theta));
        let is_unexplained = !first.explains();
        let is_better = |found: &Diagnosed| {
            let leaves_less = CLEARLY_ABOVE_NOISE * found.diagnosis.times_noise.max(1.0) < left;
            let is_plainer = is_strained && !found.diagnosis.is_strained() && found.diagnosis.times_noise <= left;
            let (faults, known) = (found.diagnosis.present().count(), first.isolation.set().len());
            let explains = is_unexplained && found.diagnosis.is_explained() && faults <= known.max(1);
            explains || ((leaves_less || is_plainer) && faults <= known)
        };
        // Values that nobody declared pull those that are uncertain to the ends of their search, and several faults with them. Without a
        // calibration it may be the data sheets, which are asked about once nothing else explains the record.
        let is_calibrated = first.case.rig().calibration.is_some();
        let places = (is_strained && is_calibrated && !was_asked).then_some(&known_places[..]);
        if (left > CLEARLY_ABOVE_NOISE || is_strained)
            && let Instead::Found(found) = otherwise(&first, places, None)?
            && is_better(&found)
        {
            return Ok(Explained::Otherwise(found));
        }
    }
    let begun = if is_asked { begun(&first) } else { None };
    Ok(Explained::Declared(Box::new((first, begun))))
}
