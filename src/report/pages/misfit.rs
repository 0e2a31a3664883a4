//! The map of misfit: which sensor is missed, when.

use super::channels::Shown;
use crate::number::{rounded, text};
use crate::report::html::{Cell, Column, Section, Table};
use crate::report::plot::{self, Live, Map};

/// Error of a model that is right, times the noise, and that at which the map is darkest.
const RIGHT: f64 = 1.0;
const DARKEST: f64 = 30.0;

/// Adds the map over time of a model of this name, and the same by kind of phase as a table.
pub(super) fn add(section: &mut Section, shown: &Shown<'_>, outputs: &[Vec<f64>], name: &str) {
    let misfit = shown.misfits(outputs);
    let title = format!("Map of misfit, {name}: white 1x the noise, darkest 30x and more");
    let (map, live) = map(shown, &misfit, &title);
    section.map(&map, &live);
    by_phase(section, shown, &misfit, name);
}

/// Adds the maps of two models beside each other, and the second by kind of phase as a table.
pub(super) fn add_both(
    section: &mut Section,
    shown: &Shown<'_>,
    (before, after): (&[Vec<f64>], &[Vec<f64>]),
    names: (&str, &str),
) {
    let (before, after) = (shown.misfits(before), shown.misfits(after));
    section.paragraph("Each field is the error in one phase: white 1x the noise of the sensor, darkest 30x and more.");
    section.maps(&[map(shown, &before, names.0), map(shown, &after, names.1)]);
    by_phase(section, shown, &after, names.1);
}

fn map(shown: &Shown<'_>, misfit: &[Vec<f64>], title: &str) -> (Map, Live) {
    let sensors = &shown.rig.sensors;
    let mut cells = Vec::new();
    for (row, (sensor, misfit)) in sensors.iter().zip(misfit).enumerate() {
        for stretch in &shown.stretches {
            let Some(size) = misfit.get(stretch.rows.clone()).and_then(rms) else { continue };
            let (from, to) = shown.ends(stretch);
            let what = format!(
                "{}, {} from {} to {} s: {}x the noise",
                sensor.name,
                stretch.name,
                text(rounded(from, 4)),
                text(rounded(to, 4)),
                text(rounded(size, 3))
            );
            cells.push(plot::Cell { row, from, to, share: share(size), text: what });
        }
    }
    let rows = sensors.iter().map(|sensor| sensor.name.clone()).collect();
    let map = Map { title: title.to_owned(), x: shown.time(), rows, cells };
    (map, shown.live(format!("{title}: size of the misfit of each sensor over time")))
}

fn by_phase(section: &mut Section, shown: &Shown<'_>, misfit: &[Vec<f64>], name: &str) {
    let mut kinds: Vec<&str> = Vec::new();
    for stretch in &shown.stretches {
        if !kinds.contains(&stretch.name.as_str()) {
            kinds.push(&stretch.name);
        }
    }
    let row = |(sensor, misfit): (&crate::rig::Sensor, &Vec<f64>)| {
        let cell = |kind: &&str| {
            let of_kind = shown.stretches.iter().filter(|stretch| stretch.name == *kind);
            let parts = of_kind.filter_map(|stretch| misfit.get(stretch.rows.clone()));
            let all: Vec<f64> = parts.flatten().copied().collect();
            rms(&all).map_or(Cell::from("-"), |size| Cell::Shade(text(rounded(size, 3)), share(size)))
        };
        std::iter::once(Cell::from(sensor.name.clone())).chain(kinds.iter().map(cell)).collect()
    };
    let columns = std::iter::once(Column::text("sensor")).chain(kinds.iter().map(|kind| Column::text(*kind))).collect();
    let caption = format!("Misfit by phase, {name}, times the sensor noise; 1 is noise, - has no sample");
    section.table(Table::new(caption, columns, shown.rig.sensors.iter().zip(misfit).map(row).collect()));
}

/// Root mean square; `None` where nothing was measured.
fn rms(misfit: &[f64]) -> Option<f64> {
    let there = misfit.iter().filter(|size| size.is_finite());
    let count = there.clone().count();
    (count > 0).then(|| (there.map(|size| size * size).sum::<f64>() / count as f64).sqrt())
}

/// How dark a misfit is shown: equal ratios are equal steps.
fn share(size: f64) -> f64 {
    ((size / RIGHT).max(1.0).ln() / (DARKEST / RIGHT).ln()).min(1.0)
}
