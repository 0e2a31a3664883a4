//! Bytes of a file from strangers: every read checked, none beyond the end.

use std::io::{self, Read};

use flate2::read::ZlibDecoder;

/// Why a file that is no text cannot be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Broken {
    /// What is wrong in it, to stand behind "the file is damaged: ".
    Damaged(String),
    /// What it holds that is not read, to stand behind "the file holds ".
    NotRead(String),
    /// It unpacks to more than is read.
    TooLarge,
}

impl Broken {
    pub fn damaged(what: impl Into<String>) -> Self {
        Self::Damaged(what.into())
    }
}

/// `length` bytes from `start`.
pub(super) fn part(bytes: &[u8], start: usize, length: usize) -> Result<&[u8], Broken> {
    let end = start.checked_add(length);
    end.and_then(|end| bytes.get(start..end))
        .ok_or_else(|| Broken::damaged(format!("it ends before byte {}", start.saturating_add(length))))
}

fn array<const N: usize>(bytes: &[u8], start: usize) -> Result<[u8; N], Broken> {
    let mut out = [0; N];
    out.copy_from_slice(part(bytes, start, N)?);
    Ok(out)
}

pub(super) fn u16_at(bytes: &[u8], start: usize, little: bool) -> Result<u16, Broken> {
    let raw = array(bytes, start)?;
    Ok(if little { u16::from_le_bytes(raw) } else { u16::from_be_bytes(raw) })
}

pub(super) fn u32_at(bytes: &[u8], start: usize, little: bool) -> Result<u32, Broken> {
    let raw = array(bytes, start)?;
    Ok(if little { u32::from_le_bytes(raw) } else { u32::from_be_bytes(raw) })
}

pub(super) fn u64_at(bytes: &[u8], start: usize, little: bool) -> Result<u64, Broken> {
    let raw = array(bytes, start)?;
    Ok(if little { u64::from_le_bytes(raw) } else { u64::from_be_bytes(raw) })
}

/// An integer of up to eight bytes, in the order of the file.
pub(super) fn integer(raw: &[u8], little: bool) -> u64 {
    let join = |value: u64, byte: &u8| (value << 8) | u64::from(*byte);
    let raw = raw.get(..raw.len().min(8)).unwrap_or_default();
    if little { raw.iter().rev().fold(0, join) } else { raw.iter().fold(0, join) }
}

/// The same with a sign in the topmost of its `bits`.
pub(super) fn signed(value: u64, bits: u32) -> i64 {
    let unused = 64 - bits.clamp(1, 64);
    (value << unused).cast_signed() >> unused
}

/// What zlib packed; no more than `most` bytes of it.
pub(super) fn inflate(packed: &[u8], most: u64) -> Result<Vec<u8>, Broken> {
    let mut plain = Vec::new();
    let read = ZlibDecoder::new(packed).take(most.saturating_add(1)).read_to_end(&mut plain);
    read.map_err(|error| match error.kind() {
        io::ErrorKind::UnexpectedEof => Broken::damaged("a packed part of it ends too early"),
        _ => Broken::damaged("a packed part of it cannot be unpacked"),
    })?;
    if plain.len() as u64 > most { Err(Broken::TooLarge) } else { Ok(plain) }
}
