//! A list of records: a table with a line for each.

use std::collections::HashMap;
use std::path::{Component, Path, PathBuf};

use crate::complaint::{Complaint, Kind, Place};
use crate::files;
use crate::store::Moment;

/// Largest manifest, bytes: a few million lines.
const MOST: u64 = 1 << 30;
/// Columns that are read.
const COLUMNS: [&str; 3] = ["record", "rig", "measured_at"];

/// One record.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Relative to the folder of the manifest, where it is not absolute.
    pub record: PathBuf,
    /// Name of the machine; `None` where all records are of the rig file's.
    pub rig: Option<String>,
    /// `None`: the time of the record's file.
    pub measured_at: Option<Moment>,
}

/// The records of a manifest.
#[derive(Debug, Clone, PartialEq)]
pub struct Manifest {
    pub path: PathBuf,
    /// Of its text.
    pub digest: String,
    pub entries: Vec<Entry>,
    /// Columns that say nothing here.
    pub unread: Vec<String>,
}

impl Manifest {
    /// Reads a table with commas, semicolons or tabs between the columns `record` and, if wanted, `rig` and `measured_at`.
    ///
    /// # Errors
    /// A table without the column `record` or without lines, fields that are missing or wrong, and a record that comes twice.
    pub fn read(path: &Path) -> Result<Self, Complaint> {
        let bytes = files::read(path, MOST)?.bytes;
        let digest = files::digest(&bytes);
        let text = files::text(path, bytes)?;
        let head = text.lines().next().unwrap_or_default();
        let separator = [b';', b'\t'].into_iter().find(|&one| head.as_bytes().contains(&one)).unwrap_or(b',');
        let mut table = csv::ReaderBuilder::new()
            .delimiter(separator)
            .trim(csv::Trim::All)
            .has_headers(false)
            .flexible(true)
            .from_reader(text.as_bytes());
        let mut lines = table.records().map(|line| line.map_err(|error| unread(path, &error)));
        let Some(head) = lines.next().transpose()? else {
            return Err(Complaint::new(Kind::Empty, "the list of records is empty").in_file(path).help(EXAMPLE));
        };
        let column = |name: &str| head.iter().position(|one| one == name);
        for name in COLUMNS {
            if head.iter().filter(|one| *one == name).count() > 1 {
                let what = format!("the column `{name}` comes twice");
                return Err(Complaint::new(Kind::Duplicate, what).at(Place::line(path, 1)).help("leave one away"));
            }
        }
        let Some(records) = column("record") else {
            return Err(Complaint::new(Kind::MissingEntry, "the list has no column `record`")
                .at(Place::line(path, 1))
                .help(EXAMPLE));
        };
        let (rig, measured_at) = (column("rig"), column("measured_at"));
        let folder = path.parent().unwrap_or(Path::new(""));
        let (mut entries, mut seen) = (Vec::new(), HashMap::new());
        for fields in lines {
            let fields = fields?;
            let line = fields.position().map_or(0, |at| at.line() as usize);
            let wrong = |kind, what: String| Complaint::new(kind, what).at(Place::line(path, line));
            if fields.len() != head.len() {
                let what = format!("{} fields, where the head has {}", fields.len(), head.len());
                return Err(
                    wrong(Kind::Shape, what).help("write a field for each column; a path with a comma in quotes")
                );
            }
            let field =
                |column: Option<usize>| column.and_then(|column| fields.get(column)).filter(|text| !text.is_empty());
            let Some(name) = field(Some(records)) else {
                return Err(wrong(Kind::MissingEntry, "the field `record` is empty".to_owned()).help("name a file"));
            };
            let record = folder.join(name);
            if let Some(before) = seen.insert(plain(&record), line) {
                return Err(Complaint::new(Kind::Duplicate, format!("`{name}` comes twice"))
                    .at(Place::line(path, before))
                    .at(Place::line(path, line))
                    .help("leave one away: each record counts once"));
            }
            let at = field(measured_at).map(str::parse::<Moment>).transpose();
            let at = at.map_err(|complaint| complaint.at(Place::line(path, line)))?;
            entries.push(Entry { record, rig: field(rig).map(str::to_owned), measured_at: at });
        }
        if entries.is_empty() {
            return Err(Complaint::new(Kind::Empty, "the list has no records").in_file(path).help(EXAMPLE));
        }
        let unread = head.iter().filter(|name| !COLUMNS.contains(name)).map(str::to_owned).collect();
        Ok(Self { path: path.to_path_buf(), digest, entries, unread })
    }
}

/// A path without detours: `./a.csv` and `b/../a.csv` are `a.csv`. No file is looked at, as there may be very many, far away.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir if matches!(plain.components().next_back(), Some(Component::Normal(_))) => {
                plain.pop();
            }
            other => plain.push(other),
        }
    }
    plain
}

const EXAMPLE: &str = "begin it with a line `record`, or `record,rig,measured_at`, and name a file in each line below";

fn unread(path: &Path, error: &csv::Error) -> Complaint {
    let place = error.position().map_or_else(|| Place::file(path), |at| Place::line(path, at.line() as usize));
    Complaint::new(Kind::Syntax, format!("the list of records cannot be read: {error}")).at(place).help(EXAMPLE)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Manifest, Complaint> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("list.csv");
        std::fs::write(&path, text).unwrap();
        Manifest::read(&path)
    }

    #[test]
    fn records_are_beside_their_list() {
        let list = read("\u{feff}note; record; measured_at;rig\nx;a.csv;2026-05-01;press 1\n;/b.csv;;\n").unwrap();
        assert_eq!(list.unread, ["note"]);
        let [a, b] = list.entries.as_slice() else { panic!("{list:?}") };
        assert_eq!(a.record, list.path.with_file_name("a.csv"));
        assert_eq!(
            (a.rig.as_deref(), a.measured_at.unwrap().short()),
            (Some("press 1"), "2026-05-01 00:00 UTC".to_owned())
        );
        assert_eq!(b, &Entry { record: PathBuf::from("/b.csv"), rig: None, measured_at: None });
    }

    #[test]
    fn what_is_wrong_is_told_with_its_line() {
        for (text, told) in [
            ("", "list.csv: the list of records is empty"),
            ("record\n", "list.csv: the list has no records"),
            ("file\na.csv\n", "list.csv:1: the list has no column `record`"),
            ("record,record\na,b\n", "list.csv:1: the column `record` comes twice"),
            ("record,rig\na.csv,1\nb.csv\n", "list.csv:3: 1 fields, where the head has 2"),
            ("record,rig\n,1\n", "list.csv:2: the field `record` is empty"),
            ("record\na.csv\nb.csv\na.csv\n", "list.csv:4: `a.csv` comes twice"),
            ("record\na.csv\n./b/../a.csv\n", "list.csv:3: `./b/../a.csv` comes twice"),
            ("record,measured_at\na.csv,noon\n", "list.csv:2: `noon` is no moment"),
        ] {
            let error = read(text).unwrap_err().to_string();
            assert!(error.contains(told), "{text:?}: {error}");
            assert!(error.contains("help: "), "{error}");
        }
    }
}
