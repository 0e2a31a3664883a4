//! From channels to groups of columns, each with its time: a channel of times, or the waveform properties.

use std::collections::HashMap;

use super::kind::STEPS_PER_SECOND;
use super::object::{Object, Objects, Value};
use super::scale::Scale;
use crate::record::groups::{Column, Group, Groups, is_time, split_name};
use crate::units::{Dimension, Unit};

/// Words that NI's drivers write for units.
const WORDS: &[(&str, &str)] = &[
    ("Volts", "V"),
    ("Amps", "A"),
    ("Deg C", "degC"),
    ("Kelvins", "K"),
    ("Hz", "Hz"),
    ("Seconds", "s"),
    ("Meters", "m"),
    ("Newtons", "N"),
    ("Pascals", "Pa"),
    ("Bar", "bar"),
    ("Pounds/square inch", "psi"),
];

/// Times at equal distances: the first one and the distance in seconds, and how many there are, as bits that can be compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Wave {
    start: Option<i128>,
    offset: u64,
    increment: u64,
    count: usize,
}

/// A group before the times of all of them are counted from one moment.
struct Timed {
    group: Group,
    /// The moment that its times count from; `None` where the file does not say.
    start: Option<i128>,
}

/// The series of a file, its times counted from the earliest moment that it names.
pub(super) fn gather(mut objects: Objects) -> Groups {
    let mut groups = Groups::default();
    let names = Names::of(&objects);
    let mut members: HashMap<String, usize> = HashMap::new();
    let mut by_group: Vec<Vec<usize>> = Vec::new();
    for (id, object) in objects.known.iter().enumerate() {
        let [group, _] = &object.path[..] else { continue };
        let place = *members.entry(group.clone()).or_insert(by_group.len());
        if place == by_group.len() {
            by_group.push(Vec::new());
        }
        by_group[place].push(id);
    }
    let mut timed = Vec::new();
    for ids in by_group {
        gather_group(&mut objects, &ids, &names, &mut groups, &mut timed);
    }
    let origin = timed.iter().filter_map(|one| one.start).min();
    for Timed { mut group, start } in timed {
        match (origin, start) {
            (Some(origin), Some(start)) => {
                let after = (start - origin) as f64 / STEPS_PER_SECOND;
                group.time.iter_mut().for_each(|time| *time += after);
                groups.push(group);
            }
            (None, _) => groups.push(group),
            (Some(_), None) => {
                for column in group.columns {
                    groups.leave(column.name, "its time has no date, but that of other groups has one");
                }
            }
        }
    }
    groups
}

/// What channels are called: by their group, too, where another group has one of the same name.
struct Names(HashMap<String, usize>);

impl Names {
    fn of(objects: &Objects) -> Self {
        let mut counts = HashMap::new();
        for object in &objects.known {
            if let [_, channel] = &object.path[..] {
                *counts.entry(split_name(channel).0).or_insert(0) += 1;
            }
        }
        Self(counts)
    }

    fn name(&self, object: &Object) -> (String, Option<String>) {
        let [group, channel] = &object.path[..] else { return Default::default() };
        let (name, unit) = split_name(channel);
        let alone = self.0.get(&name).is_none_or(|count| *count == 1);
        (if alone { name } else { format!("{group}/{name}") }, unit)
    }
}

fn gather_group(objects: &mut Objects, ids: &[usize], names: &Names, groups: &mut Groups, timed: &mut Vec<Timed>) {
    let clock = ids.iter().copied().find(|id| objects.known.get(*id).is_some_and(is_clock));
    let mut places: HashMap<Option<Wave>, usize> = HashMap::new();
    match clock.map(|id| clock_of(objects, id)) {
        Some(Ok(time)) => {
            places.insert(None, timed.len());
            timed.push(time);
        }
        Some(Err(why)) => groups.leave("time", why),
        None => {}
    }
    for id in ids.iter().copied().filter(|id| Some(*id) != clock) {
        let Some(object) = objects.known.get(id) else { continue };
        let (name, in_name) = names.name(object);
        let column = match column(objects, id, name.clone(), in_name) {
            Ok(column) => column,
            Err(why) => {
                groups.leave(name, why);
                continue;
            }
        };
        let count = column.values.len();
        let beside = places.get(&None).filter(|place| timed[**place].group.time.len() == count).copied();
        let wave = objects.known.get(id).map(|object| wave(object, count));
        let place = match (beside, wave) {
            (Some(place), _) => place,
            (None, Some(Ok(wave))) => *places.entry(Some(wave)).or_insert_with(|| {
                timed.push(Timed { group: wave.group(), start: wave.start });
                timed.len() - 1
            }),
            (None, Some(Err(why))) => {
                groups.leave(name, why);
                continue;
            }
            (None, None) => continue,
        };
        timed[place].group.columns.push(column);
    }
}

/// Whether a channel is the time of its group.
fn is_clock(object: &Object) -> bool {
    let [_, channel] = &object.path[..] else { return false };
    !object.data.stamps.is_empty() || (is_time(&split_name(channel).0) && !object.data.numbers.is_empty())
}

fn clock_of(objects: &mut Objects, id: usize) -> Result<Timed, String> {
    let stamps = objects.known.get_mut(id).map(|object| std::mem::take(&mut object.data.stamps)).unwrap_or_default();
    if let Some(start) = stamps.first().copied() {
        let since = |stamp: &i128| stamp.saturating_sub(start) as f64 / STEPS_PER_SECOND;
        let time = stamps.iter().map(since).collect();
        return Ok(Timed { group: Group { time, time_unit: "s".to_owned(), ..Group::default() }, start: Some(start) });
    }
    let in_name = objects.known.get(id).and_then(|object| split_name(object.path.last()?).1);
    let column = column(objects, id, String::new(), in_name)?;
    let time_unit = column.unit.unwrap_or_else(|| "s".to_owned());
    Ok(Timed { group: Group { time: column.values, time_unit, ..Group::default() }, start: None })
}

/// The values of a channel with their unit; why there are none.
fn column(objects: &mut Objects, id: usize, name: String, in_name: Option<String>) -> Result<Column, String> {
    let group = objects.known.get(id).and_then(|object| object.path.first()).cloned();
    let own = objects.known.get(id).map(|object| &object.properties);
    let scale = Scale::of(&[own, objects.properties(group.as_deref()), objects.properties(None)])?;
    let Some(object) = objects.known.get_mut(id) else { return Err("no values".to_owned()) };
    let unit = object.text("unit_string").or_else(|| object.text("NI_UnitDescription"));
    let unit = unit.map(|unit| of_words(unit).to_owned()).or(in_name);
    let data = &mut object.data;
    let values = match (data.other, scale) {
        (Some(what), _) => return Err(what.to_owned()),
        (None, _) if !data.stamps.is_empty() => return Err("time stamps".to_owned()),
        (None, Some(scale)) => scale.apply(data)?,
        (None, None) if !data.scalers.is_empty() => return Err("values of a card without their scale".to_owned()),
        (None, None) => std::mem::take(&mut data.numbers),
    };
    if values.is_empty() { Err("no values".to_owned()) } else { Ok(Column { name, unit, values }) }
}

fn of_words(unit: &str) -> &str {
    WORDS.iter().find(|(word, _)| word.eq_ignore_ascii_case(unit)).map_or(unit, |(_, symbol)| symbol)
}

/// The times of a channel after its waveform properties; why it has none.
fn wave(object: &Object, count: usize) -> Result<Wave, String> {
    let increment = object.number("wf_increment").ok_or("no time with it")?;
    let unit = object.text("wf_xunit_string").unwrap_or("s");
    let second = Unit::parse_as(of_words(unit), Dimension::TIME)
        .map_err(|_| format!("its values stand over `{unit}`, no time"))?;
    let (increment, offset) = (second.to_si(increment), second.to_si(object.number("wf_start_offset").unwrap_or(0.0)));
    if !(increment > 0.0 && increment.is_finite() && offset.is_finite()) {
        return Err(format!("its samples are {increment} s apart"));
    }
    // LabVIEW writes the beginning of its calendar where nobody set the start.
    let start = match object.properties.get("wf_start_time") {
        Some(Value::Moment(start)) if *start != 0 => Some(*start),
        _ => None,
    };
    Ok(Wave { start, offset: offset.to_bits(), increment: increment.to_bits(), count })
}

impl Wave {
    fn group(&self) -> Group {
        let (offset, increment) = (f64::from_bits(self.offset), f64::from_bits(self.increment));
        let time = (0..self.count).map(|row| offset + row as f64 * increment).collect();
        Group { time, time_unit: "s".to_owned(), ..Group::default() }
    }
}
