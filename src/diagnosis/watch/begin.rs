//! Where in a window the circuit can be started: what the sensors show while it stands or runs straight.

use crate::complaint::Complaint;
use crate::diagnosis::DiagnosisOptions;
use crate::model::Shown;
use crate::record::Record;
use crate::residual::{Shows, straight};
use crate::rig::{NodeKind, Quantity, Rig, Target};

/// How many rows there are up to the end of the first stretch in which every sensor of a node runs straight, and what these
/// show there; a stretch at rest in the first half is preferred. `None` where there is no such stretch.
///
/// # Errors
/// A column that the record lacks or has in another dimension.
pub(super) fn begin(
    rig: &Rig,
    record: &Record,
    options: &DiagnosisOptions,
) -> Result<Option<(usize, Vec<Shown>)>, Complaint> {
    let sensors = sensors(rig, record);
    let stretches = straight(rig, record, &sensors, options.detection.window)?;
    let still =
        |shows: &Shows| shows.rate.abs() <= rig.settings().diagnosis.standing_deviations * shows.rate_variance.sqrt();
    let half = record.time.len() / 2;
    let rests = stretches.iter().find(|stretch| stretch.end < half && stretch.shows.iter().all(still));
    let Some(stretch) = rests.or_else(|| stretches.first().filter(|stretch| stretch.end < half)) else {
        return Ok(None);
    };
    let shown = sensors.iter().zip(&stretch.shows).map(|(&sensor, shows)| {
        let (late, moving) = (stretch.to - stretch.middle, !still(shows));
        let ahead = if moving { late } else { 0.0 };
        Shown {
            sensor,
            value: shows.value + ahead * shows.rate,
            sigma: (shows.variance + ahead * ahead * shows.rate_variance).sqrt(),
            rate: if moving { shows.rate } else { 0.0 },
        }
    });
    Ok(Some((stretch.end, shown.collect())))
}

/// One sensor of each node whose start it can tell, the first that shows something.
fn sensors(rig: &Rig, record: &Record) -> Vec<usize> {
    let mut found: Vec<usize> = Vec::new();
    for (index, sensor) in rig.sensors.iter().enumerate() {
        let Target::Node(node) = sensor.target else { continue };
        let tells = match rig.nodes[node].kind {
            NodeKind::Volume { .. } => matches!(sensor.quantity, Quantity::Pressure | Quantity::Level),
            NodeKind::Body { .. } => sensor.quantity == Quantity::Position,
            NodeKind::Held { .. } => false,
        };
        let shows = record.channel(&sensor.column).is_none_or(|channel| !channel.is_empty());
        if tells && shows && !found.iter().any(|&other| rig.sensors[other].target == sensor.target) {
            found.push(index);
        }
    }
    found
}
