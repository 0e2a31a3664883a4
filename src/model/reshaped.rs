//! A drive whose commands are reshaped, so that a lag of first order behind them answers as a spool with mass and dead time would.
//!
//! A spool of second order follows `T² s'' + tau s' + s = u(t - t_d)`. A lag of first order that is driven by `v = s + tau s'` gives
//! the same `s`, since `tau s' + s = v`. So another dynamic of the spool needs no other model, only another command.

use super::piece::{Piece, merge};
use super::stretch::Stretch;
use crate::rig::{Input, Rig};

/// Steps of the fourth order in each time constant of the spool: errors of 1e-4 of a stroke.
const STEPS: f64 = 16.0;
/// Distance from the command at which the spool has arrived, as a share of the span of the command.
const ARRIVED: f64 = 1e-4;

/// How a part follows an input, where the model behind it has a lag of first order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Following {
    /// Index among the inputs.
    pub input: usize,
    /// `tau` of the model, s.
    pub lag: f64,
    /// `T`, s; 0 without mass.
    pub inertia_time: f64,
    /// `t_d`, s.
    pub dead_time: f64,
}

impl Following {
    /// How the parts of a rig follow their inputs by the values of all its parameters, SI.
    pub fn of(rig: &Rig, parameters: &[f64]) -> Vec<Self> {
        let value = |index: Option<usize>| index.map_or(0.0, |index| parameters[index]);
        let one = |follower: crate::rig::Follower| Self {
            input: follower.input,
            lag: parameters[follower.lag],
            inertia_time: value(follower.inertia_time),
            dead_time: value(follower.dead_time),
        };
        rig.followers().map(one).collect()
    }
}

/// `T/tau` below which mass is none: a step is answered otherwise by less than its square, a four-hundredth, and explicit steps of a
/// sixteenth of `T` would not be stable below a forty-fourth.
const NO_MASS: f64 = 0.05;

/// A spool with mass.
#[derive(Clone, Copy)]
struct Spool {
    /// `tau`, s.
    lag: f64,
    /// `T²`, s².
    inertia: f64,
    position: f64,
    velocity: f64,
}

impl Spool {
    /// At rest where it is commanded to.
    fn at_rest(following: &Following, position: f64) -> Self {
        Self { lag: following.lag, inertia: following.inertia_time.powi(2), position, velocity: 0.0 }
    }

    /// The command that a lag of first order has to be given.
    fn reshaped(&self) -> f64 {
        self.position + self.lag * self.velocity
    }

    fn has_arrived(&self, command: f64, span: f64) -> bool {
        (self.position - command).abs() + self.lag * self.velocity.abs() <= ARRIVED * span
    }

    /// One step of Runge and Kutta over `step` s, the command running straight.
    fn step(&mut self, step: f64, (from, to): (f64, f64)) {
        let rate = |(position, velocity): (f64, f64), share: f64| {
            let command = from + share * (to - from);
            (velocity, (command - position - self.lag * velocity) / self.inertia)
        };
        let y = (self.position, self.velocity);
        let ahead = |k: (f64, f64), by: f64| (y.0 + by * k.0, y.1 + by * k.1);
        let k1 = rate(y, 0.0);
        let k2 = rate(ahead(k1, 0.5 * step), 0.5);
        let k3 = rate(ahead(k2, 0.5 * step), 0.5);
        let k4 = rate(ahead(k3, step), 1.0);
        let mean = |a: f64, b: f64, c: f64, d: f64| (a + 2.0 * b + 2.0 * c + d) / 6.0;
        self.position += step * mean(k1.0, k2.0, k3.0, k4.0);
        self.velocity += step * mean(k1.1, k2.1, k3.1, k4.1);
    }
}

/// The pieces that act where these are commanded, had the parts behind the inputs of a rig followed them like this; `None` where they
/// act as they are.
pub(super) fn acting(commanded: &[Piece], rig: &Rig, followings: &[Following]) -> Option<Vec<Piece>> {
    let late =
        |(input, own): (usize, &Input)| Following { input, lag: 0.0, inertia_time: 0.0, dead_time: own.dead_time };
    let of_inputs = rig.inputs.iter().enumerate().map(late);
    let mut acting: Option<Vec<Piece>> = None;
    for following in of_inputs.chain(followings.iter().copied()) {
        let before = acting.as_deref().unwrap_or(commanded);
        let later = (following.dead_time > 0.0).then(|| delayed(before, rig.inputs.len(), &following));
        let reshaped = with_mass(later.as_deref().unwrap_or(before), &following).or(later);
        acting = reshaped.or(acting);
    }
    acting
}

/// Pieces in which an input acts later by a dead time; of `inputs` inputs leaps are jumps.
fn delayed(pieces: &[Piece], inputs: usize, following: &Following) -> Vec<Piece> {
    let columns = pieces.first().map_or(0, |piece| piece.from.len());
    let line = |column: usize| {
        let later = if column == following.input { following.dead_time } else { 0.0 };
        let stretches = pieces.iter().map(|piece| piece.stretch(column));
        let mut late: Vec<Stretch> =
            stretches.map(|one| Stretch { start: one.start + later, end: one.end + later, ..one }).collect();
        // What acted before the first piece is what it began with.
        if let Some(first) = late.first_mut() {
            first.start -= later;
        }
        late
    };
    let lines: Vec<Vec<Stretch>> = (0..columns).map(line).collect();
    let (start, end) = pieces.first().zip(pieces.last()).map_or((0.0, 0.0), |(first, last)| (first.start, last.end));
    let mut merged = merge(&lines, inputs, start, end);
    // Where parameters change, a piece begins with a jump although no input leaps.
    let changes = pieces.windows(2).filter(|pair| pair[1].jump && pair[0].to == pair[1].from).map(|pair| pair[1].start);
    for change in changes {
        merged.iter_mut().filter(|piece| piece.start == change).for_each(|piece| piece.jump = true);
    }
    merged
}

/// Pieces in which an input acts as what follows it with mass needs it; `None` where nothing moves or has mass.
fn with_mass(pieces: &[Piece], following: &Following) -> Option<Vec<Piece>> {
    let input = following.input;
    let ends = pieces.iter().flat_map(|piece| [piece.from[input], piece.to[input]]);
    let (low, high) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), u| (low.min(u), high.max(u)));
    let span = high - low;
    let has_mass = following.inertia_time > NO_MASS * following.lag;
    let first = pieces.first().filter(|_| span > 0.0 && following.lag > 0.0 && has_mass)?;
    // The run begins with the spool where the command has it.
    let mut spool = Spool::at_rest(following, first.from[input]);
    let mut reshaped = Vec::new();
    for piece in pieces {
        reshape(piece, input, &mut spool, span, &mut reshaped);
    }
    Some(reshaped)
}

/// Writes a piece with its command reshaped: cut into short ones until the spool has arrived, the rest as it is.
fn reshape(piece: &Piece, input: usize, spool: &mut Spool, span: f64, pieces: &mut Vec<Piece>) {
    let length = piece.end - piece.start;
    let at = |share: f64| -> Vec<f64> {
        piece.from.iter().zip(&piece.to).map(|(from, to)| from + share * (to - from)).collect()
    };
    // The time constant of what is left of a spool with mass is no shorter than T.
    let step = spool.inertia.sqrt() / STEPS;
    let mut begun = 0.0;
    while begun < 1.0 {
        let command = |share: f64| piece.from[input] + share * (piece.to[input] - piece.from[input]);
        let standing = piece.from[input] == piece.to[input];
        let until = if standing && spool.has_arrived(command(begun), span) {
            (spool.position, spool.velocity) = (command(begun), 0.0);
            1.0
        } else {
            let next = begun + step / length;
            // No piece shorter than half a step at the end.
            if next + 0.5 * step / length >= 1.0 { 1.0 } else { next }
        };
        let (mut from, mut to) = (at(begun), at(until));
        from[input] = spool.reshaped();
        if spool.velocity != 0.0 || spool.position != command(begun) {
            spool.step((until - begun) * length, (command(begun), command(until)));
        }
        to[input] = spool.reshaped();
        let time = |share: f64| if share == 1.0 { piece.end } else { piece.start + share * length };
        let jump = piece.jump && begun == 0.0;
        pieces.push(Piece { start: time(begun), end: time(until), from, to, jump });
        begun = until;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One step of the command at 0.1 s, then standing.
    fn step_up() -> Vec<Piece> {
        let piece =
            |start: f64, end: f64, value: f64| Piece { start, end, from: vec![value], to: vec![value], jump: true };
        vec![piece(0.0, 0.1, 0.0), piece(0.1, 0.3, 1.0)]
    }

    /// Of a lag, s, and a damping.
    fn following(lag: f64, damping: f64) -> Following {
        Following { input: 0, lag, inertia_time: lag / (2.0 * damping), dead_time: 0.0 }
    }

    /// What a lag of first order makes of a drive at a time, exactly for straight pieces.
    fn lagged(pieces: &[Piece], lag: f64, until: f64) -> f64 {
        let mut s = pieces[0].from[0];
        for piece in pieces.iter().take_while(|piece| piece.start < until) {
            let length = until.min(piece.end) - piece.start;
            let slope = (piece.to[0] - piece.from[0]) / (piece.end - piece.start);
            // s' = (a + b t - s)/lag: particular solution a + b (t - lag), the rest decays.
            let particular = |t: f64| piece.from[0] + slope * (t - lag);
            s = particular(length) + (s - particular(0.0)) * (-length / lag).exp();
        }
        s
    }

    #[test]
    fn a_lag_behind_it_answers_as_a_spool_with_mass() {
        let (lag, damping) = (8e-3, 0.7);
        let pieces = with_mass(&step_up(), &following(lag, damping)).unwrap();
        // Step response of the second order, damping 0.7: ISO 2041's damped oscillator.
        let omega = 2.0 * damping / lag;
        let damped = omega * (1.0 - damping * damping).sqrt();
        for t in [2e-3, 5e-3, 0.01, 0.02, 0.035, 0.06] {
            let wave = (damped * t).cos() + damping * omega / damped * (damped * t).sin();
            let exact = 1.0 - (-damping * omega * t).exp() * wave;
            approx::assert_abs_diff_eq!(lagged(&pieces, lag, 0.1 + t), exact, epsilon = 2e-3);
        }
        let peak = (0..200).map(|k| lagged(&pieces, lag, 0.1 + 5e-4 * f64::from(k))).fold(0.0, f64::max);
        // Overshoot exp(-pi zeta/sqrt(1 - zeta²)) = 4.6 %.
        approx::assert_abs_diff_eq!(peak, 1.046, epsilon = 2e-3);
    }

    #[test]
    fn pieces_follow_each_other_and_end_where_they_ended() {
        let pieces = with_mass(&step_up(), &following(8e-3, 0.7)).unwrap();
        assert!(pieces.windows(2).all(|pair| pair[0].end == pair[1].start && pair[0].start < pair[0].end));
        assert_eq!((pieces[0].start, pieces[pieces.len() - 1].end), (0.0, 0.3));
        // Where nothing moves nothing is cut.
        assert!(pieces.iter().filter(|piece| piece.end <= 0.1).count() == 1 && pieces.len() < 400);
    }

    #[test]
    fn a_dead_time_moves_one_input_and_leaves_the_others() {
        let piece = |start: f64, end: f64, inputs: [f64; 2], jump| Piece {
            start,
            end,
            from: inputs.to_vec(),
            to: inputs.to_vec(),
            jump,
        };
        // Times without rounding, so that their sum is exact.
        let both = [piece(0.0, 0.125, [0.0, 5.0], true), piece(0.125, 0.5, [1.0, 6.0], true)];
        let late = Following { dead_time: 0.0625, ..following(8e-3, 1.0) };
        let expected = [
            piece(0.0, 0.125, [0.0, 5.0], true),
            piece(0.125, 0.1875, [0.0, 6.0], true),
            piece(0.1875, 0.5, [1.0, 6.0], true),
        ];
        assert_eq!(delayed(&both, 2, &late), expected);
    }
}
