//! The kinds of components that a rig file may name: built in, its own, and those of files that it includes.

use std::path::{Path, PathBuf};

use toml::de::DeTable;

use super::catalogue;
use super::own_component::{OwnKind, read_own_component};
use crate::complaint::{Complaint, Kind, did_you_mean, help_with_near};
use crate::physics::card::Card;
use crate::physics::component;
use crate::rig::Beside;
use crate::rig::source::{Source, Table, Value};

/// How a component names a kind of the rig file's own.
const OWN: &str = "own:";
/// Deeper than this no library of files is nested that people still understand.
const MOST_NESTED: usize = 8;

/// Kinds of the rig file's own.
#[derive(Default)]
pub(super) struct Kinds {
    own: Vec<OwnKind>,
    /// Files that were read, each once.
    read: Vec<PathBuf>,
    /// What they held, in the order in which they were read.
    pub(super) beside: Vec<Beside>,
}

/// A kind that a component names.
#[derive(Clone, Copy)]
pub(super) enum Found<'a> {
    BuiltIn(&'static Card),
    Own(&'a OwnKind),
}

impl Found<'_> {
    pub fn card(self) -> &'static Card {
        match self {
            Self::BuiltIn(card) => card,
            Self::Own(own) => own.card,
        }
    }
}

impl Kinds {
    /// The kinds of a rig file, and of the files that it includes.
    pub fn of(source: &Source, root: &Table<'_>) -> Result<Self, Complaint> {
        let mut kinds = Self::default();
        kinds.read_file(root, &mut vec![canonical(&source.path)])?;
        Ok(kinds)
    }

    /// `within` are the files that include this one, itself the last.
    fn read_file(&mut self, root: &Table<'_>, within: &mut Vec<PathBuf>) -> Result<(), Complaint> {
        if let Some(files) = root.get("include") {
            for file in files.one_or_more()? {
                self.include(&file, within)?;
            }
        }
        let Some(own) = root.get("own_components") else { return Ok(()) };
        for (name, value) in own.table("`[own_components]`")?.named_entries()? {
            let kind = read_own_component(&format!("{OWN}{name}"), &value)?;
            if let Some(other) = self.own.iter().find(|other| other.card.kind == kind.card.kind) {
                return Err(Complaint::new(Kind::Duplicate, format!("the component kind `{name}` is described twice"))
                    .at(other.place.clone())
                    .at(kind.place)
                    .help("take another name for one of them"));
            }
            self.beside.extend(kind.files.iter().cloned());
            self.own.push(kind);
        }
        Ok(())
    }

    fn include(&mut self, file: &Value<'_>, within: &mut Vec<PathBuf>) -> Result<(), Complaint> {
        let name = Path::new(file.text()?);
        if name.is_absolute() {
            return Err(Complaint::new(Kind::Contradiction, "a rig file includes what stands beside it")
                .at(file.place())
                .help("write the path from the folder of this file, such as `include = [\"valves.toml\"]`"));
        }
        let path = file.beside(file.text()?);
        let whole = canonical(&path);
        if within.contains(&whole) {
            return Err(Complaint::new(Kind::Contradiction, format!("`{}` includes itself", name.display()))
                .at(file.place())
                .help("leave this line out, here or in the file between"));
        }
        if within.len() == MOST_NESTED {
            return Err(Complaint::new(Kind::Bounds, format!("files include each other more than {MOST_NESTED} deep"))
                .at(file.place())
                .help("include them from the rig file"));
        }
        if self.read.contains(&whole) {
            return Ok(());
        }
        let text = crate::files::read_text(&path).map_err(|complaint| complaint.at(file.place()))?;
        self.beside.push(Beside { path: path.clone(), digest: crate::files::digest(text.as_bytes()) });
        let source = Source::new(path, text);
        let document = DeTable::parse(&source.text).map_err(|error| super::not_toml(&source, &error))?;
        let root = Table::new(&source, "the included file", 0..0, document.get_ref());
        within.push(whole.clone());
        self.read_file(&root, within)?;
        within.pop();
        self.read.push(whole);
        root.finish()
    }

    /// The kind that a component names.
    pub fn find(&self, kind: &Value<'_>) -> Result<Found<'_>, Complaint> {
        let name = kind.text()?;
        let own = match self.own.iter().find(|own| own.card.kind == name) {
            Some(own) => Some(own),
            None => catalogue::find(name)?,
        };
        let own = own.map(Found::Own);
        own.or_else(|| component::card(name).map(Found::BuiltIn)).ok_or_else(|| {
            Complaint::new(Kind::UnknownName, format!("unknown component kind `{name}`"))
                .at(kind.place())
                .help(help_with_near(self.meant(name), "component kinds", self.names()))
        })
    }

    /// The kind that was probably meant: one of the catalogue or of the rig file without its prefix, or the nearest name.
    fn meant(&self, name: &str) -> Option<&'static str> {
        let without_prefix = |kind: &&'static str| kind.split_once(':').is_some_and(|(_, own)| own == name);
        self.names().find(without_prefix).or_else(|| did_you_mean(name, self.names()))
    }

    /// All kinds that there are.
    pub fn names(&self) -> impl Iterator<Item = &'static str> + '_ {
        let own = self.own.iter().map(|own| own.card.kind);
        component::CARDS.iter().map(|card| card.kind).chain(own).chain(catalogue::names())
    }
}

/// The one path of a file; of one that cannot be found, as it is written.
fn canonical(path: &Path) -> PathBuf {
    std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned())
}
