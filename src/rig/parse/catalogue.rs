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
    "compensated-flow-control",
    "counterbalance-valve",
    "filter",
    "flow-divider",
    "load-sensing-pump",
    "motor",
    "one-way-throttle",
    "pressure-reducing-valve",
    "quick-exhaust-valve",
    "sequence-valve",
    "shuttle-valve",
}

/// All of them, read when the first is asked for.
static KINDS: LazyLock<Vec<OwnKind>> =
    LazyLock::new(|| FILES.iter().filter_map(|(name, text)| read(name, text).ok()).collect());

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
pub(crate) fn kinds() -> &'static [OwnKind] {
    &KINDS
}

/// The kind of this name; a rig file that names none of the catalogue does not have it read.
pub(super) fn find(kind: &str) -> Option<&'static OwnKind> {
    kind.starts_with(CATALOGUE).then(|| kinds().iter().find(|own| own.card.kind == kind))?
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
        assert_eq!(kinds().len(), FILES.len());
        assert!(FILES.is_sorted());
    }
}
