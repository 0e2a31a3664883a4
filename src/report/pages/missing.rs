//! The missing flow or force over the states, with its band.

use crate::complaint::Complaint;
use crate::learn::fitted_model::{FittedModel, Run};
use crate::learn::missing::{Missing, missing};
use crate::number::{rounded, text};
use crate::record::Record;
use crate::report::html::Section;
use crate::report::plot::{Axis, Chart, Envelope, Live, Rule, Series};

/// Places that are shown at most, and the share of the misfit that each has to explain.
const MOST: usize = 4;
const LEAST: f64 = 0.02;

/// What is missing beside a fitted model, beside what another model has more under its name.
///
/// # Errors
/// Columns that are missing, or a model that cannot be solved.
pub(super) fn section(
    base: &FittedModel,
    record: &Record,
    found: Option<(&str, &Run)>,
) -> Result<Option<Section>, Complaint> {
    let all = missing(base, record, found.map(|(_, run)| run))?;
    let shown: Vec<&Missing> =
        all.iter().filter(|one| one.explains >= LEAST && one.curve.len() > 1).take(MOST).collect();
    if shown.is_empty() {
        return Ok(None);
    }
    let mut section = Section::new("What is missing");
    section.paragraph(
        "The flow or the force that would explain the misfit if it acted at one place, over the state there, what explains most first; \
         estimated to first order beside everything that is fitted, the band is that of 95 %. A straight line through the origin is a \
         resistance, a step at standstill friction; zero all along is nothing missing. Flows and forces at several places may explain the \
         same misfit, and what fitted faults stand in for is not in it: look at the form, not at the size.",
    );
    if let Some((name, _)) = found {
        section.paragraph(format!("Dashed: the model {name}, seen in the same way."));
    }
    let charts: Vec<(Chart, Live)> = shown.into_iter().map(|one| chart(one, found.map(|(name, _)| name))).collect();
    section.side_by_side(&charts);
    Ok(Some(section))
}

fn chart(one: &Missing, found: Option<&str>) -> (Chart, Live) {
    let share = text(rounded(100.0 * one.explains, 2));
    let mut series = vec![
        Series::line(format!("missing, explains {share} %"), one.curve.iter().map(|at| (at.0, at.1)).collect())
            .styled(0, 0),
    ];
    series
        .extend(found.filter(|_| !one.found.is_empty()).map(|name| Series::line(name, one.found.clone()).styled(1, 1)));
    let x = Axis::new(&one.over.name, &one.over.unit);
    let title = format!("{} at {}", one.what.name, one.at);
    let mut chart = Chart::new(&title, x, Axis::new("", &one.what.unit), series).high(190.0);
    let points = one.curve.iter().map(|&(x, y, half)| (x, y - half, y + half)).collect();
    chart.envelopes.push(Envelope { name: "95 %".to_owned(), points, colour: 0 });
    chart.rules.push(Rule::Horizontal { y: 0.0, label: String::new() });
    let told = format!("{title} versus {}: explains {share} % of the misfit", one.over.name);
    (chart, Live::new("", told))
}
