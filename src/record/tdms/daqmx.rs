//! Raw data of DAQmx: rows of bytes as the cards gave them, from which each channel takes its own.
//!
//! The white paper of the format names these indices and leaves out what they hold; this is as files of DAQmx have it and npTDMS
//! reads it.

use super::cursor::Cursor;
use super::kind::Kind;
use crate::record::bytes::{Broken, integer, part};

const FORMAT_CHANGING: u32 = 0x1269;
const DIGITAL_LINE: u32 = 0x126A;
/// The type of channels whose values are what their scales make of those of the cards.
const RAW: u32 = 0xFFFF_FFFF;

/// Where a value stands in the rows of a card.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scaler {
    kind: Kind,
    pub buffer: usize,
    offset: usize,
    /// Which bit of the value a digital line is.
    bit: Option<u32>,
    /// The number of the scale that it goes to.
    pub scale: u32,
}

/// The index of a channel.
#[derive(Debug, Clone)]
pub(super) struct Daqmx {
    pub count: u64,
    /// Whether the values go to scales; else they are those of the channel.
    pub scaled: bool,
    pub scalers: Vec<Scaler>,
    /// Bytes of a row of each card.
    pub widths: Vec<usize>,
}

impl Daqmx {
    /// The index behind its mark; `None` where the mark is of another kind.
    ///
    /// # Errors
    /// Values that stand outside of the rows.
    pub fn read(mark: u32, from: &mut Cursor<'_>) -> Result<Option<Self>, Broken> {
        if !matches!(mark, FORMAT_CHANGING | DIGITAL_LINE) {
            return Ok(None);
        }
        let scaled = from.u32()? == RAW;
        let (dimension, count) = (from.u32()?, from.u64()?);
        if dimension != 1 {
            return Err(Broken::damaged(format!("a channel has {dimension} dimensions, where there is one")));
        }
        let mut scalers = Vec::new();
        for _ in 0..from.u32()? {
            scalers.push(Scaler::read(mark == DIGITAL_LINE, from)?);
        }
        let mut widths = Vec::new();
        for _ in 0..from.u32()? {
            widths.push(from.u32()? as usize);
        }
        let fits = |scaler: &Scaler| widths.get(scaler.buffer).is_some_and(|width| scaler.end() <= *width);
        if scalers.is_empty() || !scalers.iter().all(fits) {
            return Err(Broken::damaged("a channel of DAQmx stands outside of the rows of its card"));
        }
        if !scaled && scalers.len() != 1 {
            return Err(Broken::damaged("a channel of DAQmx has several values and no scale"));
        }
        Ok(Some(Self { count, scaled, scalers, widths }))
    }
}

impl Scaler {
    fn read(line: bool, from: &mut Cursor<'_>) -> Result<Self, Broken> {
        let kind = Kind::of_scaler(from.u32()?)?;
        let (buffer, offset) = (from.u32()? as usize, from.u32()?);
        // How many bits of a sample count: of a line one byte, else four.
        from.take(if line { 1 } else { 4 })?;
        let scale = from.u32()?;
        let (offset, bit) = if line { (offset / 8, Some(offset % 8)) } else { (offset, None) };
        Ok(Self { kind, buffer, offset: offset as usize, bit, scale })
    }

    fn end(&self) -> usize {
        self.offset.saturating_add(self.kind.width().unwrap_or(usize::MAX))
    }

    /// Its value in a row of its card.
    pub fn value(&self, row: &[u8], little: bool) -> Result<f64, Broken> {
        let raw = part(row, self.offset, self.kind.width().unwrap_or_default())?;
        Ok(match self.bit {
            Some(bit) => (integer(raw, little) >> bit & 1) as f64,
            None => self.kind.number(raw, little),
        })
    }
}
