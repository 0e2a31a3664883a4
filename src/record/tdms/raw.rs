//! Raw data of segments: chunk behind chunk, in each the values of every channel, one channel behind the other or in rows.

use super::daqmx::Daqmx;
use super::kind::{Kind, moment};
use super::object::{Data, Index, Object, Objects, Plain};
use super::segment::Segment;
use crate::record::bytes::{Broken, part};

/// Most numbers that are taken from one file.
const MOST_NUMBERS: usize = 1 << 27;

/// How the channels of a segment stand in its raw data.
enum Layout {
    Plain { parts: Vec<(usize, Plain)>, chunk: usize },
    Daqmx { channels: Vec<(usize, Daqmx)>, cards: Vec<Card>, chunk: usize },
}

/// The rows of a card in a chunk, behind those of the cards before.
struct Card {
    rows: usize,
    width: usize,
}

/// Takes the raw data of one segment after the other.
pub(super) struct Raw {
    /// The layout, and how many changes of the objects it is behind.
    layout: Option<(u64, Layout)>,
    /// Numbers that may still be taken.
    left: usize,
}

impl Raw {
    pub fn new() -> Self {
        Self { layout: None, left: MOST_NUMBERS }
    }

    /// Appends the values of a segment to those of its channels.
    ///
    /// # Errors
    /// Raw data that belong to no channel, or end within a value although the segment was finished; more numbers than are read.
    pub fn take(&mut self, objects: &mut Objects, segment: &Segment<'_>) -> Result<(), Broken> {
        if segment.raw.is_empty() {
            return Ok(());
        }
        let changes = objects.changes;
        let layout = match self.layout.take() {
            Some((at, layout)) if at == changes => layout,
            _ => Layout::of(objects)?,
        };
        let mut sink = Sink { known: &mut objects.known, little: segment.little, left: &mut self.left };
        match &layout {
            Layout::Plain { parts, .. } if segment.interleaved && !is_one_text(parts) => sink.rows(parts, segment)?,
            Layout::Plain { parts, chunk } => sink.blocks(parts, *chunk, segment)?,
            Layout::Daqmx { channels, cards, chunk } => {
                for piece in segment.raw.chunks((*chunk).max(1)) {
                    if piece.len() < *chunk && !segment.unfinished && !ends_with_a_row(cards, piece.len()) {
                        return Err(ends_within());
                    }
                    sink.cards(channels, cards, piece)?;
                }
            }
        }
        self.layout = Some((changes, layout));
        Ok(())
    }
}

/// LabVIEW marks segments of one channel of texts as interleaved, which they cannot be.
fn is_one_text(parts: &[(usize, Plain)]) -> bool {
    matches!(parts, [(_, Plain { kind: Kind::Text, .. })])
}

fn ends_within() -> Broken {
    Broken::damaged("the raw data of a segment end within a value")
}

impl Layout {
    fn of(objects: &Objects) -> Result<Self, Broken> {
        let (mut parts, mut channels) = (Vec::new(), Vec::new());
        for (id, index) in objects.active() {
            match index {
                Index::Plain(plain) if plain.count > 0 => parts.push((id, *plain)),
                Index::Daqmx(daqmx) if daqmx.count > 0 => channels.push((id, daqmx.clone())),
                _ => {}
            }
        }
        match (parts.is_empty(), channels.is_empty()) {
            (true, true) => Err(Broken::damaged("a segment has raw data and no channel")),
            (false, false) => Err(Broken::damaged("a segment mixes channels of DAQmx with others")),
            (false, true) => {
                let chunk = parts.iter().try_fold(0_u64, |sum, (_, plain)| sum.checked_add(plain.bytes));
                Ok(Self::Plain { parts, chunk: size(chunk)? })
            }
            (true, false) => Self::of_cards(channels),
        }
    }

    fn of_cards(channels: Vec<(usize, Daqmx)>) -> Result<Self, Broken> {
        let mut widths: &[usize] = &[];
        let mut rows: Vec<Option<u64>> = Vec::new();
        for (_, daqmx) in &channels {
            if rows.is_empty() {
                widths = &daqmx.widths;
                rows = vec![None; widths.len()];
            }
            if daqmx.widths != widths {
                return Err(Broken::damaged("channels of DAQmx have rows of different widths"));
            }
            for scaler in &daqmx.scalers {
                let Some(known) = rows.get_mut(scaler.buffer) else { continue };
                if known.is_some_and(|rows| rows != daqmx.count) {
                    return Err(Broken::damaged("channels of one card have different numbers of values"));
                }
                *known = Some(daqmx.count);
            }
        }
        let sum = |sum: u64, (rows, width): (&Option<u64>, &usize)| {
            rows.unwrap_or(0).checked_mul(*width as u64).and_then(|bytes| sum.checked_add(bytes))
        };
        let chunk = size(rows.iter().zip(widths).try_fold(0, sum))?;
        // What fits into the chunk fits into a size.
        let cards =
            rows.iter().zip(widths).map(|(rows, width)| Card { rows: rows.unwrap_or(0) as usize, width: *width });
        let cards = cards.collect();
        Ok(Self::Daqmx { channels, cards, chunk })
    }
}

fn size(bytes: Option<u64>) -> Result<usize, Broken> {
    let size = bytes.and_then(|bytes| usize::try_from(bytes).ok());
    size.ok_or_else(|| Broken::damaged("a segment has more values than any file"))
}

/// Whether so many bytes of a chunk are whole rows of whole cards.
fn ends_with_a_row(cards: &[Card], mut length: usize) -> bool {
    for card in cards {
        if length < card.rows * card.width {
            return length.is_multiple_of(card.width);
        }
        length -= card.rows * card.width;
    }
    length == 0
}

/// Where values go.
struct Sink<'a> {
    known: &'a mut [Object],
    little: bool,
    left: &'a mut usize,
}

impl Sink<'_> {
    /// Values of each channel behind those of the one before, in chunks.
    ///
    /// Where the writing broke off within a chunk, its first channels have values that the others lack. It is left out, so that channels
    /// stay as long as their time; a channel alone is kept as far as it goes.
    fn blocks(&mut self, parts: &[(usize, Plain)], chunk: usize, segment: &Segment<'_>) -> Result<(), Broken> {
        for piece in segment.raw.chunks(chunk.max(1)) {
            let whole = piece.len() == chunk;
            match parts {
                [(id, plain)] if !whole && segment.unfinished && plain.kind != Kind::Text => {
                    self.values(*id, plain.kind, piece)?;
                }
                _ if !whole && segment.unfinished => {}
                _ => self.chunk(parts, chunk, piece)?,
            }
        }
        Ok(())
    }

    /// One chunk; the last one of a segment may be shorter.
    fn chunk(&mut self, parts: &[(usize, Plain)], chunk: usize, piece: &[u8]) -> Result<(), Broken> {
        let mut at = 0;
        for (id, plain) in parts {
            let bytes = match plain.kind.width() {
                _ if piece.len() == chunk => plain.bytes as usize,
                Some(width) => shortened(plain, width, piece.len(), chunk)?,
                // Where the texts end stands before them, and no longer holds.
                None => return Err(ends_within()),
            };
            self.values(*id, plain.kind, part(piece, at, bytes)?)?;
            at += bytes;
        }
        if at < piece.len() { Err(ends_within()) } else { Ok(()) }
    }

    fn values(&mut self, id: usize, kind: Kind, raw: &[u8]) -> Result<(), Broken> {
        let width = kind.width().unwrap_or(1);
        self.column(id, kind, raw.len() / width, raw.chunks_exact(width))
    }

    /// Values of all channels in rows.
    fn rows(&mut self, parts: &[(usize, Plain)], segment: &Segment<'_>) -> Result<(), Broken> {
        let first = parts.first().map_or(0, |(_, plain)| plain.count);
        let mut width = 0_usize;
        for (_, plain) in parts {
            let own = plain.kind.width().ok_or_else(|| Broken::damaged("texts alternate with other values"))?;
            if plain.count != first {
                return Err(Broken::damaged("channels that alternate have different numbers of values"));
            }
            width += own;
        }
        let rows = segment.raw.chunks_exact(width.max(1));
        if !rows.remainder().is_empty() && !segment.unfinished {
            return Err(ends_within());
        }
        let mut at = 0;
        for (id, plain) in parts {
            let own = plain.kind.width().unwrap_or_default();
            let value = |row| part(row, at, own).unwrap_or_default();
            self.column(*id, plain.kind, rows.len(), rows.clone().map(value))?;
            at += own;
        }
        Ok(())
    }

    /// The rows of each card, behind each other; a chunk that is cut off has fewer of them.
    fn cards(&mut self, channels: &[(usize, Daqmx)], cards: &[Card], piece: &[u8]) -> Result<(), Broken> {
        let mut begins = Vec::with_capacity(cards.len());
        let mut at = 0;
        for card in cards {
            let rows = card.rows.min((piece.len() - at).checked_div(card.width).unwrap_or(0));
            begins.push(part(piece, at, rows * card.width)?);
            at = (at + card.rows * card.width).min(piece.len());
        }
        for (id, daqmx) in channels {
            for scaler in &daqmx.scalers {
                let (Some(rows), Some(card)) = (begins.get(scaler.buffer), cards.get(scaler.buffer)) else { continue };
                let rows = rows.chunks_exact(card.width.max(1));
                spend(self.left, rows.len())?;
                let Some(object) = self.known.get_mut(*id) else { continue };
                let values = match daqmx.scaled {
                    true => object.data.scalers.entry(scaler.scale).or_default(),
                    false => &mut object.data.numbers,
                };
                for row in rows {
                    values.push(scaler.value(row, self.little)?);
                }
            }
        }
        Ok(())
    }

    fn column<'r>(
        &mut self,
        id: usize,
        kind: Kind,
        count: usize,
        raw: impl Iterator<Item = &'r [u8]>,
    ) -> Result<(), Broken> {
        let little = self.little;
        let Some(Object { data, .. }) = self.known.get_mut(id) else { return Ok(()) };
        match kind {
            Kind::Signed(_) | Kind::Unsigned(_) | Kind::Float(_) => {
                spend(self.left, count)?;
                data.numbers.extend(raw.map(|raw| kind.number(raw, little)));
            }
            Kind::Stamp => {
                // A moment is as large as two numbers.
                spend(self.left, 2 * count)?;
                for raw in raw {
                    data.stamps.push(moment(raw, little)?);
                }
            }
            Kind::Complex(_) => data.note("complex numbers"),
            Kind::Text => data.note("text"),
            Kind::Nothing => {}
        }
        Ok(())
    }
}

impl Data {
    fn note(&mut self, what: &'static str) {
        self.other = Some(what);
    }
}

fn spend(left: &mut usize, count: usize) -> Result<(), Broken> {
    *left = left.checked_sub(count).ok_or(Broken::TooLarge)?;
    Ok(())
}

/// Bytes of a channel in a last chunk that was written shorter, all channels in proportion.
fn shortened(plain: &Plain, width: usize, length: usize, chunk: usize) -> Result<usize, Broken> {
    let share = u128::from(plain.count) * length as u128;
    if !share.is_multiple_of(chunk as u128) {
        return Err(ends_within());
    }
    usize::try_from(share / chunk as u128).map(|count| count * width).map_err(|_| ends_within())
}
