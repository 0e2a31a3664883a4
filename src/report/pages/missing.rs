//! What is missing, as a picture: the effect that was found taken out of the model and asked for back.

use super::channels::YOURS;
use crate::complaint::Complaint;
use crate::learn::fitted_model::{FittedModel, run_under};
use crate::learn::missing::{Missing, missing};
use crate::number::{rounded, text};
use crate::record::Record;
use crate::report::html::Section;
use crate::report::plot::{Axis, Chart, Envelope, Live, Rule, Series};
use crate::rig::InstalledEffect;

/// Places that are shown at most, and the share of the misfit that each has to explain.
const MOST: usize = 4;
const LEAST: f64 = 0.1;
/// Share by which an effect is weakened.
const WEAKER: f64 = 0.05;
/// Dots of a picture.
const DOTS: usize = 1_500;
/// Pieces of an axis within which a change that depends on it alone is one value.
const PIECES: usize = 40;

/// What a law does, by which the curve without a formula is chosen that could take its place.
const LAWS: [(&str, &[&str]); 5] = [
    ("orifice-leakage", &["conductance from A to B", "flow to the tank"]),
    ("position-dependent-clearance", &["conductance from A to B"]),
    ("leakage", &["flow to the tank", "conductance from A to B"]),
    ("friction", &["force against the motion", "friction"]),
    ("load", &["force against the rod"]),
];

/// What is missing: of a model with effects that were found the same without them, of one without what its misfit asks for.
///
/// # Errors
/// Columns that are missing, or a model that cannot be solved.
pub(super) fn section(
    base: &FittedModel,
    record: &Record,
    found: Option<(&str, &FittedModel)>,
) -> Result<Option<Section>, Complaint> {
    let Some((name, found)) = found else { return without_effect(base, record) };
    let new: Vec<&InstalledEffect> =
        found.rig.effects.iter().filter(|effect| base.rig.effects.iter().all(|old| old.id != effect.id)).collect();
    // A model that cannot be solved without the effect has no picture.
    let Ok(without) = taken_out(base, found, &new, record) else { return Ok(None) };
    let weaker = weakened(found, &base.rig.nominal(), &new, record);
    let weak = weaker.is_some();
    let all = match weaker {
        // The curve of the record is what the law was weakened by, and what the record asks for beside it.
        Some(weak) => missing(&weak, record, Some(&found.fit))?.into_iter().map(whole).collect::<Vec<_>>(),
        None => missing(&without, record, Some(&found.fit))?,
    };
    let is_of_verdict = |one: &&Missing| new.iter().any(|effect| is_at(effect, one));
    let first: Vec<&Missing> = all.iter().filter(is_of_verdict).filter(|one| one.curve.len() > 1).collect();
    let most = first.iter().map(|one| one.explains).fold(0.0, f64::max);
    let first: Vec<&Missing> = first.into_iter().filter(|one| one.explains >= 0.5 * most).take(MOST).collect();
    let charts: Vec<(Chart, Live)> = first.iter().map(|one| chart(one, Some(name), weak)).collect();
    // A law that no curve stands for is shown by what it changes.
    let law = if charts.is_empty() { law(&without, found, record) } else { None };
    if charts.is_empty() && law.is_none() {
        return Ok(None);
    }
    let mut section = Section::new("What is missing");
    section.paragraph(format!(
        "The model that was found, with {name} taken out of it and everything else as it was fitted: what the record asks for in its \
         place. {}",
        if charts.is_empty() { CHANGES } else { CURVES }
    ));
    let charts: Vec<(Chart, Live)> = charts.into_iter().chain(law).collect();
    section.side_by_side(&charts);
    let others = all.iter().filter(|one| !is_of_verdict(one) && one.explains >= LEAST && one.curve.len() > 1);
    let others: Vec<(Chart, Live)> = others.take(MOST).map(|one| chart(one, Some(name), weak)).collect();
    if !others.is_empty() {
        let mut elsewhere = Section::new("");
        elsewhere.paragraph("Flows and forces at other places may explain a part of the same misfit.");
        elsewhere.side_by_side(&others);
        section.fold("What other places could explain", false, elsewhere);
    }
    Ok(Some(section))
}

/// What the misfit of a model asks for where no effect was found, what explains most first.
fn without_effect(base: &FittedModel, record: &Record) -> Result<Option<Section>, Complaint> {
    let all = missing(base, record, None)?;
    let shown: Vec<&Missing> =
        all.iter().filter(|one| one.explains >= LEAST && one.curve.len() > 1).take(MOST).collect();
    if shown.is_empty() {
        return Ok(None);
    }
    let mut section = Section::new("What is missing");
    section.paragraph(
        "The flow or the force that would explain the misfit if it acted at one place, versus the state there, what explains most first; \
         estimated to first order beside everything that is fitted, with its 95 % band. Nothing is drawn between states \
         where the record never stays. A straight line through the origin is a resistance, a step at standstill friction; zero all along is \
         nothing missing. What fitted faults stand in for is not in it: look at the form.",
    );
    let charts: Vec<(Chart, Live)> = shown.into_iter().map(|one| chart(one, None, false)).collect();
    section.side_by_side(&charts);
    Ok(Some(section))
}

/// The model that was found without its new effects, all other values as they are.
fn taken_out(
    base: &FittedModel,
    found: &FittedModel,
    new: &[&InstalledEffect],
    record: &Record,
) -> Result<FittedModel, Complaint> {
    let (rig, nominal) = (&base.rig, base.rig.nominal());
    // Parameters of effects stand behind all others, unless an effect changes one that was there before.
    let mut values: Vec<f64> = found.values.iter().copied().take(nominal.len()).collect();
    for &index in new.iter().flat_map(|effect| &effect.parameters).filter(|&&index| index < nominal.len()) {
        values[index] = nominal[index];
    }
    let fit = run_under(rig, record, &values, Some(&found.fit.weights))?;
    let sigmas = found.sigmas.iter().filter(|(index, _)| **index < nominal.len());
    let sigmas = sigmas.map(|(index, sigma)| (*index, *sigma)).collect();
    Ok(FittedModel { values, sigmas, set: found.set, at_bound: Vec::new(), fit, ..base.clone() })
}

/// The model that was found with its new effects a little weaker: so little that the record answers in proportion, which it
/// does not where an effect is missing whole. `None` of a curve, whose place another curve cannot take twice. `nominal` are the values
/// of the model without them: a parameter that the circuit has anyway, such as the friction of a cylinder, does nothing new there.
fn weakened(found: &FittedModel, nominal: &[f64], new: &[&InstalledEffect], record: &Record) -> Option<FittedModel> {
    let mut rig = found.rig.clone();
    let mut values = found.values.clone();
    for effect in new {
        let placed = &effect.placed;
        if placed.effect.empirical {
            return None;
        }
        // Where some parameters have a value that does nothing, the others are its form.
        let sized = placed.effect.parameters.iter().any(|free| free.neutral.is_some());
        for (&index, free) in effect.parameters.iter().zip(placed.effect.parameters) {
            let neutral = free.neutral.map(|neutral| rig.effect_unit(placed, free.name).to_si(neutral));
            let before = nominal.get(index).copied().filter(|_| neutral.is_some() || !sized);
            if let Some(nothing) = before.or(neutral) {
                values[index] += WEAKER * (nothing - values[index]);
            }
            // It stays as weak: only the curve may make up for it.
            rig.parameters[index].sigma = 0.0;
        }
    }
    let fit = run_under(&rig, record, &values, Some(&found.fit.weights)).ok()?;
    Some(FittedModel { rig, values, fit, ..found.clone() })
}

/// The law as it is, and what the record asks for, from those of a model that has most of the law.
fn whole(mut one: Missing) -> Missing {
    for (asked, law) in one.curve.iter_mut().zip(&mut one.found) {
        asked.1 += law.1 * (1.0 / WEAKER - 1.0);
        law.1 /= WEAKER;
    }
    one
}

/// What two kinds of pictures show.
const CURVES: &str = "Line and 95 % band: from the record, as a curve without a formula, drawn where the record stays long enough to show it. Dashed: the law that was found.";
const CHANGES: &str = "No curve stands for such a law, so the picture shows what it changes, versus the reading on which the change depends most.";

/// Whether a curve without a formula could take the place of an effect: what it does, at its place.
fn is_at(effect: &InstalledEffect, missing: &Missing) -> bool {
    let (kind, place) = effect.id.split_once('@').unwrap_or((&effect.id, ""));
    let same = LAWS
        .iter()
        .find(|(law, _)| kind.contains(law))
        .is_some_and(|(_, what)| what.contains(&missing.what.name.as_str()));
    same && (place.is_empty() || place == missing.at)
}

/// What the effects change at the sensor that shows them most, versus the reading that the change depends on most.
fn law(without: &FittedModel, found: &FittedModel, record: &Record) -> Option<(Chart, Live)> {
    let rig = &without.rig;
    let (before, after) = (&without.fit.outputs, &found.fit.outputs);
    let change = |index: usize| -> Vec<f64> { after[index].iter().zip(&before[index]).map(|(a, b)| a - b).collect() };
    let size = |index: usize| {
        let squares: f64 = change(index).iter().filter(|one| one.is_finite()).map(|one| one * one).sum();
        squares / rig.sensors[index].stated_noise.powi(2)
    };
    let sensors = 0..before.len().min(after.len()).min(rig.sensors.len());
    let index = sensors.clone().max_by(|&a, &b| size(a).total_cmp(&size(b)))?;
    let changed = change(index);
    // A single sensor is shown versus itself.
    let over = sensors
        .clone()
        .filter(|&other| other != index || sensors.len() == 1)
        .max_by(|&a, &b| determined(&after[a], &changed).total_cmp(&determined(&after[b], &changed)))?;
    let (sensor, state) = (&rig.sensors[index], &rig.sensors[over]);
    let (unit, x_unit) = (rig.sensor_unit(sensor), rig.sensor_unit(state));
    let measured = record.channel(&sensor.column)?;
    let step = record.time.len().div_ceil(DOTS).max(1);
    let rows = || (0..record.time.len().min(changed.len())).step_by(step);
    let at = |row: usize| x_unit.from_si(after[over][row]);
    let asked = rows().map(|row| (at(row), unit.difference_from_si(measured.values[row] - before[index][row])));
    let law = rows().map(|row| (at(row), unit.difference_from_si(changed[row])));
    let finite = |point: &(f64, f64)| point.0.is_finite() && point.1.is_finite();
    let series = vec![
        Series::dots("measured minus model without it", asked.filter(finite).collect()).styled(3, 0),
        Series::dots("what it changes, as fitted", law.filter(finite).collect()).styled(1, 0),
    ];
    let title = format!("change of {}", sensor.name);
    let axis = Axis::new(&state.name, &x_unit.symbol);
    let mut chart = Chart::new(&title, axis, Axis::new("", &unit.symbol), series).high(190.0);
    chart.rules.push(Rule::Horizontal { y: 0.0, label: String::new() });
    Some((chart, Live::new("", format!("{title} by what is missing, versus {}", state.name))))
}

/// Share of the variance of a change that a state determines, piece by piece of its range.
fn determined(state: &[f64], change: &[f64]) -> f64 {
    let pairs: Vec<(f64, f64)> =
        state.iter().copied().zip(change.iter().copied()).filter(|(x, y)| x.is_finite() && y.is_finite()).collect();
    let low = pairs.iter().map(|pair| pair.0).fold(f64::INFINITY, f64::min);
    let high = pairs.iter().map(|pair| pair.0).fold(f64::NEG_INFINITY, f64::max);
    if high <= low {
        return 0.0;
    }
    let mut pieces = vec![(0.0, 0.0, 0.0); PIECES];
    for (x, y) in &pairs {
        let piece = (((x - low) / (high - low) * PIECES as f64) as usize).min(PIECES - 1);
        let (count, sum, squares) = &mut pieces[piece];
        (*count, *sum, *squares) = (*count + 1.0, *sum + y, *squares + y * y);
    }
    let mean = pairs.iter().map(|pair| pair.1).sum::<f64>() / pairs.len() as f64;
    let all: f64 = pairs.iter().map(|pair| (pair.1 - mean).powi(2)).sum();
    let within: f64 =
        pieces.iter().filter(|piece| piece.0 > 0.0).map(|(n, sum, squares)| squares - sum * sum / n).sum();
    if all > 0.0 { 1.0 - within / all } else { 0.0 }
}

fn chart(one: &Missing, found: Option<&str>, weak: bool) -> (Chart, Live) {
    // Beside most of the law its share says nothing.
    let share = if weak { String::new() } else { format!(", explains {} %", text(rounded(100.0 * one.explains, 2))) };
    let mut series = vec![
        Series::line(format!("asked for by the record{share}"), one.curve.iter().map(|at| (at.0, at.1)).collect())
            .styled(YOURS.0, 0),
    ];
    series.extend(
        found
            .filter(|_| !one.found.is_empty())
            .map(|name| Series::line(format!("with {name}"), one.found.clone()).styled(1, 1)),
    );
    let x = Axis::new(&one.over.name, &one.over.unit);
    let title = format!("{} at {}", one.what.name, one.at);
    let mut chart = Chart::new(&title, x, Axis::new("", &one.what.unit), series).high(190.0);
    let points = one.curve.iter().map(|&(x, y, half)| (x, y - half, y + half)).collect();
    chart.envelopes.push(Envelope { name: "95 %".to_owned(), points, colour: YOURS.0 });
    chart.rules.push(Rule::Horizontal { y: 0.0, label: String::new() });
    let told = format!("{title} versus {}{share}", one.over.name);
    (chart, Live::new("", told))
}
