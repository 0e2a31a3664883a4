//! One channel of a record: where its bits stand, and what they mean.

use super::block::{Block, File};
use crate::record::bytes::{Broken, integer, part, signed, u16_at, u32_at};

/// How a number becomes the quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Conversion {
    None,
    /// `a + b x`.
    Linear(f64, f64),
    /// `(a x² + b x + c)/(d x² + e x + f)`.
    Rational([f64; 6]),
    /// A table, a formula or a text.
    NotRead,
}

/// A channel of a group.
#[derive(Debug, Clone)]
pub(super) struct Channel {
    pub name: String,
    pub unit: Option<String>,
    /// 2 and 3 are masters, 3 and 6 have no bytes: they count the records.
    pub kind: u8,
    /// 1 is the time.
    pub sync: u8,
    data_type: u8,
    bit_offset: u32,
    byte_offset: usize,
    bits: u32,
    flags: u32,
    invalid_bit: usize,
    pub conversion: Conversion,
    /// Whether it has parts of its own: an array or a structure.
    pub composed: bool,
}

impl Channel {
    pub fn read(file: &File<'_>, block: &Block<'_>) -> Result<Self, Broken> {
        let data = block.data();
        let byte = |at: usize| part(data, at, 1).map(|one| one.first().copied().unwrap_or_default());
        let name = file.text(block.link(2))?.unwrap_or_default();
        let conversion = file.named(block.link(4), b"##CC")?;
        let own = file.text(block.link(6))?;
        let unit = match (own, &conversion) {
            (None, Some(conversion)) => file.text(conversion.link(1))?,
            (own, _) => own,
        };
        Ok(Self {
            name,
            unit: unit.filter(|unit| !unit.is_empty()),
            kind: byte(0)?,
            sync: byte(1)?,
            data_type: byte(2)?,
            bit_offset: u32::from(byte(3)?),
            byte_offset: u32_at(data, 4, true)? as usize,
            bits: u32_at(data, 8, true)?,
            flags: u32_at(data, 12, true)?,
            invalid_bit: u32_at(data, 16, true)? as usize,
            conversion: conversion.map_or(Ok(Conversion::None), |block| of(&block))?,
            composed: block.link(1) != 0,
        })
    }

    /// Why the channel holds no series of numbers; `None` where it does.
    pub fn lacks(&self) -> Option<&'static str> {
        let virtual_one = matches!(self.kind, 3 | 6);
        if self.composed {
            return Some("an array or a structure");
        }
        if matches!(self.kind, 1 | 4) || (!virtual_one && self.data_type > 5) {
            return Some("no number");
        }
        if !virtual_one && (self.bits == 0 || self.bits + self.bit_offset > 64) {
            return Some("a number of more than 64 bits");
        }
        if !virtual_one && matches!(self.data_type, 4 | 5) && !matches!(self.bits, 32 | 64) {
            return Some("a float of neither 32 nor 64 bits");
        }
        (self.conversion == Conversion::NotRead).then_some("a table, a formula or a text")
    }

    /// Its value in record number `row`, whose bytes of invalidation bits begin at `invalid`; NaN where it is marked as invalid.
    pub fn value(&self, record: &[u8], invalid: usize, row: usize) -> Result<f64, Broken> {
        if matches!(self.kind, 3 | 6) {
            return Ok(self.conversion.apply(row as f64));
        }
        let marked = self.flags & 2 != 0
            && part(record, invalid + self.invalid_bit / 8, 1)?[0] >> (self.invalid_bit % 8) & 1 != 0;
        if self.flags & 1 != 0 || marked {
            return Ok(f64::NAN);
        }
        let width = (self.bits + self.bit_offset).div_ceil(8) as usize;
        let little = self.data_type.is_multiple_of(2);
        let raw = integer(part(record, self.byte_offset, width)?, little) >> self.bit_offset;
        let bits = if self.bits >= 64 { raw } else { raw & ((1 << self.bits) - 1) };
        let number = match self.data_type {
            0 | 1 => bits as f64,
            2 | 3 => signed(bits, self.bits) as f64,
            _ if self.bits == 32 => f64::from(f32::from_bits(bits as u32)),
            _ => f64::from_bits(bits),
        };
        Ok(self.conversion.apply(number))
    }
}

fn of(block: &Block<'_>) -> Result<Conversion, Broken> {
    let data = block.data();
    let kind = part(data, 0, 1)?[0];
    let count = u16_at(data, 6, true)? as usize;
    let value = |index: usize| {
        if index >= count {
            return Err(Broken::damaged("a conversion has too few numbers"));
        }
        part(data, 24 + 8 * index, 8).map(|raw| f64::from_bits(integer(raw, true)))
    };
    Ok(match kind {
        0 => Conversion::None,
        1 => Conversion::Linear(value(0)?, value(1)?),
        2 => {
            let mut numbers = [0.0; 6];
            for (index, number) in numbers.iter_mut().enumerate() {
                *number = value(index)?;
            }
            Conversion::Rational(numbers)
        }
        _ => Conversion::NotRead,
    })
}

impl Conversion {
    fn apply(self, x: f64) -> f64 {
        match self {
            Self::None | Self::NotRead => x,
            Self::Linear(a, b) => a + b * x,
            Self::Rational([a, b, c, d, e, f]) => (a * x * x + b * x + c) / (d * x * x + e * x + f),
        }
    }
}
