//! A file that grows row by row, and that an interruption leaves with whole rows.

use std::fs::{self, File, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::Form;
use crate::complaint::{Complaint, Kind, Place};
use crate::context::Context;
use crate::files;

/// Name of the file in its folder.
pub const JOURNAL: &str = "journal.jsonl";
/// How often a journal that another program holds is asked for: often enough for Ctrl-C, which ends a wait in a fifth of a second.
const ASK_AGAIN: Duration = Duration::from_millis(100);

/// First line of a journal.
#[derive(Debug, Serialize, Deserialize)]
struct Header {
    schema: String,
    digest: String,
}

/// How somebody waits for a journal that another program writes.
pub struct Hold<'a> {
    /// Ends the wait where it is cancelled.
    pub context: &'a Context,
    /// Told once that there is a wait.
    pub waiting: fn(&Path),
}

/// Finished rows, one line of JSON each, behind a header. Whoever has it open is the only one to write it.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
}

impl Journal {
    /// Begins a journal in a folder, which is created where it is missing.
    ///
    /// # Errors
    /// A folder that holds a journal already, or cannot be written.
    pub fn begin(folder: &Path, form: &Form, digest: &str) -> Result<Self, Complaint> {
        let (file, path) = open(folder)?;
        let is_held = matches!(file.try_lock(), Err(TryLockError::WouldBlock));
        if is_held || file.metadata().map_err(|error| unwritable(&path, &error))?.len() > 0 {
            let what = format!("the folder holds the journal of {} already", form.whole);
            return Err(Complaint::new(Kind::Contradiction, what)
                .at(Place::file(&path))
                .help("add `--resume` to go on with it, or name another folder"));
        }
        let mut journal = Self { path, file };
        journal.write_header(form, digest)?;
        Ok(journal)
    }

    /// Goes on with the journal of a folder, or begins one; a line that was cut off is dropped. The rows come with it.
    ///
    /// # Errors
    /// A journal of other work; lines that are no rows; files that cannot be read or written; a wait that was cancelled.
    pub fn resume<R: DeserializeOwned>(
        folder: &Path,
        form: &Form,
        digest: &str,
        hold: &Hold<'_>,
    ) -> Result<(Self, Vec<R>), Complaint> {
        let (file, path) = open(folder)?;
        wait_for(&file, &path, hold)?;
        let mut journal = Self { path, file };
        let text = whole_lines(&journal.path)?;
        let length = text.len() as u64;
        journal.file.set_len(length).map_err(|error| unwritable(&journal.path, &error))?;
        if length == 0 {
            journal.write_header(form, digest)?;
            return Ok((journal, Vec::new()));
        }
        let rows = rows(&journal.path, &text, form, digest)?;
        Ok((journal, rows))
    }

    /// The rows of a journal that nobody writes any more.
    ///
    /// # Errors
    /// As of [`resume`](Self::resume), and a journal that is missing.
    pub fn read<R: DeserializeOwned>(folder: &Path, form: &Form, digest: &str) -> Result<Vec<R>, Complaint> {
        let path = folder.join(JOURNAL);
        rows(&path, &whole_lines(&path)?, form, digest)
    }

    /// Adds a finished row.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn add(&mut self, row: &impl Serialize) -> Result<(), Complaint> {
        // In one piece, so that an interruption leaves whole lines.
        let written = serde_json::to_string(row).map_err(io::Error::from).and_then(|mut line| {
            line.push('\n');
            self.file.write_all(line.as_bytes())
        });
        written.map_err(|error| unwritable(&self.path, &error))
    }

    fn write_header(&mut self, form: &Form, digest: &str) -> Result<(), Complaint> {
        self.add(&Header { schema: form.journal.to_owned(), digest: digest.to_owned() })
    }
}

/// The file, and the folder where it is missing.
fn open(folder: &Path) -> Result<(File, PathBuf), Complaint> {
    let path = folder.join(JOURNAL);
    fs::create_dir_all(folder).map_err(|error| unwritable(folder, &error))?;
    let file = File::options().create(true).append(true).open(&path);
    Ok((file.map_err(|error| unwritable(&path, &error))?, path))
}

/// Waits until nobody else writes the journal.
fn wait_for(file: &File, path: &Path, hold: &Hold<'_>) -> Result<(), Complaint> {
    let mut told = false;
    loop {
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => {}
            // Where the file system has no locks two processes write the same rows twice, and each counts once.
            Ok(()) | Err(TryLockError::Error(_)) => return Ok(()),
        }
        if !std::mem::replace(&mut told, true) {
            (hold.waiting)(path);
        }
        std::thread::sleep(ASK_AGAIN);
        hold.context.check()?;
    }
}

/// The text of a journal up to its last line break.
fn whole_lines(path: &Path) -> Result<String, Complaint> {
    // As long as the work was, so without a limit.
    let mut bytes = files::read(path, u64::MAX)?.bytes;
    bytes.truncate(bytes.iter().rposition(|&byte| byte == b'\n').map_or(0, |last| last + 1));
    files::text(path, bytes)
}

fn rows<R: DeserializeOwned>(path: &Path, text: &str, form: &Form, digest: &str) -> Result<Vec<R>, Complaint> {
    let wrong = |line: usize, what: &str| {
        Complaint::new(Kind::Syntax, what).at(Place::line(path, line + 1)).help("name another folder, or delete it")
    };
    let mut lines = text.lines().enumerate();
    let header: Header = lines
        .next()
        .and_then(|(_, first)| serde_json::from_str(first).ok())
        .filter(|header: &Header| header.schema == form.journal)
        .ok_or_else(|| wrong(0, &format!("this is not the journal of {}", form.whole)))?;
    if header.digest != digest {
        let what = format!("the journal is of {} with other options, other files or another version", form.whole);
        return Err(Complaint::new(Kind::Contradiction, what)
            .at(Place::line(path, 1))
            .help("go on with the options that it was begun with, or name another folder"));
    }
    lines
        .map(|(line, text)| {
            serde_json::from_str(text).map_err(|error| wrong(line, &format!("this line is no {}: {error}", form.row)))
        })
        .collect()
}

fn unwritable(path: &Path, error: &io::Error) -> Complaint {
    let help = match error.kind() {
        io::ErrorKind::StorageFull => {
            "make room on the disk; then the same command goes on with what is done (`campaign` without shards: with `--resume`)"
        }
        _ => "name another folder",
    };
    Complaint::new(Kind::Unwritable, format!("cannot be written: {error}")).in_file(path).help(help)
}
