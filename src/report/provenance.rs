//! What a result was made from: the version of this program, and each file by its digest.

use std::fmt::{self, Display, Formatter};
use std::path::Path;

use serde::Serialize;

use crate::record::Record;
use crate::report::table::fitted;
use crate::rig::Rig;

/// Digits of a digest that people read; enough to tell the files of a machine apart.
const DIGITS: usize = 12;

/// A file that a result was made from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct ReadFile {
    /// Path, as the user or the rig file named it.
    pub file: String,
    /// SHA-256 of what it held, in hexadecimal digits, without the byte-order mark of a rig file; empty for what came from no file.
    pub sha256: String,
}

/// What a result was made from. The same files and the same program give the same result, whatever the day and the machine.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Provenance {
    /// Version of this program.
    pub version: &'static str,
    /// The rig file, and behind it the files that it includes.
    pub rig_files: Vec<ReadFile>,
    /// The records, in the order of the command.
    pub records: Vec<ReadFile>,
}

impl Provenance {
    /// Of what was made from a rig file and records.
    pub fn of<'a>(rig: &Rig, records: impl IntoIterator<Item = &'a Record>) -> Self {
        let read =
            |(path, digest): (&Path, &str)| ReadFile { file: path.display().to_string(), sha256: digest.to_owned() };
        let records = records.into_iter().map(|record| (record.path.as_path(), record.origin.digest.as_str()));
        Self {
            version: env!("CARGO_PKG_VERSION"),
            rig_files: rig.files().map(read).collect(),
            records: records.map(read).collect(),
        }
    }

    /// A text with one line more that says it, as `--all` prints it.
    pub fn below(&self, mut text: String) -> String {
        if !text.ends_with('\n') {
            text.push('\n');
        }
        text.push_str(&fitted(&format!("\nMade from: {self}.\n")));
        text
    }
}

/// One line: *borescope 0.1.0; rig file rig.toml (9f86d081884c); record monday.csv (60303ae22b99)*.
impl Display for Provenance {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "borescope {}", self.version)?;
        for (what, files) in [("rig file", &self.rig_files), ("record", &self.records)] {
            for (number, ReadFile { file, sha256 }) in files.iter().enumerate() {
                let what = if what == "rig file" && number > 0 { "with" } else { what };
                write!(f, "; {what} {file}")?;
                // What came through a pipe has none.
                if let Some(start) = sha256.get(..DIGITS) {
                    write!(f, " ({start})")?;
                }
            }
        }
        Ok(())
    }
}

/// A result with what it was made from, as `--format json` writes it.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct WithProvenance<T> {
    /// The result.
    #[serde(flatten)]
    pub result: T,
    /// What it was made from.
    pub provenance: Provenance,
}
