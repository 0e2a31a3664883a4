//! Bytes taken one item after the other, in the order of their segment.

use crate::record::bytes::{Broken, part, u32_at, u64_at};

/// A part of the file, and how far it is read.
pub(super) struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Whether the least byte of a number stands first.
    pub little: bool,
}

impl<'a> Cursor<'a> {
    pub fn new(bytes: &'a [u8], little: bool) -> Self {
        Self { bytes, at: 0, little }
    }

    pub fn take(&mut self, length: usize) -> Result<&'a [u8], Broken> {
        // An end in bytes of this part would mislead whoever looks it up in the file.
        let taken = part(self.bytes, self.at, length)
            .map_err(|_| Broken::damaged("a list of its channels is longer than the segment says"))?;
        self.at += length;
        Ok(taken)
    }

    pub fn u32(&mut self) -> Result<u32, Broken> {
        u32_at(self.take(4)?, 0, self.little)
    }

    pub fn u64(&mut self) -> Result<u64, Broken> {
        u64_at(self.take(8)?, 0, self.little)
    }

    /// Text behind its length.
    pub fn text(&mut self) -> Result<String, Broken> {
        let length = self.u32()? as usize;
        Ok(String::from_utf8_lossy(self.take(length)?).into_owned())
    }
}
