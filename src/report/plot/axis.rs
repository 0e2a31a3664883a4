//! Ranges and ticks of an axis.

use super::Axis;

/// The grid on which the curves of a page lie.
pub(super) const WIDE: f64 = 10_000.0;
pub(super) const HIGH: f64 = 5_000.0;

/// Share of a step that may stand out over the last tick.
const SLACK: f64 = 0.03;

/// An axis laid onto pixels.
#[derive(Debug, Clone)]
pub(super) struct Scale {
    from: f64,
    to: f64,
    start: f64,
    end: f64,
    pub ticks: Vec<f64>,
    /// Power of ten of the step between ticks.
    power: i32,
    scientific: bool,
}

impl Scale {
    /// Lays an axis that shows `values` onto the pixels from `start` to `end`, with about one tick in `spacing` px.
    /// A range that is not given is widened to whole ticks where `whole` asks for it.
    pub fn new(
        axis: &Axis,
        values: impl Iterator<Item = f64>,
        (start, end): (f64, f64),
        spacing: f64,
        whole: bool,
    ) -> Self {
        let seen = values.filter(|value| value.is_finite()).fold(None, |seen: Option<(f64, f64)>, value| {
            Some(seen.map_or((value, value), |(low, high)| (low.min(value), high.max(value))))
        });
        let given = axis.range.filter(|(from, to)| from.is_finite() && to.is_finite() && from < to);
        let (mut from, mut to) = given.or(seen).unwrap_or((0.0, 1.0));
        if to - from <= 1e-9 * from.abs().max(to.abs()) {
            let half = if from == 0.0 { 1.0 } else { 0.1 * from.abs() };
            (from, to) = (from - half, to + half);
        }
        let count = ((end - start).abs() / spacing).max(2.0);
        let step = nice(to / count - from / count);
        if given.is_none() && whole {
            // A value that reaches past a tick by less than a pixel or so does not ask for another one.
            from = (from / step + SLACK).floor() * step;
            to = (to / step - SLACK).ceil() * step;
        }
        let first = (from / step - 1e-6).ceil();
        let last = (to / step + 1e-6).floor();
        let ticks = (0..=(last - first).clamp(0.0, 50.0) as usize).map(|k| (first + k as f64) * step).collect();
        let largest = from.abs().max(to.abs());
        let power = (step.log10() + 1e-9).floor() as i32;
        Self { from, to, start, end, ticks, power, scientific: !(1e-4..1e6).contains(&largest) }
    }

    /// Pixel of a value.
    pub fn at(&self, value: f64) -> f64 {
        // Divided first: the difference of two huge ends may overflow.
        let span = self.to / 2.0 - self.from / 2.0;
        let share = (value / 2.0 - self.from / 2.0) / span;
        self.start + share.clamp(-4.0, 5.0) * (self.end - self.start)
    }

    /// Ends of the axis, in its unit.
    pub fn ends(&self) -> (f64, f64) {
        (self.from, self.to)
    }

    /// A tick's number, with no more decimals than the ticks need.
    pub fn number(&self, tick: f64) -> String {
        let text = if !self.scientific {
            format!("{tick:.*}", (-self.power).clamp(0, 9) as usize)
        } else if tick.abs() < 0.5 * 10_f64.powi(self.power) {
            "0".to_owned()
        } else {
            // Digits behind the first one, down to those of the step.
            let digits = (tick.abs().log10() + 1e-9).floor() as i32 - self.power;
            format!("{tick:.*e}", digits.clamp(0, 9) as usize)
        };
        let zero = text.trim_start_matches('-').chars().all(|c| matches!(c, '0' | '.'));
        if zero { text.trim_start_matches('-').to_owned() } else { text.replace('-', "\u{2212}") }
    }
}

/// The smallest of 1, 2, 5 times a power of ten that is not below `step`.
fn nice(step: f64) -> f64 {
    let power = 10_f64.powf(step.log10().floor());
    let factor = [1.0, 2.0, 5.0].into_iter().find(|factor| factor * power >= step * (1.0 - 1e-9));
    factor.unwrap_or(10.0) * power
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(from: f64, to: f64) -> Vec<String> {
        let scale = Scale::new(&Axis::new("x", "-"), [from, to].into_iter(), (0.0, 300.0), 50.0, true);
        scale.ticks.iter().map(|&tick| scale.number(tick)).collect()
    }

    #[test]
    fn ticks_are_round_and_carry_no_needless_decimals() {
        assert_eq!(labels(0.0, 5.5), ["0", "1", "2", "3", "4", "5", "6"]);
        assert_eq!(labels(-0.03, 0.07), ["\u{2212}0.04", "\u{2212}0.02", "0.00", "0.02", "0.04", "0.06", "0.08"]);
        assert_eq!(labels(100.0, 103.0), ["100.0", "100.5", "101.0", "101.5", "102.0", "102.5", "103.0"]);
        assert_eq!(
            labels(0.0, 2.1e-6),
            ["0", "5e\u{2212}7", "1.0e\u{2212}6", "1.5e\u{2212}6", "2.0e\u{2212}6", "2.5e\u{2212}6"]
        );
        assert_eq!(labels(0.0, 5e6), ["0", "1e6", "2e6", "3e6", "4e6", "5e6"]);
        assert_eq!(labels(7.0, 7.0), ["6.0", "6.5", "7.0", "7.5", "8.0"]);
    }
}
