//! Objects of a file: its root, groups and channels, with their properties and where their raw data stand.

use std::collections::{BTreeMap, HashMap};

use super::cursor::Cursor;
use super::daqmx::Daqmx;
use super::kind::{Kind, moment};
use crate::record::bytes::Broken;

/// Instead of the length of an index: the object has no raw data in this segment.
const NO_DATA: u32 = 0xFFFF_FFFF;
/// The index is that of the segment before.
const AS_BEFORE: u32 = 0;

/// Values of a channel as they stand in a segment.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plain {
    pub kind: Kind,
    pub count: u64,
    /// Of all of them.
    pub bytes: u64,
}

/// How the raw data of a channel stand in each chunk.
#[derive(Debug, Clone)]
pub(super) enum Index {
    Plain(Plain),
    Daqmx(Daqmx),
}

/// The value of a property.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value {
    Number(f64),
    Text(String),
    /// Steps of 2^-64 s since the beginning of 1904 in UTC.
    Moment(i128),
}

/// Properties by name, those that a record needs.
pub(super) type Properties = HashMap<String, Value>;

/// What a channel holds, as it stands in the file.
#[derive(Debug, Default)]
pub(super) struct Data {
    pub numbers: Vec<f64>,
    pub stamps: Vec<i128>,
    /// Values of DAQmx by the number of the scale that they go to.
    pub scalers: BTreeMap<u32, Vec<f64>>,
    /// What it holds that is no series of numbers.
    pub other: Option<&'static str>,
}

/// The root, a group or a channel.
#[derive(Debug, Default)]
pub(super) struct Object {
    /// Nothing for the root, the group, or the group and the channel.
    pub path: Vec<String>,
    pub properties: Properties,
    pub data: Data,
    index: Option<Index>,
    /// Whether it is in the list of the segment.
    listed: bool,
    /// Whether it has raw data in the segment.
    active: bool,
}

/// Everything that the segments so far have named.
#[derive(Default)]
pub(super) struct Objects {
    pub known: Vec<Object>,
    by_path: HashMap<String, usize>,
    /// Objects of the segment, in the order of their raw data.
    list: Vec<usize>,
    /// Rises whenever raw data may stand otherwise than before.
    pub changes: u64,
}

impl Objects {
    /// Takes what a segment says about its objects.
    ///
    /// # Errors
    /// Texts or lists that are longer than the segment; types that are unknown; an index as before where there is none.
    pub fn update(&mut self, metadata: &[u8], little: bool, new_list: bool) -> Result<(), Broken> {
        if new_list {
            for id in self.list.drain(..) {
                if let Some(object) = self.known.get_mut(id) {
                    object.listed = false;
                }
            }
            self.changes += 1;
        }
        if metadata.is_empty() {
            return Ok(());
        }
        let mut from = Cursor::new(metadata, little);
        for _ in 0..from.u32()? {
            let path = from.text()?;
            let id = self.id(path)?;
            let Some(object) = self.known.get_mut(id) else { continue };
            if object.read_index(&mut from)? {
                self.changes += 1;
            }
            if !std::mem::replace(&mut object.listed, true) {
                self.list.push(id);
                self.changes += 1;
            }
            for _ in 0..from.u32()? {
                property(&mut from, &mut object.properties)?;
            }
        }
        Ok(())
    }

    /// Objects with raw data in this segment, in their order.
    pub fn active(&self) -> impl Iterator<Item = (usize, &Index)> {
        let object = |id: &usize| self.known.get(*id).filter(|object| object.active).map(|object| (*id, object));
        self.list.iter().filter_map(object).filter_map(|(id, object)| Some((id, object.index.as_ref()?)))
    }

    fn id(&mut self, path: String) -> Result<usize, Broken> {
        if let Some(id) = self.by_path.get(&path) {
            return Ok(*id);
        }
        let object = Object { path: split(&path)?, ..Object::default() };
        self.by_path.insert(path, self.known.len());
        self.known.push(object);
        Ok(self.known.len() - 1)
    }

    /// The properties of a group, or of the root.
    pub fn properties(&self, group: Option<&str>) -> Option<&Properties> {
        let path = group.map_or_else(|| "/".to_owned(), |group| format!("/'{}'", group.replace('\'', "''")));
        self.by_path.get(&path).and_then(|id| self.known.get(*id)).map(|object| &object.properties)
    }
}

impl Object {
    pub fn number(&self, property: &str) -> Option<f64> {
        match self.properties.get(property)? {
            Value::Number(number) => Some(*number),
            _ => None,
        }
    }

    pub fn text(&self, property: &str) -> Option<&str> {
        match self.properties.get(property)? {
            Value::Text(text) => Some(text.trim()).filter(|text| !text.is_empty()),
            _ => None,
        }
    }

    /// Reads how its raw data stand; gives whether that is otherwise than before.
    fn read_index(&mut self, from: &mut Cursor<'_>) -> Result<bool, Broken> {
        let header = from.u32()?;
        let before = self.active;
        self.active = header != NO_DATA;
        match header {
            NO_DATA => return Ok(before),
            AS_BEFORE if self.index.is_none() => {
                return Err(Broken::damaged("a channel has its data as before, where there were none"));
            }
            AS_BEFORE => return Ok(!before),
            _ => {}
        }
        self.index = Some(match Daqmx::read(header, from)? {
            Some(daqmx) => Index::Daqmx(daqmx),
            None => Index::Plain(plain(header, from)?),
        });
        Ok(true)
    }
}

/// An index of `length` bytes, the length among them.
fn plain(length: u32, from: &mut Cursor<'_>) -> Result<Plain, Broken> {
    let kind = Kind::of(from.u32()?)?;
    let (dimension, count) = (from.u32()?, from.u64()?);
    if dimension != 1 {
        return Err(Broken::damaged(format!("a channel has {dimension} dimensions, where there is one")));
    }
    let wanted = if kind == Kind::Text { 28 } else { 20 };
    if length != wanted {
        return Err(Broken::damaged(format!("the index of a channel has {length} bytes in place of {wanted}")));
    }
    let bytes = match kind.width() {
        Some(width) => count.checked_mul(width as u64),
        // Of each text at least where it ends.
        None if kind == Kind::Text => Some(from.u64()?).filter(|bytes| bytes / 4 >= count),
        None => Some(0).filter(|_| count == 0),
    };
    let bytes = bytes.ok_or_else(|| Broken::damaged(format!("a channel cannot have {count} values")))?;
    Ok(Plain { kind, count, bytes })
}

/// Reads a property, and keeps it where a record may need it.
fn property(from: &mut Cursor<'_>, into: &mut Properties) -> Result<(), Broken> {
    let name = from.text()?;
    let kind = Kind::of(from.u32()?)?;
    let little = from.little;
    let value = match (kind, kind.width()) {
        (Kind::Text, _) => Value::Text(from.text()?),
        (Kind::Stamp, _) => Value::Moment(moment(from.take(16)?, little)?),
        (_, Some(width)) => Value::Number(kind.number(from.take(width)?, little)),
        (_, None) => return Err(Broken::damaged(format!("the property `{name}` has no value"))),
    };
    if name.starts_with("NI_") || name.starts_with("wf_") || name == "unit_string" {
        into.insert(name, value);
    }
    Ok(())
}

/// The names of a path such as `/'group'/'channel'`, whose quotes are doubled within.
fn split(path: &str) -> Result<Vec<String>, Broken> {
    let wrong = || Broken::damaged(format!("`{}` is no path of a channel", path.escape_debug()));
    let mut names = Vec::new();
    let mut rest = if path == "/" { "" } else { path };
    while !rest.is_empty() {
        let mut inner = rest.strip_prefix("/'").ok_or_else(wrong)?;
        let mut name = String::new();
        loop {
            let (before, behind) = inner.split_once('\'').ok_or_else(wrong)?;
            name.push_str(before);
            let Some(again) = behind.strip_prefix('\'') else {
                rest = behind;
                break;
            };
            name.push('\'');
            inner = again;
        }
        names.push(name);
    }
    if names.len() > 2 { Err(wrong()) } else { Ok(names) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_split_at_single_quotes() {
        let of = |path| split(path).ok();
        let names = |names: &[&str]| Some(names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>());
        assert_eq!(of("/"), names(&[]));
        assert_eq!(of("/'a'"), names(&["a"]));
        assert_eq!(of("/'it''s / one'/'b'"), names(&["it's / one", "b"]));
        assert_eq!(of("/''/''''"), names(&["", "'"]));
        for wrong in ["", "a", "/'a", "/a'", "/'a''", "/'a'b", "/'a'/'b'/'c'"] {
            assert_eq!(of(wrong).filter(|names| !names.is_empty()), None, "{wrong}");
        }
    }
}
