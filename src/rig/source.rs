//! The text of a rig file with the place of every entry, so that a complaint can point at it.

use std::cell::RefCell;
use std::ops::Range;
use std::path::{Path, PathBuf};

use toml::Spanned;
use toml::de::{DeTable, DeValue};
use toml_edit::DocumentMut;

use crate::complaint::{Complaint, Kind, Place, did_you_mean, help_with_names};
use crate::units::{Dimension, Quantity, Unit, UnitError};
use crate::visible::unusable_name;

/// Most components, nodes, sensors and so on of a rig: far beyond what can be identified from one record, and few enough that
/// work which grows with their square takes no time.
const MOST_ENTRIES: usize = 1000;

/// A file and its text.
pub struct Source {
    pub path: PathBuf,
    pub text: String,
    /// Where each line begins.
    lines: Vec<usize>,
}

impl Source {
    pub fn new(path: impl Into<PathBuf>, text: String) -> Self {
        let lines = std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect();
        Self { path: path.into(), text, lines }
    }

    /// Where a key that stands at a byte stood before: in the line of its own table that begins with it, or, of a table, in the
    /// same heading.
    pub fn earlier(&self, key: &str, byte: usize) -> Option<Range<usize>> {
        let before = self.lines.partition_point(|start| *start <= byte).saturating_sub(1);
        let line = |index: usize| {
            let start = *self.lines.get(index)?;
            self.text.get(start..)?.lines().next().map(|line| (start, line.trim()))
        };
        let (_, own) = line(before)?;
        let heading = |line: &str| line.split('#').next().unwrap_or_default().trim().to_owned();
        let is_first = |text: &str| match own.starts_with('[') {
            true => heading(text) == heading(own),
            false => text.strip_prefix(key).is_some_and(|rest| rest.trim_start().starts_with(['=', '.'])),
        };
        let earlier = (0..before).rev().map_while(line);
        let mut own_table = earlier.take_while(|(_, text)| own.starts_with('[') || !text.starts_with('['));
        let (start, _) = own_table.find(|(_, text)| is_first(text))?;
        let at = start + self.text.get(start..)?.find(key)?;
        Some(at..at + key.len())
    }

    /// The line in which these bytes of the text begin, with them marked.
    pub fn place(&self, bytes: Range<usize>) -> Place {
        let number = self.lines.partition_point(|start| *start <= bytes.start);
        let start = number.checked_sub(1).and_then(|index| self.lines.get(index)).copied().unwrap_or(0);
        let end = self.lines.get(number).copied().unwrap_or(self.text.len());
        let line = self.text.get(start..end).unwrap_or_default();
        Place::line(&self.path, number).showing(line, bytes.start - start..bytes.end.saturating_sub(start))
    }

    /// Whether both bytes of the text are in one line.
    fn same_line(&self, byte: usize, other: usize) -> bool {
        let line = |byte| self.lines.partition_point(|start| *start <= byte);
        line(byte) == line(other)
    }
}

/// The text of a rig file for changing parts of it; the rest, comments and order included, stays.
///
/// # Errors
/// A text that is no TOML.
pub fn document(path: &Path, text: &str) -> Result<DocumentMut, Complaint> {
    text.parse().map_err(|error: toml_edit::TomlError| {
        let place = Place::of_byte(path, text, error.span().map_or(0, |span| span.start));
        Complaint::new(Kind::Syntax, format!("this is not TOML: {}", error.message().replace('\n', "; "))).at(place)
    })
}

/// A table that remembers which of its keys were asked for, so that the others can be complained about.
pub struct Table<'a> {
    source: &'a Source,
    /// How messages call it, such as ``component `pump` ``.
    pub what: String,
    /// Its key; empty of the whole file.
    key: Range<usize>,
    entries: &'a DeTable<'a>,
    asked: RefCell<Vec<String>>,
}

impl<'a> Table<'a> {
    pub fn new(source: &'a Source, what: impl Into<String>, key: Range<usize>, entries: &'a DeTable<'a>) -> Self {
        Self { source, what: what.into(), key, entries, asked: RefCell::default() }
    }

    /// Where the table begins.
    pub fn place(&self) -> Place {
        if self.key.is_empty() { Place::line(&self.source.path, 1) } else { self.source.place(self.key.clone()) }
    }

    /// The value of a key, if it is there.
    pub fn get(&self, key: &str) -> Option<Value<'a>> {
        self.asked.borrow_mut().push(key.to_owned());
        let (key, value) = self.entries.get_key_value(key)?;
        Some(Value {
            source: self.source,
            what: format!("`{}` of {}", key.get_ref(), self.what),
            key: key.span(),
            value,
        })
    }

    /// The value of a key that must be there; `help` says what to write.
    pub fn require(&self, key: &str, help: &str) -> Result<Value<'a>, Complaint> {
        self.get(key).ok_or_else(|| self.lacks(key, [], help))
    }

    /// That a key is missing which must be there; `known` are keys that will be asked for yet.
    pub fn lacks<'k>(&self, key: &str, known: impl IntoIterator<Item = &'k str>, help: &str) -> Complaint {
        let complaint = Complaint::new(Kind::MissingEntry, format!("{} has no `{key}`", self.what));
        let known: Vec<&str> = known.into_iter().collect();
        // A mistyped key would otherwise be missed here before it is found to be unknown.
        let entries = self.entries();
        let is_other = |name: &str| self.was_asked(name) || known.contains(&name);
        let near = entries.iter().find(|(name, _)| !is_other(name) && did_you_mean(name, [key]).is_some());
        match near {
            Some((name, value)) => complaint.at(value.key_place()).help(format!("write `{key}` instead of `{name}`")),
            None => complaint.at(self.place()).help(help),
        }
    }

    fn was_asked(&self, name: &str) -> bool {
        self.asked.borrow().iter().any(|key| key == name)
    }

    /// Every entry, in the order of the file.
    pub fn entries(&self) -> Vec<(&'a str, Value<'a>)> {
        let mut entries: Vec<_> = self
            .entries
            .iter()
            .map(|(key, value)| {
                let name: &'a str = key.get_ref();
                let what = format!("`{name}` of {}", self.what);
                (name, Value { source: self.source, what, key: key.span(), value })
            })
            .collect();
        entries.sort_by_key(|(_, value)| value.key.start);
        entries
    }

    /// Every entry of a table whose keys are names, in the order of the file.
    ///
    /// # Errors
    /// More entries than a circuit has, and a name that cannot be shown.
    pub fn named_entries(&self) -> Result<Vec<(&'a str, Value<'a>)>, Complaint> {
        let count = self.entries.len();
        if count > MOST_ENTRIES {
            return Err(Complaint::new(Kind::Bounds, format!("{} has {count} entries", self.what))
                .at(self.place())
                .help(format!("no more than {MOST_ENTRIES}: describe the part of the circuit that the sensors see")));
        }
        let entries = self.entries();
        entries.iter().try_for_each(|(name, value)| check_name(name, || value.key_place()))?;
        Ok(entries)
    }

    /// Complains about the first key that nobody asked for.
    pub fn finish(&self) -> Result<(), Complaint> {
        let unknown = self.entries().into_iter().find(|(name, _)| !self.was_asked(name));
        let asked = self.asked.borrow();
        match unknown {
            None => Ok(()),
            Some((name, value)) => Err(Complaint::new(Kind::UnknownName, format!("{} has no key `{name}`", self.what))
                .at(value.key_place())
                .help(help_with_names(name, "keys", asked.iter().map(String::as_str)))),
        }
    }
}

/// A value with its place.
#[derive(Clone)]
pub struct Value<'a> {
    source: &'a Source,
    /// How messages call it.
    pub what: String,
    /// Its key, or, of an item of a list, itself.
    key: Range<usize>,
    value: &'a Spanned<DeValue<'a>>,
}

/// A quantity, its unit as written, and its standard uncertainty in SI where one is stated.
#[derive(Debug, Clone, PartialEq)]
pub struct Stated {
    pub value: f64,
    pub unit: Unit,
    pub sigma: Option<f64>,
}

impl<'a> Value<'a> {
    /// The line of its key. A value in the same line is marked, and its key if it is a table or begins in another line.
    pub fn place(&self) -> Place {
        let value = self.value.span();
        let marks_value = !self.value.get_ref().is_table() && self.source.same_line(self.key.start, value.start);
        self.source.place(if marks_value { value } else { self.key.clone() })
    }

    /// A file that it names from the folder of its own file.
    pub fn beside(&self, name: &str) -> PathBuf {
        self.source.path.parent().unwrap_or(Path::new("")).join(name)
    }

    /// Its key.
    fn key_place(&self) -> Place {
        self.source.place(self.key.clone())
    }

    /// The place of a byte of its text: the value, where that is not written as it reads.
    pub fn place_in_text(&self, byte: usize) -> Place {
        let value = self.value.span();
        let written = self.source.text.get(value.clone()).unwrap_or_default();
        let text = self.value.get_ref().as_str().unwrap_or_default();
        match written.find(text) {
            Some(start) if self.source.same_line(self.key.start, value.end) => {
                let at = value.start + start + byte;
                self.source.place(at..at + 1)
            }
            _ => self.place(),
        }
    }

    fn wrong(&self, kind: Kind, what: impl Into<String>) -> Complaint {
        Complaint::new(kind, what).at(self.place())
    }

    fn wrong_type(&self, wanted: &str) -> Complaint {
        self.wrong(Kind::Syntax, format!("{} is {} instead of {wanted}", self.what, type_name(self.value.get_ref())))
            .help(format!("write {wanted}"))
    }

    pub fn text(&self) -> Result<&'a str, Complaint> {
        self.value.get_ref().as_str().ok_or_else(|| self.wrong_type("a text in quotes"))
    }

    /// A text that names something: short, and of visible characters.
    pub fn name(&self) -> Result<&'a str, Complaint> {
        let name = self.text()?;
        check_name(name, || self.place())?;
        Ok(name)
    }

    pub fn table(&self, what: impl Into<String>) -> Result<Table<'a>, Complaint> {
        let entries = self.value.get_ref().as_table().ok_or_else(|| self.wrong_type("a table in braces"))?;
        Ok(Table::new(self.source, what, self.key.clone(), entries))
    }

    pub fn list(&self) -> Result<Vec<Value<'a>>, Complaint> {
        let items = self.value.get_ref().as_array().ok_or_else(|| self.wrong_type("a list in brackets"))?;
        Ok(items
            .iter()
            .map(|item| Value { source: self.source, what: self.what.clone(), key: item.span(), value: item })
            .collect())
    }

    /// The items of a list, or the value itself where it is none.
    pub fn one_or_more(self) -> Result<Vec<Value<'a>>, Complaint> {
        if self.is_list() { self.list() } else { Ok(vec![self]) }
    }

    /// True or false.
    pub fn flag(&self) -> Result<bool, Complaint> {
        match self.value.get_ref() {
            DeValue::Boolean(flag) => Ok(*flag),
            _ => Err(self.wrong_type("true or false")),
        }
    }

    /// Whether the value is a list.
    pub fn is_list(&self) -> bool {
        self.value.get_ref().is_array()
    }

    /// A quantity of this dimension, in SI.
    pub fn quantity(&self, dimension: Dimension) -> Result<Quantity, Complaint> {
        let number = self.number(|| example(dimension))?;
        if number.contains("+-") || number.contains('±') {
            return Err(self
                .wrong(Kind::Contradiction, format!("{} has an uncertainty, but is taken as exact", self.what))
                .help("leave out `+-` and what follows"));
        }
        Quantity::parse_as(&number, dimension).map_err(|error| self.unit_error(&error))
    }

    /// A quantity of any dimension.
    pub fn any_quantity(&self) -> Result<Quantity, Complaint> {
        let number = self.number(|| "a quantity such as \"3 bar\"".to_owned())?;
        Quantity::parse(&number).map_err(|error| self.unit_error(&error))
    }

    /// A number, with its unit if it is a text; `wanted` says what would be right.
    fn number(&self, wanted: impl FnOnce() -> String) -> Result<String, Complaint> {
        match self.value.get_ref() {
            DeValue::Integer(number) => Ok(number.as_str().to_owned()),
            DeValue::Float(number) => Ok(number.as_str().to_owned()),
            DeValue::String(text) => Ok(text.to_string()),
            _ => Err(self.wrong_type(&wanted())),
        }
    }

    /// A quantity with an optional uncertainty: `8 ms +- 2 ms`, `8 ms +- 25 %`.
    pub fn stated(&self, dimension: Dimension) -> Result<Stated, Complaint> {
        let text = self.value.get_ref().as_str().unwrap_or_default();
        let Some((nominal, spread)) = text.split_once("+-").or_else(|| text.split_once('±')) else {
            let quantity = self.quantity(dimension)?;
            return Ok(Stated { value: quantity.value, unit: quantity.unit, sigma: None });
        };
        let nominal = Quantity::parse_as(nominal, dimension).map_err(|error| self.unit_error(&error))?;
        let spread = spread.trim();
        let sigma = if spread.ends_with('%') && nominal.unit.symbol != "%" {
            let share = Quantity::parse_as(spread, Dimension::NONE).map_err(|error| self.unit_error(&error))?;
            share.value * nominal.value.abs()
        } else if spread.parse() == Ok(0.0) {
            // Nothing is nothing in any unit.
            0.0
        } else {
            let spread = Quantity::parse_as(spread, dimension).map_err(|error| self.unit_error(&error))?;
            spread.unit.difference_to_si(spread.in_unit())
        };
        if sigma < 0.0 {
            return Err(self
                .wrong(Kind::Bounds, format!("the uncertainty of {} is negative", self.what))
                .help("write one standard deviation, 0 or more"));
        }
        Ok(Stated { value: nominal.value, unit: nominal.unit, sigma: Some(sigma) })
    }

    fn unit_error(&self, error: &UnitError) -> Complaint {
        self.wrong(Kind::Unit, format!("{}: {error}", self.what)).help(error.help())
    }
}

fn check_name(name: &str, place: impl FnOnce() -> Place) -> Result<(), Complaint> {
    let Some(why) = unusable_name(name) else { return Ok(()) };
    let short: String = name.chars().take(40).collect();
    let cut = if short == name { "" } else { "..." };
    Err(Complaint::new(Kind::Bounds, format!("the name `{short}{cut}` {why}"))
        .at(place())
        .help("write a short name of visible characters"))
}

fn example(dimension: Dimension) -> String {
    match Unit::known_for(dimension).first() {
        Some(unit) if dimension != Dimension::NONE => format!("a {dimension} such as \"1 {unit}\""),
        _ => "a number".to_owned(),
    }
}

fn type_name(value: &DeValue<'_>) -> &'static str {
    match value {
        DeValue::String(_) => "a text",
        DeValue::Integer(_) | DeValue::Float(_) => "a number",
        DeValue::Boolean(_) => "true or false",
        DeValue::Datetime(_) => "a date",
        DeValue::Array(_) => "a list",
        DeValue::Table(_) => "a table",
    }
}
