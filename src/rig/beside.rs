//! Files that a rig file names by their path from its own folder: what they held, and how they are named from another folder.

#[cfg(feature = "cli")]
use std::fs;
use std::path::PathBuf;
#[cfg(feature = "cli")]
use std::path::{Component, Path};

#[cfg(feature = "cli")]
use toml_edit::{Item, Value};

#[cfg(feature = "cli")]
use super::{Rig, document};
#[cfg(feature = "cli")]
use crate::complaint::{Complaint, Kind, Place};
#[cfg(feature = "cli")]
use crate::files;

/// A file beside the rig file that was read with it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Beside {
    /// As it is named from the folder that the program runs in.
    pub path: PathBuf,
    /// SHA-256 of what it held, in hexadecimal digits.
    pub digest: String,
}

#[cfg(feature = "cli")]
impl Rig {
    /// The rig file and those that it names, each with its digest.
    pub(crate) fn files(&self) -> impl Iterator<Item = (&Path, &str)> {
        let beside = self.beside.iter().map(|file| (file.path.as_path(), file.digest.as_str()));
        std::iter::once((self.path.as_path(), self.own_digest.as_str())).chain(beside)
    }

    /// What tells this rig file from others: the digest of its own text, and where it names other files, of these too.
    pub(crate) fn digest(&self) -> String {
        if self.beside.is_empty() {
            return self.own_digest.clone();
        }
        let all: Vec<&str> = self.files().map(|(_, digest)| digest).collect();
        files::digest(all.join("\n").as_bytes())
    }

    /// The text of this rig file, or of one made of it, as it has to be where it is written to: files beside it are named from
    /// there.
    ///
    /// # Errors
    /// A file that has no path from there, such as one on another drive.
    pub(crate) fn text_at(&self, text: &str, output: &Path) -> Result<String, Complaint> {
        // What does not name a file would be printed in another order at worst.
        if self.beside.is_empty() {
            return Ok(text.to_owned());
        }
        let (from, to) = (folder(&self.path), folder(output));
        let (Ok(from), Ok(to)) = (fs::canonicalize(from), fs::canonicalize(to)) else { return Ok(text.to_owned()) };
        if from == to || output == Path::new("-") || output.starts_with("/dev") {
            return Ok(text.to_owned());
        }
        let mut document = document(&self.path, text)?;
        let moved = |value: &mut Value| -> Result<(), Complaint> {
            let Some(name) = value.as_str() else { return Ok(()) };
            let decor = value.decor().clone();
            *value = Value::from(between(&to, &from, Path::new(name)).ok_or_else(|| {
                Complaint::new(Kind::Contradiction, format!("`{name}` has no path from where the rig file is written"))
                    .at(Place::file(output))
                    .help("write the rig file onto the drive of the files that it includes")
            })?);
            *value.decor_mut() = decor;
            Ok(())
        };
        if let Some(Item::Value(include)) = document.get_mut("include") {
            match include {
                Value::Array(files) => files.iter_mut().try_for_each(moved)?,
                file => moved(file)?,
            }
        }
        let own = document.get_mut("own_components").and_then(Item::as_table_like_mut);
        for (_, kind) in own.into_iter().flat_map(|own| own.iter_mut()) {
            let tables = kind.get_mut("tables").and_then(Item::as_table_like_mut);
            for (_, line) in tables.into_iter().flat_map(|tables| tables.iter_mut()) {
                let file = if line.is_str() { Some(line) } else { line.get_mut("file") };
                file.and_then(Item::as_value_mut).map_or(Ok(()), moved)?;
            }
        }
        Ok(document.to_string())
    }
}

#[cfg(feature = "cli")]
fn folder(path: &Path) -> &Path {
    let folder = path.parent().unwrap_or(Path::new(""));
    if folder.as_os_str().is_empty() { Path::new(".") } else { folder }
}

/// How a file that `from` names is named from the folder `to`; both folders without links.
#[cfg(feature = "cli")]
fn between(to: &Path, from: &Path, name: &Path) -> Option<String> {
    // The folder of a file that is named may be behind a link, which `..` would not come back over.
    let whole = from.join(name);
    let file = fs::canonicalize(folder(&whole))
        .map_or(whole.clone(), |folder| folder.join(whole.file_name().unwrap_or_default()));
    let shared = to.components().zip(file.components()).take_while(|(a, b)| a == b).count();
    if shared == 0 {
        return None;
    }
    let up = to.components().skip(shared).map(|_| "..".to_owned());
    let down = file.components().skip(shared).map(|part| match part {
        Component::Normal(part) => part.to_str().map(str::to_owned),
        _ => None,
    });
    let parts: Option<Vec<String>> = up.map(Some).chain(down).collect();
    parts.map(|parts| parts.join("/"))
}

#[cfg(all(test, feature = "cli"))]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_named_from_where_the_rig_file_goes() {
        let named = |to: &str, name: &str| between(Path::new(to), Path::new("/a/rig"), Path::new(name)).unwrap();
        assert_eq!(named("/a/rig/new", "parts.toml"), "../parts.toml");
        assert_eq!(named("/a", "sub/parts.toml"), "rig/sub/parts.toml");
        assert_eq!(named("/b", "parts.toml"), "../a/rig/parts.toml");
    }
}
