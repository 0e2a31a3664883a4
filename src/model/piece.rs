//! Pieces between which nothing jumps, over which all inputs run straight.

use super::stretch::Stretch;

/// Inputs that run straight over an interval.
#[derive(Debug, Clone, PartialEq)]
pub struct Piece {
    /// s.
    pub start: f64,
    /// s.
    pub end: f64,
    /// Value of each input at the start, SI; behind them how much warmer the fluid is than its temperature of reference, K, where
    /// the rig measures that.
    pub from: Vec<f64>,
    /// The same at the end.
    pub to: Vec<f64>,
    /// Whether an input jumps at the start.
    pub jump: bool,
}

impl Piece {
    /// One input over the piece.
    pub(super) fn stretch(&self, input: usize) -> Stretch {
        Stretch { start: self.start, end: self.end, from: self.from[input], to: self.to[input], may_jump: self.jump }
    }
}

/// Cuts the piece that a time lies within, as if something jumped there.
pub(super) fn split(pieces: &mut Vec<Piece>, time: f64) {
    let Some(index) = pieces.iter().position(|piece| piece.start < time && time < piece.end) else { return };
    let whole = &pieces[index];
    let middle: Vec<f64> = (0..whole.from.len()).map(|input| value(pieces, input, time)).collect();
    let late = Piece { start: time, from: middle.clone(), jump: true, ..whole.clone() };
    let early = Piece { end: time, to: middle, ..whole.clone() };
    pieces.splice(index..=index, [early, late]);
}

/// Value of an input at a time, SI; at a jump the value before it.
pub(super) fn value(pieces: &[Piece], input: usize, t: f64) -> f64 {
    let index = pieces.partition_point(|piece| piece.end < t).min(pieces.len().saturating_sub(1));
    let Some(piece) = pieces.get(index) else { return 0.0 };
    let share = ((t - piece.start) / (piece.end - piece.start)).clamp(0.0, 1.0);
    piece.from[input] + share * (piece.to[input] - piece.from[input])
}

/// Differences that are rounding, as a share: of two times, of the run.
pub(super) const SAME: f64 = 1e-9;

/// Whether an input has another value behind a knot than before it.
pub(super) fn leaps(before: f64, behind: f64) -> bool {
    (before - behind).abs() > SAME * (before.abs() + behind.abs())
}

/// Joins the broken lines of all inputs into pieces that end wherever one of them bends or jumps.
/// Only what the first `inputs` of them leap by is a jump.
pub(super) fn merge(lines: &[Vec<Stretch>], inputs: usize, start: f64, end: f64) -> Vec<Piece> {
    let mut knots: Vec<f64> = lines.iter().flatten().map(|stretch| stretch.start).collect();
    knots.push(start);
    knots.push(end);
    knots.retain(|knot| (start..=end).contains(knot));
    knots.sort_by(f64::total_cmp);
    // Knots of two inputs that differ by rounding only are one.
    knots.dedup_by(|late, early| *late - *early < SAME * (end - start));
    let mut pieces: Vec<Piece> = Vec::new();
    let mut at = vec![0; lines.len()];
    for pair in knots.windows(2) {
        let middle = f64::midpoint(pair[0], pair[1]);
        let (mut from, mut to, mut may_jump) = (Vec::new(), Vec::new(), Vec::new());
        for (line, at) in lines.iter().zip(&mut at) {
            while *at + 1 < line.len() && line[*at].end <= middle {
                *at += 1;
            }
            let Some(stretch) = line.get(*at) else { continue };
            let value = |t: f64| {
                let share = ((t - stretch.start) / (stretch.end - stretch.start)).clamp(0.0, 1.0);
                stretch.from + share * (stretch.to - stretch.from)
            };
            from.push(value(pair[0]));
            to.push(value(pair[1]));
            may_jump.push(stretch.may_jump);
        }
        let continuous = |last: &Piece| {
            let ends = last.to.iter().zip(&from).zip(&may_jump).take(inputs);
            !ends.filter(|(_, may_jump)| **may_jump).any(|((before, behind), _)| leaps(*before, *behind))
        };
        let jump = !pieces.last().is_some_and(continuous);
        pieces.push(Piece { start: pair[0], end: pair[1], from, to, jump });
    }
    pieces
}
