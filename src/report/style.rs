//! How a text is written: plain for files and pipes, in colour and with small pictures for a terminal.

/// How a notice is meant; it is told in words and by a colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tone {
    /// Nothing found.
    Good,
    /// Something found.
    Alert,
    /// No judgement possible, or one to be taken with care.
    Caution,
}

/// How a text is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Style {
    pub colour: bool,
    /// Columns of the terminal; `None` for a text without pictures.
    pub width: Option<usize>,
}

/// Bars from low to high.
#[cfg(feature = "cli")]
const BARS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];

impl Style {
    /// For files and pipes.
    pub const PLAIN: Self = Self { colour: false, width: None };

    /// A text in the colour of its tone, bold; as it is where there is no colour.
    pub fn painted(&self, text: &str, tone: Tone) -> String {
        let code = match tone {
            Tone::Good => "32",
            Tone::Alert => "31",
            Tone::Caution => "33",
        };
        if self.colour { format!("\x1b[1;{code}m{text}\x1b[0m") } else { text.to_owned() }
    }
}

/// Values from 0 to 1 as small bars; what lies outside is drawn at its end, what is no number left blank.
#[cfg(feature = "cli")]
pub fn bars(shares: impl Iterator<Item = f64>) -> String {
    let bar = |share: f64| BARS[((share * 7.0).round().clamp(0.0, 7.0)) as usize];
    shares.map(|share| if share.is_nan() { ' ' } else { bar(share) }).collect()
}

/// A scale of `width` characters from 0 to 1: a bar from one share to another (dotted where an end is open), a stroke at what
/// should be, a point at what is.
#[cfg(feature = "cli")]
pub fn scale(width: usize, bar: [Option<f64>; 2], stroke: f64, point: f64) -> String {
    let last = width.saturating_sub(1);
    let at = |share: f64| (share.clamp(0.0, 1.0) * last as f64).round() as usize;
    let (from, to) = (at(bar[0].unwrap_or(0.0)), at(bar[1].unwrap_or(1.0)));
    let filled = if bar[0].is_some() && bar[1].is_some() { '━' } else { '╍' };
    let mark = |place: usize| match place {
        place if place == at(point) => '●',
        place if place == at(stroke) => '┃',
        place if (from..=to).contains(&place) => filled,
        _ => '·',
    };
    (0..width).map(mark).collect()
}
