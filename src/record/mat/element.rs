//! Data elements of MATLAB v5 to v7.2 files: a tag, then numbers, text, or other elements.

use crate::record::bytes::{Broken, inflate, integer, part, signed, u16_at, u32_at};

/// Structures within structures that are followed.
pub(in crate::record) const DEEPEST: usize = 8;
/// Most numbers that are taken from one file.
pub(in crate::record) const MOST_NUMBERS: usize = 1 << 27;

const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;

/// What a variable holds.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::record) enum Value {
    /// Real numbers in the order of the file, with the sizes of their array.
    Numbers {
        sizes: Vec<usize>,
        values: Vec<f64>,
    },
    Text(String),
    /// One structure.
    Fields(Vec<(String, Value)>),
    /// What holds no series, in words.
    Other(&'static str),
}

#[cfg(feature = "hdf5")]
impl Value {
    /// A row of numbers.
    pub fn vector(values: Vec<f64>) -> Self {
        Self::Numbers { sizes: vec![values.len()], values }
    }
}

/// One element: its type and its bytes.
struct Element<'a> {
    kind: u32,
    bytes: &'a [u8],
}

/// A file, or the inside of an element, from which elements are taken one after the other.
pub(super) struct Elements<'a> {
    pub bytes: &'a [u8],
    pub at: usize,
    pub little: bool,
}

/// What is left to be taken.
pub(super) struct Budget {
    pub numbers: usize,
    /// Bytes that may still be unpacked.
    pub bytes: u64,
}

impl Budget {
    pub fn new(bytes: u64) -> Self {
        Self { numbers: MOST_NUMBERS, bytes }
    }
}

impl<'a> Elements<'a> {
    fn inside(&self, element: &Element<'a>) -> Self {
        Self { bytes: element.bytes, at: 0, little: self.little }
    }

    pub fn is_done(&self) -> bool {
        self.at >= self.bytes.len()
    }

    fn next(&mut self) -> Result<Element<'a>, Broken> {
        let first = u32_at(self.bytes, self.at, self.little)?;
        // Up to four bytes may stand within the tag, their number in its upper half.
        if first >> 16 != 0 {
            let length = (first >> 16) as usize;
            if length > 4 {
                return Err(Broken::damaged(format!("the element at byte {} has an impossible tag", self.at)));
            }
            let bytes = part(self.bytes, self.at + 4, length)?;
            self.at += 8;
            return Ok(Element { kind: first & 0xFFFF, bytes });
        }
        let length = u32_at(self.bytes, self.at + 4, self.little)? as usize;
        let bytes = part(self.bytes, self.at + 8, length)?;
        let padded = if first == COMPRESSED { length } else { length.next_multiple_of(8) };
        self.at += 8 + padded;
        Ok(Element { kind: first, bytes })
    }

    /// The next variable, with its name.
    pub fn variable(&mut self, budget: &mut Budget) -> Result<(String, Value), Broken> {
        let element = self.next()?;
        if element.kind != COMPRESSED {
            return self.array(&element, budget, 0);
        }
        let plain = inflate(element.bytes, budget.bytes)?;
        budget.bytes -= plain.len() as u64;
        let mut within = Elements { bytes: &plain, at: 0, little: self.little };
        let element = within.next()?;
        within.array(&element, budget, 0)
    }

    fn array(&self, element: &Element<'a>, budget: &mut Budget, depth: usize) -> Result<(String, Value), Broken> {
        if element.kind != MATRIX {
            return Ok((String::new(), Value::Other("no array")));
        }
        // A field without a value.
        if element.bytes.is_empty() {
            return Ok((String::new(), Value::Other("empty")));
        }
        let mut inside = self.inside(element);
        let flags = u32_at(inside.next()?.bytes, 0, self.little)?;
        let (class, complex) = (flags & 0xFF, flags & 0x0800 != 0);
        if class == 17 {
            return Ok((String::new(), Value::Other("an object of a class of MATLAB")));
        }
        let sizes = inside.next()?;
        let sizes: Vec<usize> = sizes.bytes.chunks_exact(4).map(|size| integer(size, self.little) as usize).collect();
        let name = String::from_utf8_lossy(inside.next()?.bytes).into_owned();
        let value = match class {
            2 => inside.structure(&sizes, budget, depth)?,
            4 => Value::Text(text(&inside.next()?, self.little)?),
            6..=15 if complex => Value::Other("complex numbers"),
            6..=15 => Value::Numbers { sizes, values: numbers(&inside.next()?, self.little, budget)? },
            1 => Value::Other("a cell array"),
            5 => Value::Other("a sparse matrix"),
            _ => Value::Other("an object"),
        };
        Ok((name, value))
    }

    fn structure(&mut self, sizes: &[usize], budget: &mut Budget, depth: usize) -> Result<Value, Broken> {
        if sizes.iter().any(|size| *size != 1) {
            return Ok(Value::Other("an array of structures"));
        }
        if depth >= DEEPEST {
            return Ok(Value::Other("too deep within other structures"));
        }
        let length = u32_at(self.next()?.bytes, 0, self.little)? as usize;
        if length == 0 {
            return Err(Broken::damaged("the names of a structure's fields have no length"));
        }
        let names = self.next()?;
        let mut fields = Vec::new();
        for name in names.bytes.chunks_exact(length) {
            let end = name.iter().position(|byte| *byte == 0).unwrap_or(length);
            let name = String::from_utf8_lossy(name.get(..end).unwrap_or_default()).into_owned();
            let element = self.next()?;
            fields.push((name, self.array(&element, budget, depth + 1)?.1));
        }
        Ok(Value::Fields(fields))
    }
}

fn numbers(element: &Element<'_>, little: bool, budget: &mut Budget) -> Result<Vec<f64>, Broken> {
    let width = match element.kind {
        1 | 2 => 1,
        3 | 4 => 2,
        5..=7 => 4,
        9 | 12 | 13 => 8,
        kind => return Err(Broken::damaged(format!("numbers of the unknown type {kind}"))),
    };
    let count = element.bytes.len() / width;
    budget.numbers = budget.numbers.checked_sub(count).ok_or(Broken::TooLarge)?;
    let one = |raw: &[u8]| {
        let bits = integer(raw, little);
        match element.kind {
            7 => f64::from(f32::from_bits(bits as u32)),
            9 => f64::from_bits(bits),
            1 | 3 | 5 | 12 => signed(bits, 8 * width as u32) as f64,
            _ => bits as f64,
        }
    };
    Ok(element.bytes.chunks_exact(width).map(one).collect())
}

fn text(element: &Element<'_>, little: bool) -> Result<String, Broken> {
    // Two bytes a letter, in UTF-16 or as numbers.
    if matches!(element.kind, 4 | 17) {
        let units: Result<Vec<u16>, Broken> =
            (0..element.bytes.len() / 2).map(|index| u16_at(element.bytes, 2 * index, little)).collect();
        return Ok(String::from_utf16_lossy(&units?));
    }
    Ok(String::from_utf8_lossy(element.bytes).into_owned())
}
