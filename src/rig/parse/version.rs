//! The version of the form in which a rig file is written.

use crate::complaint::{Complaint, Kind};
use crate::rig::source::Value;
use crate::units::Dimension;

/// The version that this program reads and writes; a file that says nothing is of it.
const VERSION: u32 = 1;

/// Refuses files of another version than this program knows.
pub(super) fn check(version: Option<Value<'_>>) -> Result<(), Complaint> {
    let Some(version) = version else { return Ok(()) };
    let stated = version.quantity(Dimension::NONE)?.value;
    if stated == f64::from(VERSION) {
        return Ok(());
    }
    let place = version.place();
    if stated > f64::from(VERSION) && stated.fract() == 0.0 {
        let what = format!("the rig file is of version {stated}, and this borescope reads version {VERSION}");
        return Err(Complaint::new(Kind::Bounds, what).at(place).help(
            "take a newer borescope, or write the file as docs/reference/rig-file.md has it, with `version = 1`",
        ));
    }
    Err(Complaint::new(Kind::Bounds, format!("there is no version {stated} of rig files"))
        .at(place)
        .help(format!("write `version = {VERSION}`, or leave the line away")))
}
