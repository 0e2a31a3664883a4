//! What every setting is worth: results with each of them halved and doubled, beside those with all of them as they are.

use std::collections::BTreeMap;

use borescope::internals::calibration::{CalibrationOptions, calibrate};
use borescope::internals::diagnosis::watch::Watching;
use borescope::internals::diagnosis::{Diagnosis, DiagnosisOptions};
use borescope::internals::isolability::isolability;
use borescope::internals::learn::add::add;
use borescope::internals::learn::behind::diagnose;
use borescope::internals::learn::compare::compare;
use borescope::internals::learn::improve::improve;
use borescope::internals::learn::missing::missing;
use borescope::internals::learn::suggest::suggest;
use borescope::internals::settings::{Setting, Settings};
use borescope::{Context, Model, Record, Rig};

use crate::support::cycle::Run;

const TELESCOPIC: &str = "fixtures/telescopic/rig.toml";
const TANKS: &str = "fixtures/two_tanks/rig.toml";
const PRESS: &str = "fixtures/press/rig.toml";

/// What a command says of a case: in words, in numbers with the half widths of their 95 % intervals, and what it took.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Said {
    words: String,
    numbers: BTreeMap<String, (f64, f64)>,
    effort: u64,
}

impl Said {
    fn number(&mut self, id: impl Into<String>, value: f64, half: f64) {
        if half > 0.0 && half.is_finite() {
            self.numbers.insert(id.into(), (value, half));
        }
    }

    /// Where the words differ: what `plain` says, and this.
    fn otherwise_than(&self, plain: &Self) -> String {
        let [before, after] = [plain, self].map(|one| one.words.split("; ").collect::<Vec<&str>>());
        if before.len() != after.len() {
            return format!("{} -> {}", plain.words, self.words);
        }
        let differ = before.iter().zip(&after).filter(|(before, after)| before != after);
        differ.map(|(before, after)| format!("{before} -> {after}")).collect::<Vec<String>>().join("; ")
    }

    /// Largest difference of a number, in half widths of what it is compared with.
    fn differs_by(&self, other: &Self) -> f64 {
        let shift = |(id, (value, half)): (&String, &(f64, f64))| {
            self.numbers.get(id).map(|(own, own_half)| ((own - value) / half).abs().max((own_half / half - 1.0).abs()))
        };
        other.numbers.iter().filter_map(shift).fold(0.0, f64::max)
    }
}

type Work = Box<dyn Fn(&Context) -> Said>;

/// A case: its name, the groups of settings that it can depend on, and what is done.
pub struct Case {
    pub name: &'static str,
    groups: &'static [&'static str],
    work: Work,
}

/// A rig with another text, in a context.
fn rig(path: &str, more: &str) -> Rig {
    let text = std::fs::read_to_string(path).unwrap();
    Rig::parse(path, text + more).unwrap()
}

/// The cycle of a rig with these faults, a row in so many.
fn cycle(rig: &Rig, faults: &[(&str, &str)], every: f64, seed: u64) -> Record {
    let model = Model::new(rig.clone());
    let mut cycle = rig.cycle.clone().unwrap();
    cycle.interval *= every;
    Run::of(&model).through(cycle).with_quantities(faults).seed(seed).record("cycle")
}

fn of_diagnosis(diagnosis: &Diagnosis, context: &Context) -> Said {
    let mut present: Vec<&str> = diagnosis.present().map(|fault| fault.id.as_str()).collect();
    present.sort_unstable();
    let mut words = vec![format!("{:?}", diagnosis.verdict).to_lowercase(), present.join(" + ")];
    words.extend(diagnosis.common_cause.as_ref().map(|cause| cause.kind.to_owned()));
    words.extend(diagnosis.missing_effect.as_ref().map(|missing| missing.effects.join(" + ")));
    words.extend(diagnosis.dynamics.iter().map(|one| one.id.clone()));
    words.extend(diagnosis.onset_s.map(|_| "with onset".to_owned()));
    words.extend(diagnosis.rival_effects.iter().map(|rival| format!("or {}", rival.effect)));
    words.retain(|word| !word.is_empty());
    let mut said = Said { words: words.join(", "), ..done(context) };
    for fault in &diagnosis.faults {
        if let [Some(low), Some(high)] = fault.ci95 {
            said.number(&fault.id, fault.value, 0.5 * (high - low));
        }
    }
    said
}

fn done(context: &Context) -> Said {
    let effort = context.effort();
    Said { effort: effort.simulations() + 10 * effort.linearisations(), ..Said::default() }
}

/// A diagnosis of one record by its rig.
fn diagnosed(name: &'static str, groups: &'static [&'static str], rig: Rig, record: Record) -> Case {
    let work = move |context: &Context| {
        let model = Model::new(rig.clone().with_context(context));
        let found = diagnose(&model, &record, &DiagnosisOptions::default()).unwrap();
        of_diagnosis(&found.diagnosis, context)
    };
    Case { name, groups, work: Box::new(work) }
}

fn telescopic(name: &'static str) -> Case {
    let record = Record::read(format!("fixtures/telescopic/{name}.csv")).unwrap();
    diagnosed(name, &["diagnosis"], rig(TELESCOPIC, ""), record)
}

/// The tanks as they are logged, with an effect that the rig file does not have.
fn hidden(effect: &str, every: f64) -> [Record; 2] {
    let plant = rig(TANKS, &format!("\n[effects]\n{effect}\n"));
    [3, 4].map(|seed| cycle(&plant, &[], every, seed))
}

/// A suggestion, with the missing quantity as a picture and the loop of additions.
fn learnt(name: &'static str, effect: &'static str) -> Case {
    let [fit, check] = hidden(effect, 4.0);
    let work = move |context: &Context| {
        let rig = rig(TANKS, "").with_context(context);
        let suggestion = suggest(&rig, &fit, Some(&check)).unwrap();
        let improvement = improve(&rig, &fit, &check, |_| ()).unwrap();
        let added: Vec<&str> = improvement.steps.iter().filter_map(|step| step.added.as_deref()).collect();
        let best = suggestion.judged.first();
        let mut said = done(context);
        said.words = format!(
            "{:?} {}; {:?} {}",
            suggestion.conclusion,
            best.map_or_else(String::new, |best| best.id()),
            improvement.conclusion,
            added.join(" + ")
        );
        for (index, sigma) in best.iter().flat_map(|best| &best.trial.sigmas) {
            let best = &suggestion.judged[0].trial;
            said.number(&best.rig.parameters[*index].id, best.values[*index], 1.96 * sigma);
        }
        for one in missing(&suggestion.base, &fit, None).unwrap() {
            let drawn: Vec<_> = one.curve.iter().filter(|point| point.1.is_finite()).collect();
            let middle = drawn[drawn.len() / 2];
            said.number(format!("{} of {}", one.what.name, one.at), middle.1, middle.2);
        }
        said
    };
    Case { name, groups: &["diagnosis", "learn"], work: Box::new(work) }
}

/// Where a model misses a record, in words, and the effect that is added to it without a record.
fn compared(name: &'static str, rig_file: &'static str, record: Record) -> Case {
    let work = move |context: &Context| {
        let rig = rig(rig_file, "").with_context(context);
        let comparison = compare(&rig, &record).unwrap();
        let of_channel = |channel: &borescope::internals::learn::comparison::ChannelComparison| {
            let goes: Vec<&str> = channel.goes_with.iter().map(|one| one.signal.as_str()).collect();
            let worst: Vec<&str> = channel.worst.iter().map(|one| one.phase.as_str()).collect();
            format!("{} {}: {} in {}", channel.name, channel.adequate, goes.join("+"), worst.join("+"))
        };
        let words: Vec<String> = comparison.channels.iter().map(of_channel).collect();
        let mut said = Said { words: words.join("; "), ..done(context) };
        let text = std::fs::read_to_string(rig_file).unwrap();
        let place = if rig_file == TANKS { "external-leakage@upper" } else { "external-leakage@A" };
        let with = Rig::parse(rig_file, add(&text, &rig, place, None).unwrap().text).unwrap();
        for parameter in with.parameters.iter().filter(|parameter| parameter.id.starts_with(place)) {
            said.number(&parameter.id, parameter.value, 1.96 * parameter.sigma);
        }
        said
    };
    Case { name, groups: &["learn"], work: Box::new(work) }
}

fn calibrated(name: &'static str, rig_file: &'static str, more: &'static str, records: Vec<Record>) -> Case {
    let work = move |context: &Context| {
        let text = std::fs::read_to_string(rig_file).unwrap() + more;
        let rig = Rig::parse(rig_file, text.clone()).unwrap().with_context(context);
        let report = calibrate(&text, &rig, &records, &CalibrationOptions::default()).unwrap().report;
        let informed = report.parameters.iter().filter(|parameter| parameter.informed).count();
        let adequate = if report.adequate { "adequate" } else { "inadequate" };
        let words = format!("{adequate}, {informed} parameters determined, {} warnings", report.warnings.len());
        let mut said = Said { words, ..done(context) };
        for parameter in &report.parameters {
            said.number(&parameter.id, parameter.after, 1.96 * parameter.sigma_after);
        }
        for sensor in &report.sensors {
            // A standard deviation from a few independent phases is known to a quarter, one from many rows to some percent.
            said.number(format!("noise of {}", sensor.name), sensor.noise, 0.1 * sensor.noise);
            said.number(format!("tolerance of {}", sensor.name), sensor.tolerance, 0.5 * sensor.tolerance);
        }
        said
    };
    Case { name, groups: &["calibration", "diagnosis"], work: Box::new(work) }
}

fn watched() -> Case {
    let work = |context: &Context| {
        let model = Model::new(rig(TELESCOPIC, "").with_context(context));
        let watching = Watching { window: 4.0, fits: 1 };
        let path = "fixtures/telescopic/leak_020.csv";
        let watched = model.watch(path, watching, &DiagnosisOptions::default()).unwrap();
        Said { words: format!("{:?}, {} episodes", watched.conclusion, watched.episodes.len()), ..done(context) }
    };
    Case { name: "leak_020 in windows", groups: &["watch"], work: Box::new(work) }
}

fn foreseen() -> Case {
    let work = |context: &Context| {
        let found = isolability(&rig(PRESS, "").with_context(context), None, &[]).unwrap();
        let expected = found.expected.unwrap();
        let mut said = Said { words: format!("rival {}", expected.rival.join(" + ")), ..done(context) };
        for width in &expected.widths {
            said.number(&width.id, width.half_width.unwrap_or(0.0), width.half_width.unwrap_or(0.0));
        }
        said
    };
    Case { name: "isolability of the press", groups: &["isolability"], work: Box::new(work) }
}

/// The open records of the study.
pub fn cases() -> Vec<Case> {
    let tanks = || rig(TANKS, "");
    let mut swapped = cycle(&tanks(), &[], 4.0, 7);
    let place = |name: &str, record: &Record| record.channels.iter().position(|one| one.name == name).unwrap();
    let [a, b] = ["level_1", "level_2"].map(|name| place(name, &swapped));
    let first = std::mem::take(&mut swapped.channels[a].values);
    swapped.channels[a].values = std::mem::replace(&mut swapped.channels[b].values, first);
    let mut fast = cycle(&tanks(), &[], 4.0, 7);
    fast.time.iter_mut().for_each(|time| *time *= 1.02);
    let onset = {
        let model = Model::new(tanks());
        let mut cycle = tanks().cycle.clone().unwrap();
        cycle.interval *= 4.0;
        Run::of(&model)
            .through(cycle)
            .with_quantities(&[("upper_outlet.diameter", "7 mm")])
            .since(500.0)
            .record("onset")
    };
    let press = rig(PRESS, "");
    let two = [("cylinder.clearance", "0.08 mm"), ("relief.set_pressure", "130 bar")];
    let pressed = cycle(&press, &two, 4.0, 2);
    vec![
        diagnosed("tanks, outlet narrower", &["diagnosis", "learn"], tanks(), {
            cycle(&tanks(), &[("upper_outlet.diameter", "7.8 mm")], 4.0, 5)
        }),
        diagnosed("tanks, outlet narrower since 500 s", &["diagnosis"], tanks(), onset),
        diagnosed("tanks, columns swapped", &["diagnosis"], tanks(), swapped),
        diagnosed("tanks, clock fast", &["diagnosis"], tanks(), fast),
        learnt("tanks, leak outwards", "\"external-leakage@upper\" = { conductance = \"20 L/min/bar\" }"),
        compared("tanks, leak outwards, compared", TANKS, {
            hidden("\"external-leakage@upper\" = { conductance = \"20 L/min/bar\" }", 4.0)[0].clone()
        }),
        compared("press, leak outwards, compared", PRESS, {
            let plant = rig(PRESS, "\n[effects]\n\"external-leakage@A\" = { conductance = \"0.01 L/min/bar\" }\n");
            cycle(&plant, &[], 4.0, 2)
        }),
        calibrated("tanks, calibrated", TANKS, "", vec![cycle(&tanks(), &[], 2.0, 8), cycle(&tanks(), &[], 2.0, 9)]),
        foreseen(),
        watched(),
        diagnosed("press, clearance and relief", &["diagnosis"], press, pressed),
        telescopic("leak_020"),
    ]
}

/// A setting halved or doubled, as far as it may be: numbers of things are whole, shares stay below 1.
pub fn moved(setting: &Setting, doubled: bool) -> f64 {
    let to = if doubled { 2.0 * setting.value } else { 0.5 * setting.value };
    match (setting.is_whole, setting.is_share() && to >= 1.0) {
        (true, _) => to.round().max(1.0),
        (false, true) => 0.5 * (1.0 + setting.value),
        (false, false) => to,
    }
}

#[test]
fn every_setting_can_be_halved_and_doubled() {
    for setting in Settings::default().each() {
        for doubled in [false, true] {
            let value = moved(&setting, doubled);
            assert!(Settings::default().with(setting.id, value).is_ok(), "{} {value}", setting.id);
        }
    }
}

mod studies {
    use super::*;
    use crate::support::page;
    use crate::support::study::{self, Changed};

    /// Which group of cases a setting is asked of.
    fn is_asked(case: &Case, setting: &Setting) -> bool {
        let group = setting.id.split('.').next().unwrap();
        match setting.id {
            "diagnosis.standing_deviations" => case.groups.contains(&"watch"),
            "diagnosis.identifiable_records" => case.groups.contains(&"isolability"),
            _ => case.groups.contains(&group),
        }
    }

    /// Each setting at half and at double, `ONLY` those whose id begins so; `PART` of `PARTS`. What changes is written to
    /// `fixtures/studies/settings.csv` with `BLESS=1`, and has to be what stands there without.
    #[test]
    #[ignore = "takes an hour and a half; ONLY=diagnosis.present a minute"]
    fn each_setting_halved_and_doubled() {
        let only = std::env::var("ONLY").unwrap_or_default();
        let (part, of) = (study::number("PART", 0), study::number("PARTS", 1));
        let given = Settings::default();
        let settings = given.each().filter(|one| one.id.starts_with(&only)).skip(part).step_by(of);
        let settings: Vec<Setting> = settings.collect();
        if settings.is_empty() {
            return;
        }
        let cases = cases();
        let plain: Vec<Said> = cases
            .iter()
            .map(|case| {
                let begun = std::time::Instant::now();
                let said = (case.work)(&Context::new());
                println!("{}: {}, {} in {:.1?}", case.name, said.words, said.effort, begun.elapsed());
                said
            })
            .collect();
        for setting in settings {
            for doubled in [false, true] {
                let value = moved(&setting, doubled);
                let (mut said_otherwise, mut shift, mut effort, mut plain_effort) = (Vec::new(), 0.0_f64, 0, 0);
                if value != setting.value {
                    for (case, plain) in cases.iter().zip(&plain).filter(|(case, _)| is_asked(case, &setting)) {
                        let settings = Settings::default().with(setting.id, value).unwrap();
                        let said = (case.work)(&Context::new().with_settings(settings));
                        if said.words != plain.words {
                            said_otherwise.push(format!("{}: {}", case.name, said.otherwise_than(plain)));
                        } else {
                            shift = shift.max(said.differs_by(plain));
                        }
                        effort += said.effort;
                        plain_effort += plain.effort;
                    }
                }
                let ratio = if plain_effort == 0 { 1.0 } else { effort as f64 / plain_effort as f64 };
                let side = if doubled { "double" } else { "half" };
                let (setting, side) = (setting.id.to_owned(), side.to_owned());
                let changed = Changed { setting, side, value, shift, effort: ratio, otherwise: said_otherwise };
                println!("{changed:?}");
                if page::blessed() { changed.write() } else { changed.is_as_written() }
            }
        }
    }
}
