//! The library of effects as a table, as cards, and as programs read it (`borescope.effects/1`).

#[cfg(feature = "internals")]
use std::fmt::{self, Write};

use serde::Serialize;

use super::table::{Head, aligned, fitted};
use crate::complaint::did_you_mean;
use crate::number::with_unit;
use crate::physics::card::Parameter;
use crate::physics::effect::{At, EFFECTS, Effect, FreeParameter, InitialGuess};
use crate::physics::fluid;
use crate::rig::catalogue;

/// Name and version of the JSON schema.
pub const SCHEMA: &str = "borescope.effects/1";
/// Limits beyond which a value is any value.
const ANY: f64 = 1e29;

/// A parameter of an effect. Numbers in `unit`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct FreeReport {
    /// As the rig file has it.
    pub name: &'static str,
    /// In words.
    pub meaning: &'static str,
    /// `unit of the sensor` where it is that.
    pub unit: &'static str,
    /// What it is when the effect does nothing; `None` where it only shapes the effect, or is what the rig has.
    pub neutral: Option<f64>,
    /// What is tried first, in words.
    pub first: String,
    /// Values with physical sense; an end is `None` where there is no limit.
    pub plausible: [Option<f64>; 2],
}

/// The card of an effect.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct EffectReport {
    /// As the rig file has it.
    pub name: &'static str,
    #[serde(skip)]
    of_catalogue: bool,
    /// In words.
    pub meaning: &'static str,
    /// Where it may sit.
    pub at: String,
    /// How the rig file writes it.
    pub written: String,
    /// Its formula.
    pub law: &'static str,
    /// Where the law is from.
    pub source: &'static str,
    /// Where the law holds.
    pub validity: &'static str,
    /// In the order of the card.
    pub parameters: Vec<FreeReport>,
}

/// The whole library.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct LibraryReport {
    pub schema: &'static str,
    /// In the order of the library.
    pub effects: Vec<EffectReport>,
}

/// Every effect that a rig may have without describing it: those of the library, then those of the catalogue's components.
pub fn all() -> impl Iterator<Item = &'static Effect> {
    let of_catalogue = catalogue::kinds().into_iter().flatten().flat_map(|kind| &kind.effects);
    EFFECTS.iter().chain(of_catalogue).copied()
}

/// The effects of this name; components of several kinds may have one each.
pub fn named(name: &str) -> Vec<&'static Effect> {
    all().filter(|effect| effect.name == name).collect()
}

/// So many names are offered for one that is not known.
const OFFERED: usize = 6;

/// The names that may be meant by one that is not known: those nearest by letters, then those that have one of its words.
pub fn meant(name: &str) -> Vec<&'static str> {
    let mut names: Vec<&'static str> = all().map(|effect| effect.name).collect();
    names.sort_unstable();
    names.dedup();
    let words: Vec<String> =
        name.to_lowercase().split(['-', '_', ' ']).filter(|word| word.len() > 2).map(str::to_owned).collect();
    let near = did_you_mean(name, names.iter().copied());
    let alike = names.iter().copied().filter(|known| words.iter().any(|word| known.contains(word.as_str())));
    // Curves without a formula are the last that a name without one means.
    let mut alike: Vec<&str> = alike.filter(|known| Some(*known) != near).collect();
    alike.sort_by_key(|known| known.starts_with("empirical"));
    near.into_iter().chain(alike).take(OFFERED).collect()
}

impl LibraryReport {
    pub fn new() -> Self {
        Self { schema: SCHEMA, effects: all().map(EffectReport::new).collect() }
    }

    /// Of these effects alone.
    pub fn of(effects: &[&Effect]) -> Self {
        Self { schema: SCHEMA, effects: effects.iter().map(|effect| EffectReport::new(effect)).collect() }
    }
}

impl Default for LibraryReport {
    fn default() -> Self {
        Self::new()
    }
}

impl EffectReport {
    pub fn new(effect: &Effect) -> Self {
        let (at, place) = match effect.at {
            At::Fluid(_) => ("the fluid".to_owned(), ""),
            At::Warmth(_) => ("the fluid, where `temperature` in `[fluid]` names its column".to_owned(), ""),
            At::Node => ("a node with a volume".to_owned(), "@NODE"),
            At::Actuator => ("a node with a cylinder or a motor".to_owned(), "@NODE"),
            At::Return => ("a node into which a directional valve drains".to_owned(), "@NODE"),
            At::Component { card, named } => (format!("a `{}`", card.kind), if named { "@COMPONENT" } else { "" }),
            At::Like { symbol, named } => (symbol.words().to_owned(), if named { "@COMPONENT" } else { "" }),
            At::Sensor => ("a sensor".to_owned(), "@SENSOR"),
            At::Named(node) => (format!("the node `{node}`"), ""),
            At::NamedSensor(sensor) => (format!("the sensor `{sensor}`"), ""),
            At::NamedComponent(component) => (format!("the component `{component}`"), ""),
        };
        Self {
            name: effect.name,
            of_catalogue: matches!(effect.at, At::Component { card, .. } if card.own.is_some()),
            meaning: effect.meaning,
            at,
            written: format!("{}{place}", effect.name),
            law: effect.law,
            source: effect.source,
            validity: effect.validity,
            parameters: effect.parameters.iter().map(|free| parameter(effect, free)).collect(),
        }
    }
}

/// The entry of a card behind a parameter of an effect; of what a sensor has already there is none.
pub fn entry(effect: &Effect, name: &str) -> Option<&'static Parameter> {
    let parameters = match (effect.form.card(), effect.at) {
        (Some(card), _) => card.parameters,
        (None, At::Fluid(_) | At::Warmth(_)) => fluid::CARD.parameters,
        (None, At::Component { card, .. }) => card.parameters,
        (None, _) => return None,
    };
    parameters.iter().find(|own| own.name == name)
}

fn parameter(effect: &Effect, free: &FreeParameter) -> FreeReport {
    let entry = entry(effect, free.name);
    let of_sensor = matches!(effect.at, At::Sensor);
    let unit = match entry.map(|entry| entry.unit) {
        Some("-") if of_sensor => "unit of the sensor",
        Some(unit) => unit,
        // The gain of a sensor is a number, its offset is not.
        None if free.name == "gain" => "-",
        None => "unit of the sensor",
    };
    let first = match free.first {
        InitialGuess::Value(value) => with_unit(value, unit),
        InitialGuess::Onset(_) => "0.35 to 0.8 of the highest pressure".to_owned(),
        InitialGuess::Noise(factor) => format!("{factor} of the sensor's noise"),
        InitialGuess::Range(_) => "0.6 to 0.95 of the highest reading or level".to_owned(),
    };
    let (low, high) = free.plausible;
    FreeReport {
        name: free.name,
        meaning: entry.map_or(effect.meaning, |entry| entry.meaning),
        unit,
        neutral: free.neutral,
        first,
        plausible: [(low > -ANY).then_some(low), (high < ANY).then_some(high)],
    }
}

impl FreeReport {
    /// The neutral value in words.
    pub fn neutral_text(&self) -> String {
        self.neutral.map_or("-".to_owned(), crate::number::text)
    }

    /// The plausible range in words.
    pub fn plausible_text(&self) -> String {
        let shown = crate::number::text;
        match self.plausible {
            [Some(low), Some(high)] => format!("{} to {}", shown(low), shown(high)),
            [Some(low), None] => format!("{} or more", shown(low)),
            [None, Some(high)] => format!("{} or less", shown(high)),
            [None, None] => "any value".to_owned(),
        }
    }
}

impl EffectReport {
    /// Its name where names alone do not say which.
    pub fn title(&self) -> String {
        self.heading().replace('`', "")
    }

    fn heading(&self) -> String {
        let of = if self.of_catalogue { format!(" of {}", self.at.trim_start_matches("a ")) } else { String::new() };
        format!("`{}`{of}", self.name)
    }
}

/// The parameters with their names as tables show them: alike ones that follow one another, such as the heights of a curve, in
/// one row.
fn rows(effect: &EffectReport) -> Vec<(String, &FreeReport)> {
    let alike = |a: &FreeReport, b: &FreeReport| FreeReport { name: a.name, ..b.clone() } == *a;
    effect
        .parameters
        .chunk_by(alike)
        .map(|run| match run {
            [first, .., last] => (format!("{} to {}", first.name, last.name), first),
            run => (run[0].name.to_owned(), &run[0]),
        })
        .collect()
}

const LIBRARY_HEADS: [Head; 2] = [("effect", false), ("meaning, and where it may sit", false)];
pub(super) const FREE_HEADS: [Head; 6] = [
    ("parameter", false),
    ("unit", false),
    ("neutral", true),
    ("tried first", false),
    ("plausible", false),
    ("meaning", false),
];

/// The parameters of a card as a table has them.
pub(super) fn free_rows(effect: &EffectReport) -> Vec<Vec<String>> {
    let row = |(name, free): (String, &FreeReport)| {
        vec![
            name,
            free.unit.to_owned(),
            free.neutral_text(),
            free.first.clone(),
            free.plausible_text(),
            free.meaning.to_owned(),
        ]
    };
    rows(effect).into_iter().map(row).collect()
}

/// The library as a table by name; of effects of one name, at components of several kinds, one row.
pub fn library() -> String {
    let mut effects = LibraryReport::new().effects;
    effects.sort_by_key(|effect| effect.name);
    let row = |same: &[EffectReport]| {
        let places: Vec<String> = same.iter().map(|effect| effect.at.replace('`', "")).collect();
        vec![same[0].name.to_owned(), format!("{} At {}.", same[0].meaning, places.join(" or "))]
    };
    let rows: Vec<Vec<String>> = effects.chunk_by(|a, b| a.name == b.name).map(row).collect();
    aligned(&LIBRARY_HEADS, &rows).join("\n") + "\n\nThe card of one: borescope effects NAME\n"
}

/// One card as text.
pub fn card(effect: &Effect) -> String {
    let effect = EffectReport::new(effect);
    let mut lines = vec![effect.name.to_owned(), effect.meaning.to_owned(), String::new()];
    lines.push(format!("law       {}", effect.law));
    lines.push(format!("where     {}, written `{}`", effect.at.replace('`', ""), effect.written));
    lines.push(format!("validity  {}", effect.validity));
    lines.push(format!("source    {}", effect.source));
    lines.push(String::new());
    lines.extend(aligned(&FREE_HEADS, &free_rows(&effect)));
    fitted(&(lines.join("\n") + "\n"))
}

/// The whole library as part of a page.
///
/// # Errors
/// None but those of the text that it is written to.
#[cfg(feature = "internals")]
pub fn markdown(out: &mut String) -> fmt::Result {
    writeln!(out, "| effect | where | meaning |\n|---|---|---|")?;
    let effects = LibraryReport::new().effects;
    let anchor = |title: &str| title.replace([':', '`'], "").replace(' ', "-");
    for effect in &effects {
        let title = effect.title();
        writeln!(out, "| [`{}`](#{}) | {} | {} |", effect.name, anchor(&title), effect.at, effect.meaning)?;
    }
    for effect in &effects {
        writeln!(out, "\n### {}\n\n{}\n", effect.heading(), effect.meaning)?;
        writeln!(out, "```text\n{}\n```\n", effect.law)?;
        writeln!(out, "*Sits at:* {}, written `{}`.\n", effect.at, effect.written)?;
        writeln!(out, "*Holds for:* {}\n", effect.validity)?;
        writeln!(out, "*Source:* {}.\n", effect.source.trim_end_matches('.'))?;
        writeln!(out, "| parameter | unit | neutral | tried first | plausible | meaning |\n|---|---|---|---|---|---|")?;
        for (name, free) in rows(effect) {
            let (neutral, plausible) = (free.neutral_text(), free.plausible_text());
            let (unit, first, meaning) = (free.unit, &free.first, free.meaning);
            writeln!(
                out,
                "| `{}` | {unit} | {neutral} | {first} | {plausible} | {meaning} |",
                name.replace(" to ", "` to `")
            )?;
        }
    }
    Ok(())
}
