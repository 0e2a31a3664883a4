//! Records in HDF5, and so in MATLAB v7.3: vectors in groups, tables of named fields, frames of pandas; units from attributes.

mod frame;
mod number;

use std::collections::HashSet;

use hdf5_reader::error::Error;
use hdf5_reader::{Attribute, Dataset, Datatype, Hdf5File, OpenOptions};

use super::bytes::Broken;
use super::groups::{Groups, split_name};
use super::mat::{DEEPEST, MOST_NUMBERS, UNITS, Value, gather};
use super::unharmed::unharmed;
use number::Numeric;

/// Most objects of a file: links cost few bytes, and each is an object once more.
const MOST_OBJECTS: usize = 1 << 16;
/// Most bytes that one byte of the file unpacks to; deflate reaches 1032.
const MOST_RATIO: usize = 1100;
/// Attributes that hold the unit of their dataset.
const UNIT_NAMES: &[&str] = &["unit", "units", "unit_string"];

/// The series of a file; `most` is how many bytes may be unpacked.
pub(super) fn read(bytes: &[u8], most: u64) -> Result<Groups, Broken> {
    // The library is hardened against damage, and yet it is not ours.
    unharmed(|| read_trusting(bytes, most)).unwrap_or_else(|| Err(Broken::damaged("its parts contradict each other")))
}

fn read_trusting(bytes: &[u8], most: u64) -> Result<Groups, Broken> {
    let most = usize::try_from(most).unwrap_or(usize::MAX).min(bytes.len().saturating_mul(MOST_RATIO));
    let options = OpenOptions::default().with_max_read_bytes(most).with_max_chunk_bytes(most);
    let file = Hdf5File::from_vec_with_options(bytes.to_vec(), options).map_err(broken)?;
    let mut walk = Walk { numbers: most.min(MOST_NUMBERS), objects: MOST_OBJECTS, seen: HashSet::new() };
    let variables = walk.group(&file.root_group().map_err(broken)?, 0)?;
    let mut groups = Groups::default();
    gather(&mut groups, "", variables);
    Ok(groups)
}

/// What the library found wrong.
fn broken(error: Error) -> Broken {
    match error {
        Error::Context { source, .. } => broken(*source),
        Error::ResourceLimit(_) => Broken::TooLarge,
        error => Broken::Damaged(error.to_string()),
    }
}

/// What a group holds, and beside it the units in attributes and names, as `units` of a MATLAB file.
#[derive(Default)]
struct Variables {
    values: Vec<(String, Value)>,
    units: Vec<(String, Value)>,
}

impl Variables {
    /// Takes what is called `head`, with a unit in its name where it has none of its own.
    fn take(&mut self, head: &str, unit: Option<String>, value: Value) {
        let (name, within) = split_name(head);
        // Two of one name in different units are two: the second keeps its whole name.
        if self.values.iter().any(|(taken, _)| *taken == name) {
            self.values.push((head.to_owned(), Value::Other("its name comes twice")));
            return;
        }
        self.units.extend(unit.or(within).map(|unit| (name.clone(), Value::Text(unit))));
        self.values.push((name, value));
    }

    fn with_units(mut self) -> Vec<(String, Value)> {
        self.values.push((UNITS.to_owned(), Value::Fields(self.units)));
        self.values
    }
}

/// The way through a file, and what may still be taken of it.
struct Walk {
    numbers: usize,
    objects: usize,
    /// Groups by their address: links may lead in a circle.
    seen: HashSet<u64>,
}

impl Walk {
    fn group(&mut self, group: &hdf5_reader::group::Group, depth: usize) -> Result<Vec<(String, Value)>, Broken> {
        self.seen.insert(group.address());
        let (groups, datasets) = group.members().map_err(broken)?;
        self.objects = self.objects.checked_sub(groups.len() + datasets.len()).ok_or(Broken::TooLarge)?;
        if frame::is_frame(group) {
            return self.frame(&datasets);
        }
        let mut variables = Variables::default();
        // MATLAB keeps what cells and objects refer to in groups of its own.
        for dataset in datasets.iter().filter(|dataset| !dataset.name().starts_with('#')) {
            let value = self.dataset(dataset)?;
            variables.take(dataset.name(), unit_of(dataset), value);
        }
        for inner in groups.iter().filter(|group| !group.name().starts_with('#')) {
            let value = if depth >= DEEPEST {
                Value::Other("too deep within other groups")
            } else if self.seen.contains(&inner.address()) {
                Value::Other("a group once more")
            } else {
                Value::Fields(self.group(inner, depth + 1)?)
            };
            match value {
                Value::Fields(own) if inner.name().eq_ignore_ascii_case(UNITS) => variables.units.extend(own),
                value => variables.values.push((inner.name().to_owned(), value)),
            }
        }
        Ok(variables.with_units())
    }

    fn dataset(&mut self, dataset: &Dataset) -> Result<Value, Broken> {
        let class = attribute(dataset, "MATLAB_class");
        if dataset.attribute("MATLAB_empty").is_ok() {
            return Ok(Value::Other("empty"));
        }
        match dataset.dtype() {
            Datatype::Compound { size, fields } => {
                let Some(raw) = self.raw(dataset, fields.len())? else { return Ok(PACKED) };
                let stride = *size as usize;
                let mut variables = Variables::default();
                for field in fields {
                    let value = Numeric::of(&field.datatype).map_or(Value::Other("no numbers"), |numeric| {
                        Value::vector(numeric.series(&raw, field.byte_offset as usize, stride))
                    });
                    variables.take(&field.name, None, value);
                }
                Ok(Value::Fields(variables.with_units()))
            }
            Datatype::String { .. } | Datatype::VarLen { .. } => {
                Ok(dataset.read_string().map_or(Value::Other("text"), Value::Text))
            }
            Datatype::Reference { .. } => Ok(Value::Other("a cell array")),
            dtype => match (Numeric::of(dtype), class.as_deref()) {
                (Some(numeric), Some("char")) => {
                    let Some(raw) = self.raw(dataset, 1)? else { return Ok(PACKED) };
                    let units = numeric.series(&raw, 0, numeric.width).into_iter().map(|letter| letter as u16);
                    Ok(Value::Text(String::from_utf16_lossy(&units.collect::<Vec<u16>>())))
                }
                (Some(_), Some(class)) if !number::is_class(class) => {
                    Ok(Value::Other("an object of a class of MATLAB"))
                }
                (Some(numeric), _) => {
                    let sizes: Vec<usize> = dataset.shape().iter().map(|size| *size as usize).collect();
                    // A matrix is no series, and need not be unpacked.
                    if sizes.iter().filter(|size| **size != 1).count() > 1 {
                        return Ok(Value::Numbers { sizes, values: Vec::new() });
                    }
                    let Some(raw) = self.raw(dataset, 1)? else { return Ok(PACKED) };
                    Ok(Value::Numbers { sizes, values: numeric.series(&raw, 0, numeric.width) })
                }
                (None, _) => Ok(Value::Other("no numbers")),
            },
        }
    }

    /// The bytes of a dataset of so many `fields`; none where it is packed in a way that is not read.
    fn raw(&mut self, dataset: &Dataset, fields: usize) -> Result<Option<Vec<u8>>, Broken> {
        let rows = usize::try_from(dataset.num_elements().map_err(broken)?).unwrap_or(usize::MAX);
        let count = rows.saturating_mul(fields);
        self.numbers = self.numbers.checked_sub(count).ok_or(Broken::TooLarge)?;
        match dataset.read_raw_bytes() {
            Ok(raw) => Ok(Some(raw)),
            Err(error) if is_unread(&error) => Ok(None),
            Err(error) => Err(broken(error)),
        }
    }
}

const PACKED: Value = Value::Other("packed in a way that is not read");

/// Whether it is right and only not read.
fn is_unread(error: &Error) -> bool {
    match error {
        Error::Context { source, .. } => is_unread(source),
        error => matches!(error, Error::UnsupportedFilter(_) | Error::UnsupportedEncoding(_)),
    }
}

/// The text of an attribute.
fn attribute(dataset: &Dataset, name: &str) -> Option<String> {
    dataset.attribute(name).ok().and_then(|attribute| text(&attribute))
}

fn text(attribute: &Attribute) -> Option<String> {
    attribute.read_string().ok().map(|text| text.trim_matches(['\0', ' ']).to_owned())
}

/// The unit that an attribute names.
fn unit_of(dataset: &Dataset) -> Option<String> {
    let names = |attribute: &Attribute| UNIT_NAMES.iter().any(|name| attribute.name.eq_ignore_ascii_case(name));
    dataset.attributes().iter().find(|attribute| names(attribute)).and_then(text).filter(|unit| !unit.is_empty())
}
