//! The state as the page reads it.

use serde::Serialize;

use super::running::{Judged, Task};
use super::state::{Desk, Found, Note, Step};
use super::trace::{Gauges, Trace};
use crate::complaint::Complaint;
use crate::estimation::profile::QUANTILE;
use crate::learn::evaluated::Conclusion;
use crate::number::{before_unit, rounded};
use crate::report;
use crate::report::digits;
use crate::report::unknown::Rise;
use crate::rig::{EffectInstance, Location, Rig, Target};
use crate::units::Unit;

/// Digits of a number.
const DIGITS: usize = 7;

/// All that the page shows beside the curves.
#[derive(Serialize)]
pub struct State<'a> {
    revision: u64,
    rig: &'a str,
    file: String,
    fit: String,
    check: Option<String>,
    seconds: [f64; 2],
    circuit: String,
    sensors: Vec<SensorMessage<'a>>,
    parts: Vec<Part<'a>>,
    cards: Vec<Card<'a>>,
    library: Vec<Choice>,
    gauges: BothGauges,
    staircase: &'a [Step],
    running: Option<RunningMessage<'a>>,
    found: Option<FoundMessage>,
    judged: Option<JudgedMessage<'a>>,
    note: &'a Option<Note>,
    can_undo: bool,
}

/// The gauges of both records, without that of one that does not follow the sliders yet.
#[derive(Serialize)]
pub struct BothGauges {
    fit: Option<Gauges>,
    check: Option<Gauges>,
}

#[derive(Serialize)]
struct SensorMessage<'a> {
    name: &'a str,
    unit: String,
    noise: f64,
}

/// A component with what is of it.
#[derive(Serialize)]
struct Part<'a> {
    name: &'a str,
    meaning: &'static str,
    sensors: Vec<&'a str>,
    faults: Vec<&'a str>,
    effects: Vec<String>,
}

/// An effect or a fault, with its sliders.
#[derive(Serialize)]
struct Card<'a> {
    id: &'a str,
    fault: bool,
    on: bool,
    meaning: &'a str,
    sliders: Vec<Slider<'a>>,
}

#[derive(Serialize)]
struct Slider<'a> {
    id: &'a str,
    name: &'a str,
    value: f64,
    low: f64,
    high: f64,
    /// Empty of a number.
    unit: &'a str,
    /// 95 % by the last fit, or by the rig file.
    interval: Option<[f64; 2]>,
    /// The same in words, without an end that is a bound of the parameter.
    known: Option<String>,
}

/// An effect that may be added.
#[derive(Serialize)]
struct Choice {
    id: String,
    meaning: &'static str,
}

#[derive(Serialize)]
struct RunningMessage<'a> {
    task: Task,
    stage: &'a str,
    done: usize,
    of: Option<usize>,
}

#[derive(Serialize)]
struct FoundMessage {
    conclusion: Conclusion,
    headline: String,
    place: Option<String>,
    candidates: Vec<Candidate>,
    rise: Option<RiseMessage>,
}

/// What a curve without a formula says: a sentence, a formula for the rig file, and the curve.
#[derive(Serialize)]
struct RiseMessage {
    sentence: String,
    formula: String,
    points: Vec<(f64, f64)>,
}

#[derive(Serialize)]
struct Candidate {
    effect: String,
    supported: bool,
    before: f64,
    after: f64,
    check_before: Option<f64>,
    check_after: Option<f64>,
    warnings: Vec<String>,
}

#[derive(Serialize)]
struct JudgedMessage<'a> {
    headlines: Vec<String>,
    #[serde(flatten)]
    judged: &'a Judged,
}

impl Desk {
    /// # Errors
    /// Columns that are missing.
    pub(super) fn gauges(&self) -> Result<BothGauges, Complaint> {
        let gauges = |trace: &Trace| trace.current.then(|| trace.gauges(&self.rig)).transpose();
        Ok(BothGauges { fit: gauges(&self.fit)?, check: self.check.as_ref().map_or(Ok(None), gauges)? })
    }

    /// # Errors
    /// Columns that are missing.
    pub(super) fn message(&self) -> Result<State<'_>, Complaint> {
        let rig = &self.rig;
        let time = &self.fit.record.time;
        let file = |path: &std::path::Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let present = |id: &String| rig.effects.iter().any(|effect| effect.id == *id);
        let places = rig.effect_places().into_iter();
        let library = places.map(|placed| Choice { id: rig.effect_id(&placed), meaning: placed.effect.meaning });
        Ok(State {
            revision: self.revision,
            rig: &rig.name,
            file: file(&rig.path),
            fit: file(&self.fit.record.path),
            check: self.check.as_ref().map(|check| file(&check.record.path)),
            seconds: [time.first().copied().unwrap_or(0.0), time.last().copied().unwrap_or(0.0)],
            circuit: report::circuit::svg(rig, &[]),
            sensors: rig
                .sensors
                .iter()
                .map(|sensor| {
                    let unit = rig.sensor_unit(sensor);
                    let noise = rounded(unit.difference_from_si(sensor.stated_noise), DIGITS);
                    SensorMessage { name: &sensor.name, noise, unit: unit.symbol }
                })
                .collect(),
            parts: (0..rig.components.len()).map(|component| part(rig, component)).collect(),
            cards: self.cards(),
            library: library.filter(|choice| !present(&choice.id)).collect(),
            gauges: self.gauges()?,
            staircase: &self.staircase,
            running: self.running.as_ref().map(|running| RunningMessage {
                task: running.task,
                stage: &running.stage,
                done: running.done,
                of: running.of,
            }),
            found: self.found.as_ref().map(found_message),
            judged: self.judged.as_ref().map(|judged| JudgedMessage {
                headlines: std::iter::once(&judged.fit)
                    .chain(&judged.check)
                    .map(report::learn::comparison_headline)
                    .collect(),
                judged,
            }),
            note: &self.note,
            can_undo: self.can_undo(),
        })
    }

    fn cards(&self) -> Vec<Card<'_>> {
        let rig = &self.rig;
        let on = |id: &String| !self.sliders.off.contains(id);
        let effects = rig.effects.iter().map(|effect| {
            let sliders = effect.placed.effect.parameters.iter().zip(&effect.parameters).map(|(free, &index)| {
                let unit = rig.effect_unit(&effect.placed, free.name);
                let (low, high) = free.plausible;
                self.slider(index, (unit.difference_to_si(low), unit.difference_to_si(high)))
            });
            let meaning = effect.placed.effect.meaning;
            Card { id: &effect.id, fault: false, on: on(&effect.id), meaning, sliders: sliders.collect() }
        });
        let faults = rig.faults.iter().map(|fault| {
            let parameter = &rig.parameters[fault.parameter];
            let sliders = vec![self.slider(fault.parameter, fault.bounds)];
            Card { id: &parameter.id, fault: true, on: on(&parameter.id), meaning: &parameter.meaning, sliders }
        });
        effects.chain(faults).collect()
    }

    fn slider(&self, index: usize, (low, high): (f64, f64)) -> Slider<'_> {
        let parameter = &self.rig.parameters[index];
        let value = self.sliders.values[index];
        let shown = |unit: &Unit, si: f64| rounded(unit.from_si(si), DIGITS);
        // What a fit found beyond what is plausible is shown too.
        let (least, most) = (low.max(parameter.bounds.0).min(value), high.min(parameter.bounds.1).max(value));
        let fitted = self.sliders.sigmas.get(&index).copied();
        let moved = |effect: &crate::rig::InstalledEffect| {
            effect.parameters.contains(&index) && self.sliders.moved.contains(&effect.id)
        };
        let stated = (self.rig.is_of_effect(index) && !self.rig.effects.iter().any(moved)).then_some(parameter.sigma);
        let sigma = fitted.or(stated).filter(|sigma| *sigma > 0.0);
        let symbol = parameter.unit.symbol.as_str();
        let (lowest, highest) = parameter.bounds;
        let end = |side: f64, sigma: f64| value + side * QUANTILE * sigma;
        let known = |sigma: f64| {
            let bounded = |end: f64| (lowest < end && end < highest).then(|| parameter.unit.from_si(end));
            let ends = [-1.0, 1.0].map(|side| bounded(end(side, sigma)));
            let estimate = digits::Estimate { value: parameter.unit.from_si(value), ends };
            format!("95 %: {}", before_unit(estimate.interval(), symbol))
        };
        Slider {
            id: &parameter.id,
            name: parameter.id.rsplit_once('.').map_or(parameter.id.as_str(), |(_, name)| name),
            value: shown(&parameter.unit, value),
            low: shown(&parameter.unit, least),
            high: shown(&parameter.unit, most),
            unit: if symbol == "-" { "" } else { symbol },
            interval: sigma
                .map(|sigma| [-1.0, 1.0].map(|side| shown(&parameter.unit, end(side, sigma).clamp(lowest, highest)))),
            known: sigma.map(known),
        }
    }
}

fn part(rig: &Rig, component: usize) -> Part<'_> {
    let own = &rig.components[component];
    let here = |target: &Target| match *target {
        Target::Node(node) => own.ports.contains(&node),
        Target::Port(other, _) | Target::State(other, _) => other == component,
    };
    let sits = |placed: &EffectInstance| match placed.spot {
        Location::Component(other) => other == component,
        Location::Node(node) => own.ports.contains(&node),
        Location::Sensor(sensor) => here(&rig.sensors[sensor].target),
        Location::Fluid => false,
    };
    let of_sensor = |parameter: usize| {
        let offsets = |sensor: &&crate::rig::Sensor| {
            here(&sensor.target) && rig.parameters[parameter].id.starts_with(&format!("sensor.{}.", sensor.name))
        };
        rig.sensors.iter().any(|sensor| offsets(&sensor))
    };
    let faults = rig.faults.iter().map(|fault| fault.parameter).filter(|&at| own.owns(at) || of_sensor(at));
    Part {
        name: &own.name,
        meaning: own.card.meaning,
        sensors: rig.sensors.iter().filter(|sensor| here(&sensor.target)).map(|sensor| sensor.name.as_str()).collect(),
        faults: faults.map(|at| rig.parameters[at].id.as_str()).collect(),
        effects: rig.effect_places().iter().filter(|placed| sits(placed)).map(|placed| rig.effect_id(placed)).collect(),
    }
}

fn found_message(found: &Found) -> FoundMessage {
    let report = &found.report;
    let rise = Rise::of_suggestion(&found.suggestion);
    let candidates = report.candidates.iter().map(|one| Candidate {
        effect: one.effect.clone(),
        supported: one.supported,
        before: one.rmse_before,
        after: one.rmse_after,
        check_before: one.check_rmse_before,
        check_after: one.check_rmse_after,
        warnings: one.warnings.iter().map(ToString::to_string).collect(),
    });
    FoundMessage {
        conclusion: report.conclusion,
        headline: report::learn::conclusion(report),
        place: report::learn::missed(report),
        candidates: candidates.collect(),
        rise: rise.map(|rise| RiseMessage { sentence: rise.sentence(), formula: rise.formula(), points: rise.points }),
    }
}
