//! From a file to a record.

#[cfg(feature = "internals")]
use std::io::Cursor;
use std::io::Read;
use std::path::Path;

use super::care::{Care, MOST, Standing};
use super::packed::{Bytes, gather};
use super::stream::{Begun, begin};
use super::{Asked, Record};
use crate::complaint::Complaint;
use crate::files::{self, Digesting};

impl Asked {
    /// Reads a record as [`Record::read`] does; columns without a unit of their own have that of the rig file, and groups of
    /// channels that the rig does not ask for make no rows.
    ///
    /// # Errors
    /// As [`Record::read`].
    pub fn read(&self, path: impl AsRef<Path>) -> Result<Record, Complaint> {
        read_file(path.as_ref(), Care::Strict, self).map(|(record, _)| record)
    }

    /// Reads a record as [`Record::read_as_it_stands`] does, units and groups as [`read`](Self::read).
    ///
    /// # Errors
    /// As [`Record::read_as_it_stands`].
    pub fn read_as_it_stands(&self, path: impl AsRef<Path>) -> Result<(Record, Option<Complaint>), Complaint> {
        read_file(path.as_ref(), Care::Survey, self)
    }

    /// Reads the bytes of a file; `path` is the name that messages give it.
    ///
    /// # Errors
    /// As [`Record::read`], but for those of the file itself.
    #[cfg(feature = "internals")]
    pub fn read_bytes(&self, path: impl AsRef<Path>, bytes: Vec<u8>) -> Result<Record, Complaint> {
        of_bytes(path.as_ref(), bytes, Care::Strict, self).map(|(record, _)| record)
    }
}

/// The record, and under [`Care::Survey`] the complaint that a strict reader would have made.
fn read_file(path: &Path, care: Care, asked: &Asked) -> Result<Standing, Complaint> {
    let mut file = files::open(path)?;
    if file.length().is_some_and(|length| length > MOST) {
        return Err(files::too_large(path, MOST));
    }
    let from = std::mem::replace(&mut file.from, Box::new(std::io::empty()));
    // What a logger adds meanwhile is not read: the file has changed then, and is refused below.
    let from: Bytes = match file.length() {
        Some(length) => Box::new(from.take(length)),
        None => from,
    };
    let (from, digested) = Digesting::new(from);
    let read = whole(path, Box::new(from), care, asked);
    // What was wrong in a file that somebody still writes to may be right a moment later.
    file.check_unchanged(path)?;
    let (mut record, refused) = read?;
    (record.origin.digest, record.origin.modified) = (digested.digest(), file.modified());
    Ok((record, refused))
}

/// The record of the bytes of a file.
#[cfg(feature = "internals")]
fn of_bytes(path: &Path, bytes: Vec<u8>, care: Care, asked: &Asked) -> Result<Standing, Complaint> {
    whole(path, Box::new(Cursor::new(bytes)), care, asked)
}

/// All of a record. A text is never whole in memory, only its numbers are.
fn whole(path: &Path, from: Bytes, care: Care, asked: &Asked) -> Result<Standing, Complaint> {
    match begin(path, from, care, asked, MOST)? {
        Begun::Text(stream) => {
            let ((mut record, refused), read_as) = stream.read_whole()?;
            record.origin.read_as = read_as;
            Ok((record, refused))
        }
        Begun::Binary { format, from, packing } => {
            let bytes = gather(from, path, packing, MOST)?;
            let (mut record, refused) = format.read(path, &bytes, care, asked)?;
            let packed = packing.map_or(String::new(), |packing| format!(", packed with {packing}"));
            record.origin.read_as = format!("{}{packed}{}", format.name(), record.origin.read_as);
            Ok((record, refused))
        }
    }
}
