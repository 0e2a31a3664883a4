//! Samples that no fit should believe: they are set aside, and the diagnosis says which.

use crate::model::{InputSignals, Late};
use crate::record::Record;
use crate::record::survey::{Doubt, Finding, survey};
use crate::residual::settling;
use crate::rig::Rig;

/// What is doubtful about a record, its sensors being those of the rig and its commands switching the rig.
pub(crate) fn surveyed(rig: &Rig, record: &Record) -> Vec<Finding> {
    // A record that cannot drive the rig is surveyed for what keeps it from that; its columns then stand alone.
    let drive = InputSignals::inputs(rig, record, Late::default()).ok();
    let jumps: Vec<f64> =
        drive.iter().flat_map(|drive| &drive.pieces).filter(|one| one.jump).map(|one| one.start).collect();
    let settling = settling(rig);
    let own = |name: &str| rig.sensors.iter().find(|sensor| sensor.column == name);
    let switches = |time: f64| {
        let before = jumps.partition_point(|&jump| jump <= time).checked_sub(1).and_then(|last| jumps.get(last));
        before.is_some_and(|jump| time - jump <= settling)
    };
    survey(record, |channel| own(&channel.name).map(|sensor| sensor.scatter(channel)), switches)
}

/// Whether the rig has the end of a sensor's range among its effects: then its rest there says something.
fn models_saturation(rig: &Rig, finding: &Finding) -> bool {
    let sensor = rig.sensors.iter().find(|sensor| Some(&sensor.column) == finding.channel.as_ref());
    sensor.is_some_and(|sensor| {
        rig.effects.iter().any(|effect| effect.id == format!("sensor-saturation@{}", sensor.name))
    })
}

/// The record without the samples of dead, stuck and saturated sensors and without spikes, and everything that the fit does
/// not have: those, samples that were never there, and rows that are missing. `None` where nothing had to be set aside.
pub(crate) fn set_aside(rig: &Rig, record: &Record) -> (Option<Record>, Vec<Finding>) {
    let mut found = surveyed(rig, record);
    let removed =
        |finding: &&Finding| matches!(finding.doubt, Doubt::Dead | Doubt::Stuck | Doubt::Saturated | Doubt::Spike);
    let read = |finding: &Finding| finding.channel.as_deref().is_none_or(|name| rig.reads(name));
    found.retain(|finding| {
        let told = removed(&finding) || matches!(finding.doubt, Doubt::Dropout | Doubt::MissingRows);
        let at_its_end = matches!(finding.doubt, Doubt::Saturated | Doubt::Dead);
        told && read(finding) && !(at_its_end && models_saturation(rig, finding))
    });
    if !found.iter().any(|finding| removed(&finding)) {
        return (None, found);
    }
    let mut cleared = record.clone();
    for finding in found.iter().filter(removed) {
        let Some(name) = &finding.channel else { continue };
        let channel = cleared.channels.iter_mut().find(|channel| channel.name == *name);
        if let Some(channel) = channel {
            channel.values[finding.span.clone()].fill(f64::NAN);
        }
    }
    (Some(cleared), found)
}
