//! The bytes of a data group: plain, packed, or in pieces.

use super::block::{Block, File};
use crate::record::bytes::{Broken, inflate, part, u32_at, u64_at};

/// Appends the records at an address to `out`, of at most `most` bytes.
pub(super) fn gather(file: &mut File<'_>, address: u64, out: &mut Vec<u8>, most: u64) -> Result<(), Broken> {
    let Some(block) = file.once(address)? else { return Ok(()) };
    match block.id {
        b"##DL" => list(file, block, out, most),
        b"##HL" => match file.once_named(block.link(0), b"##DL")? {
            Some(first) => list(file, first, out, most),
            None => Ok(()),
        },
        _ => piece(&block, out, most),
    }
}

/// A chain of lists of pieces.
fn list<'a>(file: &mut File<'a>, first: Block<'a>, out: &mut Vec<u8>, most: u64) -> Result<(), Broken> {
    let mut list = Some(first);
    while let Some(block) = list {
        for index in 1..block.links() {
            if let Some(one) = file.once(block.link(index))? {
                piece(&one, out, most)?;
            }
        }
        list = file.once_named(block.link(0), b"##DL")?;
    }
    Ok(())
}

fn piece(block: &Block<'_>, out: &mut Vec<u8>, most: u64) -> Result<(), Broken> {
    let left = most.saturating_sub(out.len() as u64);
    match block.id {
        b"##DT" if block.data().len() as u64 > left => Err(Broken::TooLarge),
        b"##DT" => {
            out.extend_from_slice(block.data());
            Ok(())
        }
        b"##DZ" => {
            out.extend(unpacked(block.data(), left)?);
            Ok(())
        }
        id => Err(Broken::damaged(format!(
            "its data stand in blocks {}, which are not read",
            String::from_utf8_lossy(id)
        ))),
    }
}

fn unpacked(data: &[u8], most: u64) -> Result<Vec<u8>, Broken> {
    let packing = part(data, 2, 1)?.first().copied().unwrap_or_default();
    let columns = u32_at(data, 4, true)? as usize;
    let length = u64_at(data, 8, true)?;
    let packed = usize::try_from(u64_at(data, 16, true)?).unwrap_or(usize::MAX);
    let plain = inflate(part(data, 24, packed)?, most)?;
    if plain.len() as u64 != length {
        return Err(Broken::damaged(format!("{} bytes were packed where it says {length}", plain.len())));
    }
    match packing {
        0 => Ok(plain),
        1 => Ok(transposed(&plain, columns)),
        other => Err(Broken::damaged(format!("its data are packed in the unknown way {other}"))),
    }
}

/// Bytes of records of `columns` bytes that were written column by column; what is no whole record stands behind.
fn transposed(plain: &[u8], columns: usize) -> Vec<u8> {
    let rows = plain.len().checked_div(columns).unwrap_or(0);
    let mut out = Vec::with_capacity(plain.len());
    for row in 0..rows {
        out.extend((0..columns).map(|column| plain[column * rows + row]));
    }
    out.extend_from_slice(plain.get(out.len()..).unwrap_or_default());
    out
}
