//! A drive whose commands are reshaped, so that a lag of first order behind them answers as a spool with mass and dead time would.
//!
//! A spool of second order follows `T² s'' + tau s' + s = u(t - t_d)`. A lag of first order that is driven by `v = s + tau s'` gives
//! the same `s`, since `tau s' + s = v`. So another dynamic of the spool needs no other model, only another command.

use super::piece::{Piece, SAME, leaps, merge, split};
use super::stretch::Stretch;
use crate::rig::{Input, Rig};

/// Steps of the fourth order in each time constant of the spool: errors of 1e-4 of a stroke.
const STEPS: f64 = 16.0;
/// Distance from the command at which the spool has arrived, as a share of the span of the command.
const ARRIVED: f64 = 1e-4;
/// How near to it straight stretches pass what those steps give, as a share of that span: a valve of 40 L/min at 5 bar that is so much
/// open for 20 ms as it closes lets 0.3 mm³ pass under 5 bar, 0.04 bar in a chamber of 100 cm³.
const NEAR: f64 = 2e-5;

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

    fn has_mass(&self) -> bool {
        self.lag > 0.0 && self.inertia_time > NO_MASS * self.lag
    }

    /// Whether anything acts otherwise than it is commanded.
    fn acts_otherwise(&self) -> bool {
        self.dead_time > 0.0 || self.has_mass()
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

    /// Follows a command, and writes the one that a lag of first order has to be given; what is nearer than `near` to it is there.
    fn follow(&mut self, command: &Stretch, near: f64, reshaped: &mut Thinned) {
        let length = command.end - command.start;
        let at = |share: f64| command.from + share * (command.to - command.from);
        let standing = command.from == command.to;
        // The time constant of what is left of a spool with mass is no shorter than T.
        let step = self.inertia.sqrt() / STEPS / length;
        let mut begun = 0.0;
        while begun < 1.0 {
            let away = (self.position - command.to).abs() + self.lag * self.velocity.abs();
            if standing && away <= near {
                (self.position, self.velocity) = (command.to, 0.0);
                // A valve that stays a ten-thousandth open would fill what it shuts.
                if away > 0.0 && begun + step < 1.0 {
                    reshaped.corner();
                    reshaped.through((command.start + (begun + step) * length, command.to));
                    reshaped.corner();
                }
                reshaped.through((command.end, command.to));
                return;
            }
            // No stretch shorter than half a step at the end.
            let until = if begun + 1.5 * step >= 1.0 { 1.0 } else { begun + step };
            self.step((until - begun) * length, (at(begun), at(until)));
            let time = if until == 1.0 { command.end } else { command.start + until * length };
            reshaped.through((time, self.reshaped()));
            begun = until;
        }
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
    let late = |(input, own): (usize, &Input)| {
        let dead_time = own.dead_time.map_or(0.0, |index| rig.parameters[index].value);
        Following { input, lag: 0.0, inertia_time: 0.0, dead_time }
    };
    let of_inputs = rig.inputs.iter().enumerate().map(late);
    let mut lines: Option<Vec<Line>> = None;
    for following in of_inputs.chain(followings.iter().copied()).filter(Following::acts_otherwise) {
        let lines = lines.get_or_insert_with(|| Line::all(commanded));
        lines[following.input].follow(&following);
    }
    lines.map(|lines| merged(lines, commanded, rig.inputs.len()))
}

/// The pieces had inputs acted later by so many s, each by its index, or sooner.
pub(super) fn shifted(pieces: &[Piece], by: &[(usize, f64)], inputs: usize) -> Vec<Piece> {
    let mut lines = Line::all(pieces);
    by.iter().for_each(|&(input, later)| lines[input].shift(later));
    merged(lines, pieces, inputs)
}

/// One input of a drive by itself, with corners only where it bends: the solver stops at each.
struct Line {
    stretches: Vec<Stretch>,
    /// When it leaps, s.
    jumps: Vec<f64>,
}

impl Line {
    /// Every input of a drive.
    fn all(pieces: &[Piece]) -> Vec<Self> {
        let columns = pieces.first().map_or(0, |piece| piece.from.len());
        (0..columns).map(|column| Self::of(pieces, column)).collect()
    }

    fn of(pieces: &[Piece], column: usize) -> Self {
        let (mut stretches, mut jumps): (Vec<Stretch>, _) = (Vec::new(), Vec::new());
        for piece in pieces {
            let next = piece.stretch(column);
            match stretches.last_mut() {
                Some(last) if !leaps(last.to, next.from) && last.goes_through(next.end, next.to) => {
                    (last.end, last.to) = (next.end, next.to);
                }
                last => {
                    jumps.extend(last.filter(|last| next.may_jump && leaps(last.to, next.from)).map(|_| next.start));
                    stretches.push(next);
                }
            }
        }
        Self { stretches, jumps }
    }

    /// Acts as what follows it needs it.
    fn follow(&mut self, following: &Following) {
        self.shift(following.dead_time);
        if following.has_mass() {
            self.stretches = with_mass(&self.stretches, following, &self.jumps);
        }
    }

    /// Acts later by so many s, or sooner. Before the first stretch acted what it began with, behind the last one acts what it ended with.
    fn shift(&mut self, later: f64) {
        let (Some(&first), Some(&last)) = (self.stretches.first(), self.stretches.last()) else { return };
        let (begin, end) = (first.start, last.end);
        for stretch in &mut self.stretches {
            (stretch.start, stretch.end) = (stretch.start + later, stretch.end + later);
        }
        self.jumps.iter_mut().for_each(|jump| *jump += later);
        if later < 0.0 {
            self.jumps.retain(|&jump| jump > begin);
            self.stretches.retain(|stretch| stretch.end > begin);
        }
        let still = |start: f64, end: f64, value: f64| Stretch { start, end, from: value, to: value, may_jump: false };
        match self.stretches.first_mut() {
            Some(first) if first.start > begin && first.from != first.to => {
                let before = still(begin, first.start, first.from);
                self.stretches.insert(0, before);
            }
            Some(first) => (first.start, first.from) = (begin, first.at(begin.max(first.start))),
            None => {}
        }
        if later < 0.0 {
            self.stretches.push(still((end + later).max(begin), end, last.to));
        }
    }
}

/// The lines of a drive as its pieces, which begin and end where the commanded ones do. A leap of what acts, or of what it follows, is a
/// jump, and so is one where nothing leaps: where parameters change.
fn merged(lines: Vec<Line>, commanded: &[Piece], inputs: usize) -> Vec<Piece> {
    let (start, end) =
        commanded.first().zip(commanded.last()).map_or((0.0, 0.0), |(first, last)| (first.start, last.end));
    let leaps = lines.iter().take(inputs).flat_map(|line| line.jumps.iter().copied());
    let changes = commanded.windows(2).filter(|pair| pair[1].jump && pair[0].to == pair[1].from);
    let jumps: Vec<f64> = leaps.chain(changes.map(|pair| pair[1].start)).collect();
    let stretches: Vec<Vec<Stretch>> = lines.into_iter().map(|line| line.stretches).collect();
    let mut pieces = merge(&stretches, inputs, start, end);
    for jump in jumps {
        let rounding = SAME * (end - start);
        let next = pieces.partition_point(|piece| piece.start < jump - rounding);
        match pieces.get_mut(next) {
            Some(piece) if piece.start <= jump + rounding => piece.jump = true,
            _ => split(&mut pieces, jump),
        }
    }
    pieces
}

/// A line as what follows it with mass needs it, with corners wherever it leaps.
fn with_mass(line: &[Stretch], following: &Following, jumps: &[f64]) -> Vec<Stretch> {
    let ends = line.iter().flat_map(|stretch| [stretch.from, stretch.to]);
    let (low, high) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), u| (low.min(u), high.max(u)));
    let Some(first) = line.first().filter(|_| high > low) else { return line.to_vec() };
    // The run begins with the spool where the command has it.
    let mut spool = Spool::at_rest(following, first.from);
    let span = high - low;
    let mut reshaped = Thinned::from((first.start, spool.reshaped()), NEAR * span);
    for stretch in line {
        if jumps.contains(&stretch.start) {
            reshaped.corner();
        }
        spool.follow(stretch, ARRIVED * span, &mut reshaped);
    }
    reshaped.corner();
    reshaped.stretches
}

/// A broken line through points that come one after the other, in which one straight stretch stands for all that lie near it
/// (C. M. Williams, Computer Graphics and Image Processing 8 (1978), with stretches that end at points).
struct Thinned {
    stretches: Vec<Stretch>,
    /// How far from a point a stretch may pass.
    near: f64,
    /// Where the stretch under way begins, and the last point: time before value.
    from: (f64, f64),
    last: (f64, f64),
    /// Slopes with which it passes near all points since.
    slopes: (f64, f64),
}

impl Thinned {
    fn from(point: (f64, f64), near: f64) -> Self {
        Self { stretches: Vec::new(), near, from: point, last: point, slopes: (f64::NEG_INFINITY, f64::INFINITY) }
    }

    fn through(&mut self, point: (f64, f64)) {
        let slope = |from: (f64, f64), off: f64| (point.1 + off - from.1) / (point.0 - from.0);
        let (low, high) = self.slopes;
        if !(low..=high).contains(&slope(self.from, 0.0)) {
            self.corner();
        }
        let (low, high) = self.slopes;
        self.slopes = (low.max(slope(self.from, -self.near)), high.min(slope(self.from, self.near)));
        self.last = point;
    }

    /// Ends the stretch under way at the last point.
    fn corner(&mut self) {
        let ((start, from), (end, to)) = (self.from, self.last);
        if end > start {
            self.stretches.push(Stretch { start, end, from, to, may_jump: false });
        }
        *self = Self { stretches: std::mem::take(&mut self.stretches), ..Self::from(self.last, self.near) };
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

    /// The pieces of a drive whose first input is followed like this.
    fn followed(pieces: &[Piece], following: &Following) -> Vec<Piece> {
        let mut lines = Line::all(pieces);
        lines[0].follow(following);
        merged(lines, pieces, pieces[0].from.len())
    }

    #[test]
    fn a_lag_behind_it_answers_as_a_spool_with_mass() {
        let (lag, damping) = (8e-3, 0.7);
        let pieces = followed(&step_up(), &following(lag, damping));
        // Step response of the second order, damping 0.7: ISO 2041's damped oscillator.
        let omega = 2.0 * damping / lag;
        let damped = omega * (1.0 - damping * damping).sqrt();
        for t in [2e-3, 5e-3, 0.01, 0.02, 0.035, 0.06] {
            let wave = (damped * t).cos() + damping * omega / damped * (damped * t).sin();
            let exact = 1.0 - (-damping * omega * t).exp() * wave;
            approx::assert_abs_diff_eq!(lagged(&pieces, lag, 0.1 + t), exact, epsilon = 5e-4);
        }
        let peak = (0..200).map(|k| lagged(&pieces, lag, 0.1 + 5e-4 * f64::from(k))).fold(0.0, f64::max);
        // Overshoot exp(-pi zeta/sqrt(1 - zeta²)) = 4.6 %.
        approx::assert_abs_diff_eq!(peak, 1.046, epsilon = 5e-4);
    }

    #[test]
    fn a_ramp_is_followed_from_its_beginning() {
        let (lag, damping) = (8e-3, 0.7);
        let piece =
            |start: f64, end: f64, from: f64, to: f64, jump| Piece { start, end, from: vec![from], to: vec![to], jump };
        let ramp = [piece(0.0, 0.1, 0.0, 0.0, true), piece(0.1, 0.3, 0.0, 1.0, false)];
        let pieces = followed(&ramp, &following(lag, damping));
        let omega = 2.0 * damping / lag;
        let damped = omega * (1.0 - damping * damping).sqrt();
        for t in [2e-3, 5e-3, 0.01, 0.02, 0.06, 0.19] {
            // Ramp response of the second order: behind by the lag once it has settled.
            let wave = lag * (damped * t).cos() + (2.0 * damping * damping - 1.0) / damped * (damped * t).sin();
            let exact = 5.0 * (t - lag + (-damping * omega * t).exp() * wave);
            approx::assert_abs_diff_eq!(lagged(&pieces, lag, 0.1 + t), exact, epsilon = 1e-4);
        }
        // Fine steps would be four hundred.
        assert!(pieces.len() < 60, "{}", pieces.len());
    }

    #[test]
    fn a_corner_of_one_input_is_none_of_another() {
        // The second input bends a hundred times, the first steps once and acts later.
        let time = |k: i32| f64::from(k) / 256.0;
        let piece = |k: i32| {
            let first = f64::from(i32::from(k >= 50));
            let bend = |k: i32| f64::from(k % 2);
            let (from, to) = (vec![first, bend(k)], vec![first, bend(k + 1)]);
            Piece { start: time(k), end: time(k + 1), from, to, jump: k == 0 || k == 50 }
        };
        let both: Vec<Piece> = (0..100).map(piece).collect();
        let late = Following { lag: 0.0, dead_time: 1.0 / 1024.0, ..following(8e-3, 1.0) };
        let pieces = followed(&both, &late);
        assert_eq!(pieces.len(), 101);
        let jumps: Vec<f64> = pieces.iter().filter(|piece| piece.jump).map(|piece| piece.start).collect();
        assert_eq!(jumps, [0.0, time(50) + 1.0 / 1024.0]);
    }

    #[test]
    fn pieces_follow_each_other_and_end_where_they_ended() {
        let pieces = followed(&step_up(), &following(8e-3, 0.7));
        assert!(pieces.windows(2).all(|pair| pair[0].end == pair[1].start && pair[0].start < pair[0].end));
        assert_eq!((pieces[0].start, pieces[pieces.len() - 1].end), (0.0, 0.3));
        // Where nothing moves nothing is cut.
        assert!(pieces.iter().filter(|piece| piece.end <= 0.1).count() == 1 && pieces.len() < 140, "{}", pieces.len());
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
        let late = Following { lag: 0.0, dead_time: 0.0625, ..following(8e-3, 1.0) };
        let expected = [
            piece(0.0, 0.125, [0.0, 5.0], true),
            piece(0.125, 0.1875, [0.0, 6.0], true),
            piece(0.1875, 0.5, [1.0, 6.0], true),
        ];
        assert_eq!(followed(&both, &late), expected);
    }
}
