//! Types of values, of channels and of properties.

use crate::record::bytes::{Broken, integer, signed, u64_at};

/// Seconds are counted in steps of 2^-64.
pub(super) const STEPS_PER_SECOND: f64 = 18_446_744_073_709_551_616.0;

/// What a value is; widths are in bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Signed(usize),
    Unsigned(usize),
    Float(usize),
    /// Whole seconds since the beginning of 1904 in UTC, and parts of one.
    Stamp,
    Complex(usize),
    Text,
    /// Of channels that never had a value.
    Nothing,
}

impl Kind {
    /// The type with this number in channels and properties.
    pub fn of(code: u32) -> Result<Self, Broken> {
        Ok(match code {
            0 => Self::Nothing,
            1 => Self::Signed(1),
            2 => Self::Signed(2),
            3 => Self::Signed(4),
            4 => Self::Signed(8),
            // 0x21 is a truth value.
            5 | 0x21 => Self::Unsigned(1),
            6 => Self::Unsigned(2),
            7 => Self::Unsigned(4),
            8 => Self::Unsigned(8),
            9 | 0x19 => Self::Float(4),
            10 | 0x1A => Self::Float(8),
            0x20 => Self::Text,
            0x44 => Self::Stamp,
            0x0008_000C => Self::Complex(8),
            0x0010_000D => Self::Complex(16),
            11 | 0x1B => return Err(Broken::NotRead("numbers of the type extended float".to_owned())),
            0x4F => return Err(Broken::NotRead("numbers of the type fixed point".to_owned())),
            other => return Err(Broken::damaged(format!("values of the unknown type {other:#x}"))),
        })
    }

    /// The type with this number in scalers of DAQmx, which count in another way.
    pub fn of_scaler(code: u32) -> Result<Self, Broken> {
        Ok(match code {
            0 => Self::Unsigned(1),
            1 => Self::Signed(1),
            2 => Self::Unsigned(2),
            3 => Self::Signed(2),
            4 => Self::Unsigned(4),
            5 => Self::Signed(4),
            6 => Self::Unsigned(8),
            7 => Self::Signed(8),
            8 => Self::Float(4),
            9 => Self::Float(8),
            other => return Err(Broken::damaged(format!("DAQmx values of the unknown type {other:#x}"))),
        })
    }

    /// Bytes of a value; `None` where they differ from value to value.
    pub fn width(self) -> Option<usize> {
        match self {
            Self::Signed(width) | Self::Unsigned(width) | Self::Float(width) | Self::Complex(width) => Some(width),
            Self::Stamp => Some(16),
            Self::Text | Self::Nothing => None,
        }
    }

    /// The value of these bytes; NaN of a type that is no number.
    pub fn number(self, raw: &[u8], little: bool) -> f64 {
        let bits = integer(raw, little);
        match self {
            Self::Signed(width) => signed(bits, 8 * width as u32) as f64,
            Self::Unsigned(_) => bits as f64,
            Self::Float(4) => f64::from(f32::from_bits(bits as u32)),
            Self::Float(_) => f64::from_bits(bits),
            Self::Stamp | Self::Complex(_) | Self::Text | Self::Nothing => f64::NAN,
        }
    }
}

/// The moment of 16 bytes, in steps of 2^-64 s since the beginning of 1904 in UTC.
pub(super) fn moment(raw: &[u8], little: bool) -> Result<i128, Broken> {
    let (first, second) = (u64_at(raw, 0, little)?, u64_at(raw, 8, little)?);
    // The order of the file holds for the two halves, too.
    let (seconds, steps) = if little { (second, first) } else { (first, second) };
    Ok((i128::from(seconds.cast_signed()) << 64) | i128::from(steps))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_seconds_and_their_parts() {
        let half = 1_u64 << 63;
        let little = [half.to_le_bytes(), (-3_i64).to_le_bytes()].concat();
        let big = [(-3_i64).to_be_bytes(), half.to_be_bytes()].concat();
        for (raw, order) in [(little, true), (big, false)] {
            assert_eq!(moment(&raw, order).unwrap() as f64 / STEPS_PER_SECOND, -2.5);
        }
    }

    #[test]
    fn numbers_have_their_sign_and_order() {
        assert_eq!(Kind::Signed(2).number(&[0xFE, 0xFF], true), -2.0);
        assert_eq!(Kind::Signed(2).number(&[0xFF, 0xFE], false), -2.0);
        assert_eq!(Kind::Unsigned(2).number(&[0xFE, 0xFF], true), 65534.0);
        assert_eq!(Kind::Float(4).number(&1.5_f32.to_be_bytes(), false), 1.5);
        assert_eq!(Kind::Float(8).number(&(-0.1_f64).to_le_bytes(), true), -0.1);
        assert!(Kind::Stamp.number(&[0; 16], true).is_nan());
    }
}
