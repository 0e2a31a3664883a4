//! Segments: a lead-in of fixed length, what is new about the channels, then raw data.

use super::cursor::Cursor;
use crate::record::bytes::{Broken, part, u32_at};

/// Bytes of a lead-in.
const LEAD_IN: usize = 28;
/// The offset of a segment whose end was never written.
const UNKNOWN: u64 = u64::MAX;

const METADATA: u32 = 1 << 1;
const NEW_LIST: u32 = 1 << 2;
const RAW_DATA: u32 = 1 << 3;
const INTERLEAVED: u32 = 1 << 5;
const BIG_ENDIAN: u32 = 1 << 6;

/// One segment.
pub(super) struct Segment<'a> {
    /// What is new about the channels; `None` where that was being written when the writing broke off.
    pub metadata: Option<&'a [u8]>,
    pub raw: &'a [u8],
    /// Where the next one begins.
    pub end: usize,
    pub little: bool,
    /// Whether it names all channels again that it has data of.
    pub new_list: bool,
    /// Whether values of several channels alternate.
    pub interleaved: bool,
    /// Whether the writing broke off in it.
    pub unfinished: bool,
}

impl<'a> Segment<'a> {
    /// The segment that begins at `start`.
    ///
    /// # Errors
    /// A mark that is not that of a segment, an unknown version, ends beyond that of the file.
    pub fn at(bytes: &'a [u8], start: usize) -> Result<Self, Broken> {
        let head = part(bytes, start, LEAD_IN)?;
        if !head.starts_with(b"TDSm") {
            return Err(Broken::damaged(format!("there is no segment at byte {start}")));
        }
        // The flags are little-endian, whatever they say of the rest.
        let flags = u32_at(head, 4, true)?;
        let little = flags & BIG_ENDIAN == 0;
        let mut lead = Cursor::new(part(head, 8, LEAD_IN - 8)?, little);
        let (version, next, raw_offset) = (lead.u32()?, lead.u64()?, lead.u64()?);
        if !matches!(version, 4712 | 4713) {
            return Err(Broken::damaged(format!("the segment at byte {start} is of the unknown version {version}")));
        }
        let behind = bytes.get(start + LEAD_IN..).unwrap_or_default();
        let unfinished = next == UNKNOWN;
        let length = if unfinished { behind.len() } else { usize::try_from(next).unwrap_or(usize::MAX) };
        let body = part(bytes, start + LEAD_IN, length)?;
        let (metadata, raw) = match usize::try_from(raw_offset).ok().and_then(|offset| body.split_at_checked(offset)) {
            Some((metadata, raw)) => (Some(metadata), raw),
            None if unfinished => (None, &body[..0]),
            None => {
                return Err(Broken::damaged(format!(
                    "the raw data of the segment at byte {start} begin behind its end"
                )));
            }
        };
        Ok(Self {
            metadata: if flags & METADATA == 0 { metadata.map(|_| &body[..0]) } else { metadata },
            raw: if flags & RAW_DATA == 0 { &body[..0] } else { raw },
            end: start + LEAD_IN + length,
            little,
            new_list: flags & NEW_LIST != 0,
            interleaved: flags & INTERLEAVED != 0,
            unfinished,
        })
    }
}
