//! The catalogue: component kinds as files of formulas that the program brings along.

use std::sync::LazyLock;

use toml::de::DeTable;

use super::own_component::{OwnKind, read_own_component};
use crate::complaint::Complaint;
use crate::rig::source::{Source, Table};

/// How a component names a kind of the catalogue.
const CATALOGUE: &str = "catalogue:";

macro_rules! files {
    ($($name:literal),+ $(,)?) => {
        /// Name and text of each file; a new one is its file and its line.
        const FILES: &[(&str, &str)] =
            &[$(($name, include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/catalogue/", $name, ".toml")))),+];
    };
}

files! {
    "closed-loop-pump",
    "compensated-flow-control",
    "counterbalance-valve",
    "double-rod-cylinder",
    "filter",
    "flow-divider",
    "flushing-shuttle",
    "load-sensing-pump",
    "motor",
    "one-way-throttle",
    "pressure-reducing-valve",
    "quick-exhaust-valve",
    "sequence-valve",
    "servo-valve",
    "shuttle-valve",
    "solenoid-valve",
}

/// Kinds as components name them, each with what its file gave.
type Catalogue = Vec<(String, Result<OwnKind, Complaint>)>;

/// All of them, read when the first is asked for.
static KINDS: LazyLock<Catalogue> = LazyLock::new(|| read_all(FILES));

fn read_all(files: &[(&str, &str)]) -> Catalogue {
    files.iter().map(|(name, text)| (format!("{CATALOGUE}{name}"), read(name, text))).collect()
}

fn read(name: &str, text: &str) -> Result<OwnKind, Complaint> {
    let source = Source::new(format!("catalogue/{name}.toml"), text.to_owned());
    let document = DeTable::parse(&source.text).map_err(|error| super::not_toml(&source, &error))?;
    let root = Table::new(&source, "the catalogue", 0..0, document.get_ref());
    let own = root.require("own_components", "add `[own_components.NAME]`")?.table("`[own_components]`")?;
    let kind = read_own_component(&format!("{CATALOGUE}{name}"), &own.require(name, "name it as its file")?)?;
    own.finish()?;
    root.finish()?;
    Ok(kind)
}

/// Every kind of the catalogue, in the order of their names.
///
/// # Errors
/// What is wrong with the first file that does not read.
#[cfg(feature = "cli")]
pub(crate) fn kinds() -> Result<Vec<&'static OwnKind>, Complaint> {
    KINDS.iter().map(|(_, kind)| kind.as_ref().map_err(Clone::clone)).collect()
}

/// What components call the kinds of the catalogue.
pub(super) fn names() -> impl Iterator<Item = &'static str> {
    KINDS.iter().map(|(name, _)| name.as_str())
}

/// The kind of this name; a rig file that names none of the catalogue does not have it read.
///
/// # Errors
/// What is wrong with its file.
pub(super) fn find(kind: &str) -> Result<Option<&'static OwnKind>, Complaint> {
    if kind.starts_with(CATALOGUE) { find_in(&KINDS, kind) } else { Ok(None) }
}

fn find_in<'a>(catalogue: &'a Catalogue, kind: &str) -> Result<Option<&'a OwnKind>, Complaint> {
    let found = catalogue.iter().find(|(name, _)| name == kind);
    found.map(|(_, read)| read.as_ref().map_err(Clone::clone)).transpose()
}

/// The text of the file of a kind, as a rig file names it.
#[cfg(feature = "cli")]
pub(crate) fn source(kind: &str) -> Option<&'static str> {
    let name = kind.strip_prefix(CATALOGUE)?;
    FILES.iter().find(|(own, _)| *own == name).map(|(_, text)| *text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_reads_and_its_worked_number_comes_out() {
        for (name, text) in FILES {
            // A number that does not come out is a complaint of the reading.
            let kind = read(name, text).unwrap_or_else(|complaint| panic!("{complaint}"));
            assert!(!kind.card.worked.is_empty(), "{name} has no worked number");
            for words in [kind.card.meaning, kind.card.source, kind.card.validity] {
                assert!(!words.is_empty() && !words.contains("rig file"), "{name}: {words}");
            }
            let about = kind
                .card
                .parameters
                .iter()
                .map(|own| own.meaning)
                .chain(kind.card.ports.iter().map(|port| port.meaning));
            about.for_each(|meaning| assert!(!meaning.is_empty(), "{name}: a meaning is missing"));
        }
        assert_eq!(KINDS.len(), FILES.len());
        assert!(FILES.is_sorted());
    }

    #[test]
    fn a_file_that_does_not_read_is_complained_about_where_it_is_named() {
        let good = FILES[0];
        let broken = ("filter", "[own_components.filter]\nports = { in = \"hydraulic\" }\n");
        let catalogue = read_all(&[good, broken]);
        assert!(find_in(&catalogue, &format!("catalogue:{}", good.0)).unwrap().is_some());
        assert!(find_in(&catalogue, "catalogue:none").unwrap().is_none());
        let complaint = find_in(&catalogue, "catalogue:filter").unwrap_err();
        assert!(complaint.to_string().contains("catalogue/filter.toml"), "{complaint}");
    }
}
