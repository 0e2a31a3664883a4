//! Records in MATLAB files, v5 to v7.2: vectors beside each other or in structures, each with its own time.

mod element;

use std::collections::HashMap;

use super::bytes::{Broken, part};
use super::groups::{Column, Group, Groups, is_time};
pub(super) use element::Value;
use element::{Budget, Elements};
#[cfg(feature = "hdf5")]
pub(super) use element::{DEEPEST, MOST_NUMBERS};

/// Bytes before the first variable.
const HEADER: usize = 128;

/// The series of a file; `most` is how many bytes may be unpacked.
pub(super) fn read(bytes: &[u8], most: u64) -> Result<Groups, Broken> {
    let little = match part(bytes, HEADER - 2, 2)? {
        b"IM" => true,
        b"MI" => false,
        _ => return Err(Broken::damaged("its header does not say in which order its bytes are")),
    };
    let mut elements = Elements { bytes, at: HEADER, little };
    let mut budget = Budget::new(most);
    let mut variables = Vec::new();
    while !elements.is_done() {
        variables.push(elements.variable(&mut budget)?);
    }
    let mut groups = Groups::default();
    gather(&mut groups, "", variables);
    Ok(groups)
}

/// Vectors of one structure, or of the file itself, as a group; those of structures within as groups of their own.
pub(super) fn gather(groups: &mut Groups, path: &str, variables: Vec<(String, Value)>) {
    let units = units(&variables);
    let mut group = Group { name: path.to_owned(), ..Group::default() };
    let mut inner = Vec::new();
    for (name, value) in variables {
        let full = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
        match value {
            Value::Numbers { sizes, values } if sizes.iter().filter(|size| **size != 1).count() == 1 => {
                let unit = units.get(&name).cloned();
                if is_time(&name) {
                    group.time = values;
                    group.time_unit = unit.unwrap_or_else(|| "s".to_owned());
                } else {
                    group.columns.push(Column { name, unit, values });
                }
            }
            Value::Fields(_) if name.eq_ignore_ascii_case(UNITS) => {}
            Value::Fields(fields) => inner.push((full, fields)),
            Value::Numbers { sizes, .. } if sizes.iter().all(|size| *size == 1) => groups.leave(full, "one number"),
            Value::Numbers { .. } => groups.leave(full, "no vector"),
            Value::Text(_) => groups.leave(full, "text"),
            Value::Other(what) => groups.leave(full, what),
        }
    }
    groups.push(group);
    for (path, fields) in inner {
        gather(groups, &path, fields);
    }
}

/// The structure whose fields name the units of the vectors beside it.
pub(super) const UNITS: &str = "units";

fn units(variables: &[(String, Value)]) -> HashMap<String, String> {
    let table = variables.iter().find(|(name, _)| name.eq_ignore_ascii_case(UNITS));
    let Some((_, Value::Fields(fields))) = table else { return HashMap::new() };
    let text = |(name, value): &(String, Value)| match value {
        Value::Text(text) => Some((name.clone(), text.trim().to_owned())),
        _ => None,
    };
    fields.iter().filter_map(text).collect()
}
