//! The map of misfit: which sensor is missed, when.

use super::channels::Shown;
use crate::diagnosis::is_there;
use crate::number::{rounded, text};
use crate::report::html::{Cell, Column, Section, Table};
use crate::report::plot::{self, Map};

/// Mean size of a weighted misfit if the model is right, and where the map is darkest.
const RIGHT: f64 = 0.8;
const DARKEST: f64 = 30.0;

/// Adds the map over time, and the same by kind of phase as a table.
pub(super) fn add(section: &mut Section, shown: &Shown<'_>, misfit: &[&[f64]]) {
    let sensors = &shown.rig.sensors;
    let mut cells = Vec::new();
    for (row, (sensor, misfit)) in sensors.iter().zip(misfit).enumerate() {
        for stretch in &shown.stretches {
            let Some(size) = mean_size(&misfit[stretch.rows.clone()]) else { continue };
            let (from, to) = shown.ends(stretch);
            let what = format!(
                "{}, {} from {} to {} s: {} standard deviations",
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
    let map = Map { title: "Map of misfit".to_owned(), x: shown.time(), rows, cells };
    section.map(&map, &shown.live("size of the misfit of each sensor over time".to_owned()));

    let mut kinds: Vec<&str> = Vec::new();
    for stretch in &shown.stretches {
        if !kinds.contains(&stretch.name.as_str()) {
            kinds.push(&stretch.name);
        }
    }
    let row = |(sensor, misfit): (&crate::rig::Sensor, &&[f64])| {
        let cell = |kind: &&str| {
            let of_kind = shown.stretches.iter().filter(|stretch| stretch.name == *kind);
            let all: Vec<f64> = of_kind.flat_map(|stretch| misfit[stretch.rows.clone()].iter().copied()).collect();
            mean_size(&all).map_or(Cell::from("-"), |size| Cell::Shade(text(rounded(size, 3)), share(size)))
        };
        std::iter::once(Cell::from(sensor.name.clone())).chain(kinds.iter().map(cell)).collect()
    };
    let columns = std::iter::once(Column::text("sensor")).chain(kinds.iter().map(|kind| Column::text(*kind))).collect();
    let caption = "Mean size of the misfit in standard deviations of what noise and tolerance allow; 0.8 is right, - has no sample";
    section.table(Table::new(caption, columns, sensors.iter().zip(misfit).map(row).collect()));
}

/// `None` where the fit has no sample.
fn mean_size(misfit: &[f64]) -> Option<f64> {
    let there = misfit.iter().filter(|r| is_there(**r));
    let count = there.clone().count();
    (count > 0).then(|| there.map(|r| r.abs()).sum::<f64>() / count as f64)
}

/// How dark a misfit is shown: equal ratios are equal steps.
fn share(size: f64) -> f64 {
    ((size / RIGHT).max(1.0).ln() / (DARKEST / RIGHT).ln()).min(1.0)
}
