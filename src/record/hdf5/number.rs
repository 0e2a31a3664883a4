//! Numbers of HDF5: integers and floats of any usual width, in either byte order.

use hdf5_reader::{ByteOrder, Datatype};

use crate::record::bytes::{integer, signed};

/// Classes of MATLAB whose values are numbers.
pub(super) fn is_class(class: &str) -> bool {
    const NUMBERS: &[&str] =
        &["double", "single", "logical", "int8", "int16", "int32", "int64", "uint8", "uint16", "uint32", "uint64"];
    NUMBERS.contains(&class)
}

/// How a number lies in its bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Numeric {
    pub width: usize,
    little: bool,
    kind: Kind,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Float,
    Signed,
    Unsigned,
}

impl Numeric {
    /// None for what is no number of one to eight bytes.
    pub fn of(datatype: &Datatype) -> Option<Self> {
        let (size, order, kind) = match datatype {
            Datatype::FloatingPoint { size: size @ (4 | 8), byte_order } => (size, byte_order, Kind::Float),
            Datatype::FixedPoint { size: size @ 1..=8, signed: true, byte_order } => (size, byte_order, Kind::Signed),
            Datatype::FixedPoint { size: size @ 1..=8, byte_order, .. }
            | Datatype::Bitfield { size: size @ 1..=8, byte_order } => (size, byte_order, Kind::Unsigned),
            // As h5py writes truth values.
            Datatype::Enum { base, .. } => match base.as_ref() {
                Datatype::Enum { .. } => return None,
                base => return Self::of(base),
            },
            _ => return None,
        };
        Some(Self { width: usize::from(*size), little: *order == ByteOrder::LittleEndian, kind })
    }

    /// The numbers at `offset` of every `stride` bytes.
    pub fn series(self, raw: &[u8], offset: usize, stride: usize) -> Vec<f64> {
        let rows = raw.chunks_exact(stride.max(1));
        rows.map_while(|row| row.get(offset..offset.checked_add(self.width)?)).map(|bytes| self.one(bytes)).collect()
    }

    fn one(self, bytes: &[u8]) -> f64 {
        let bits = integer(bytes, self.little);
        match self.kind {
            Kind::Float if self.width == 4 => f64::from(f32::from_bits(bits as u32)),
            Kind::Float => f64::from_bits(bits),
            Kind::Signed => signed(bits, 8 * self.width as u32) as f64,
            Kind::Unsigned => bits as f64,
        }
    }
}
