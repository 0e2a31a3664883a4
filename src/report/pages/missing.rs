//! What is missing, as a picture: the effect that was found taken out of the model and asked for back.

use super::channels::YOURS;
use crate::complaint::Complaint;
use crate::learn::acting::{Acting, Ports, determined};
use crate::learn::fitted_model::{FittedModel, run_under};
use crate::learn::law_on_axis::Found;
use crate::learn::missing::{Missing, missing};
use crate::model::InputSignals;
use crate::number::{rounded, text};
use crate::physics::ATMOSPHERE;
use crate::physics::card::PortKind;
use crate::physics::effect::Form;
use crate::record::Record;
use crate::report::html::Section;
use crate::report::plot::{Axis, Chart, Envelope, Live, Rule, Series};
use crate::rig::{InstalledEffect, Quantity};
use crate::units::Unit;

/// Places that are shown at most, and the share of the misfit that each has to explain.
const MOST: usize = 4;
const LEAST: f64 = 0.1;
/// Share by which an effect is weakened.
const WEAKER: f64 = 0.05;
/// Dots of a picture.
const DOTS: usize = 1_500;
/// Shares of a law that two states determine are one within this: neighbouring samples of a law that bends differ by as much.
const AS_WELL: f64 = 0.01;

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
    let nominal = base.rig.nominal();
    let mut shown: Vec<(Chart, Live)> = Vec::new();
    let mut elsewhere: Vec<(Chart, Live)> = Vec::new();
    let mut curves = false;
    for &effect in &new {
        let weak = weakened(found, &nominal, effect, record);
        let lacking = if weak.is_some() { WEAKER } else { 1.0 };
        let asked = weak.as_ref().unwrap_or(&without);
        let all = missing(asked, record, Some(Found { model: found, effect, nominal: &nominal, lacking }))?;
        let draw = |one: &Missing| chart(one, Some(&effect.id), weak.is_some());
        let best = all.iter().filter_map(|one| one.stands_for_law).fold(0.0, f64::max);
        let alone = law_alone(found, &nominal, effect, record);
        // A law that no curve stands for, or that another state determines better, is shown over that, and by what it changes.
        match alone.filter(|alone| alone.0 > best + AS_WELL) {
            Some((_, law)) => shown.push(law),
            None => {
                let stands = all.iter().filter(|one| one.stands_for_law.is_some_and(|share| share >= best - AS_WELL));
                let charts: Vec<(Chart, Live)> = stands.take(MOST).map(draw).collect();
                curves |= !charts.is_empty();
                shown.extend(charts);
            }
        }
        // Beside several effects each place would have a picture for each.
        if new.len() == 1 {
            let others = all.iter().filter(|one| one.stands_for_law.is_none() && one.explains >= LEAST);
            elsewhere.extend(others.take(MOST).map(draw));
        }
    }
    if !curves {
        shown.extend(changes(&without, found, record));
    }
    if shown.is_empty() {
        return Ok(None);
    }
    let mut section = Section::new("What is missing");
    section.paragraph(format!(
        "The model that was found, with {name} taken out of it and everything else as it was fitted: what the record asks for in its \
         place. {}",
        if curves { CURVES } else { CHANGES }
    ));
    section.side_by_side(&shown);
    if !elsewhere.is_empty() {
        let mut others = Section::new("");
        others.paragraph("Flows and forces at other places may explain a part of the same misfit.");
        others.side_by_side(&elsewhere);
        section.fold("What other places could explain", false, others);
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

/// The model that was found with one new effect a little weaker: so little that the record answers in proportion, which it
/// does not where an effect is missing whole. `None` of a curve, whose place another curve cannot take twice. `nominal` are the values
/// of the model without them: a parameter that the circuit has anyway, such as the friction of a cylinder, does nothing new there.
fn weakened(found: &FittedModel, nominal: &[f64], effect: &InstalledEffect, record: &Record) -> Option<FittedModel> {
    let mut rig = found.rig.clone();
    let mut values = found.values.clone();
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
    let fit = run_under(&rig, record, &values, Some(&found.fit.weights)).ok()?;
    Some(FittedModel { rig, values, fit, ..found.clone() })
}

/// What two kinds of pictures show.
const CURVES: &str = "Line and 95 % band: from the record, as a curve without a formula, drawn where the record stays long enough to show it. Dashed: the law that was found.";
const CHANGES: &str = "No curve without a formula stands for such a law, so the pictures show the law at the states of the record, and what it changes, versus the reading on which the change depends most.";

/// The flow, force or pressure drop of an effect at the states of the record, versus the one that determines it best, and the share of it
/// that this determines.
fn law_alone(
    found: &FittedModel,
    nominal: &[f64],
    effect: &InstalledEffect,
    record: &Record,
) -> Option<(f64, (Chart, Live))> {
    let rig = &found.rig;
    let acting = Acting::of(rig, &found.values, nominal, effect)?;
    let ports = Ports::of(rig, acting.component);
    let drive = InputSignals::from_record(rig, record).ok()?;
    let rows = ports.seen(rig, &found.values, (&drive, &record.time))?;
    let through = |port: usize| rows.iter().map(|row| acting.through(row, port)).collect::<Vec<f64>>();
    let name = |node: usize| rig.nodes[node].name.as_str();
    let (port, &(kind, node)) =
        ports.nodes.iter().enumerate().find(|(port, _)| through(*port).iter().any(|one| *one != 0.0))?;
    let adds = through(port);
    let variables = ports.variables();
    let state = |index: usize| rows.iter().map(|row| row.z[index]).collect::<Vec<f64>>();
    let [bar, flow, newton, mm, speed] = ["bar", "L/min", "N", "mm", "mm/s"].map(|unit| Unit::parse(unit).ok());
    let (x, y) = if matches!(effect.placed.effect.form, Form::Series { .. }) {
        let drop = rows.iter().map(|row| row.z[0] - row.z[1]).collect();
        ((format!("flow through {}", effect.id), adds, flow?), (format!("pressure drop of {}", effect.id), drop, bar?))
    } else {
        let axes = variables.iter().enumerate().map(|(index, &(node, quantity))| match quantity {
            Quantity::Pressure => Some((format!("pressure of {}", name(node)), state(index), bar.clone()?)),
            Quantity::Velocity => Some((format!("speed of {}", name(node)), state(index), speed.clone()?)),
            _ => Some((format!("position of {}", name(node)), state(index), mm.clone()?)),
        });
        let best = axes.flatten().max_by(|a, b| determined(&a.1, &adds).total_cmp(&determined(&b.1, &adds)))?;
        let what = match kind {
            PortKind::Hydraulic => (format!("flow out of {} by {}", name(node), effect.id), adds, flow?),
            PortKind::Mechanical => (format!("force on {} by {}", name(node), effect.id), adds, newton?),
        };
        (best, what)
    };
    let share = determined(&x.1, &y.1);
    let gauge = |(name, values, unit): &(String, Vec<f64>, Unit), row: usize| {
        let zero = if name.starts_with("pressure of") { ATMOSPHERE } else { 0.0 };
        unit.difference_from_si(values[row] - zero)
    };
    let step = rows.len().div_ceil(DOTS).max(1);
    let dots = (0..rows.len()).step_by(step).map(|row| (gauge(&x, row), gauge(&y, row)));
    let dots = dots.filter(|point| point.0.is_finite() && point.1.is_finite()).collect();
    let series = vec![Series::dots("law, as fitted", dots).styled(1, 0)];
    let (title, over) = (y.0, x.0);
    let mut chart = Chart::new(&title, Axis::new(&over, &x.2.symbol), Axis::new("", &y.2.symbol), series).high(190.0);
    chart.rules.push(Rule::Horizontal { y: 0.0, label: String::new() });
    Some((share, (chart, Live::new("", format!("{title} versus {over}")))))
}

/// What the effects change at the sensor that shows them most, versus the reading that the change depends on most.
fn changes(without: &FittedModel, found: &FittedModel, record: &Record) -> Option<(Chart, Live)> {
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
    let there = || changed.iter().copied().filter(|one| one.is_finite());
    let mean = there().sum::<f64>() / there().count().max(1) as f64;
    let about: Vec<f64> = changed.iter().map(|one| one - mean).collect();
    // A single sensor is shown versus itself.
    let over = sensors
        .clone()
        .filter(|&other| other != index || sensors.len() == 1)
        .max_by(|&a, &b| determined(&after[a], &about).total_cmp(&determined(&after[b], &about)))?;
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

fn chart(one: &Missing, found: Option<&str>, weak: bool) -> (Chart, Live) {
    // Beside most of the law its share says nothing.
    let share = if weak { String::new() } else { format!(", explains {} %", text(rounded(100.0 * one.explains, 2))) };
    let mut series = vec![
        Series::line(format!("asked for by the record{share}"), one.curve.iter().map(|at| (at.0, at.1)).collect())
            .styled(YOURS.0, 0),
    ];
    series.extend(found.filter(|_| !one.law.is_empty()).map(|name| {
        Series::line(
            format!("{} {name}", if one.stands_for_law.is_some() { "law of" } else { "with" }),
            one.law.clone(),
        )
        .styled(1, 1)
    }));
    let x = Axis::new(&one.over.name, &one.over.unit);
    let title = format!("{} at {}", one.what.name, one.at);
    let mut chart = Chart::new(&title, x, Axis::new("", &one.what.unit), series).high(190.0);
    let points = one.curve.iter().map(|&(x, y, half)| (x, y - half, y + half)).collect();
    chart.envelopes.push(Envelope { name: "95 %".to_owned(), points, colour: YOURS.0 });
    chart.rules.push(Rule::Horizontal { y: 0.0, label: String::new() });
    let told = format!("{title} versus {}{share}", one.over.name);
    (chart, Live::new("", told))
}
