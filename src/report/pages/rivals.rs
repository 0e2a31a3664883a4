//! Effects that explain a record alike, and where they would part.

use super::channels::Shown;
use crate::learn::evaluated::EvaluatedModel;
use crate::learn::suggest::Suggestion;
use crate::number::{rounded, text};
use crate::report::html::{Column, Section, Table};

/// Where two models differ most.
struct Parting {
    sensor: String,
    phase: String,
    from_s: f64,
    to_s: f64,
    /// Root mean square over that phase, in standard deviations of a sample.
    size: f64,
}

/// The confounded pairs, each with the phase and the sensor in which its two models differ most; `None` without any.
pub(super) fn section(shown: &Shown<'_>, found: &Suggestion) -> Option<Section> {
    let mut rows = Vec::new();
    for (place, a) in found.judged.iter().enumerate().filter(|(_, one)| one.supported) {
        for b in found.judged[place + 1..].iter().filter(|b| a.confounded_with.contains(&b.id())) {
            let parting = parting(shown, a, b);
            let at = parting.as_ref().map_or("-".to_owned(), |at| {
                format!("{} from {} to {} s", at.phase, text(rounded(at.from_s, 4)), text(rounded(at.to_s, 4)))
            });
            let size = parting.as_ref().map_or("-".to_owned(), |at| text(rounded(at.size, 2)));
            let sensor = parting.map_or("-".to_owned(), |at| at.sensor);
            rows.push([a.id(), b.id(), at, sensor, size].map(Into::into).to_vec());
        }
    }
    if rows.is_empty() {
        return None;
    }
    let mut section = Section::new("Confounded");
    section.paragraph(
        "These explain the record equally well. The table says where their fitted models differ most in this record; the experiment that \
         would separate the best two stands under the verdict.",
    );
    let columns = vec![
        Column::text("effect"),
        Column::text("or"),
        Column::text("they differ most in the phase"),
        Column::text("sensor"),
        Column::number("difference", "of a sample's deviation"),
    ];
    section.table(Table::new("Pairs that this record cannot separate", columns, rows));
    Some(section)
}

fn parting(shown: &Shown<'_>, a: &EvaluatedModel, b: &EvaluatedModel) -> Option<Parting> {
    let outputs = |one: &EvaluatedModel| one.trial.fit.outputs.concat();
    let mut change: Vec<f64> = outputs(a).iter().zip(outputs(b)).map(|(a, b)| a - b).collect();
    a.trial.fit.weights.apply(&mut change);
    let sensors = change.chunks(shown.record.time.len().max(1)).zip(&shown.rig.sensors);
    let all = sensors.flat_map(|(change, sensor)| {
        shown.stretches.iter().filter(|stretch| !stretch.rows.is_empty()).map(move |stretch| {
            let part = &change[stretch.rows.clone()];
            let size = (part.iter().map(|c| c * c).sum::<f64>() / part.len() as f64).sqrt();
            let (from_s, to_s) = shown.ends(stretch);
            Parting { sensor: sensor.name.clone(), phase: stretch.name.clone(), from_s, to_s, size }
        })
    });
    all.max_by(|a, b| a.size.total_cmp(&b.size))
}
