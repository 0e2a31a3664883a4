//! How the rows of a record follow each other in time.

/// The intervals between rows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sampling {
    /// The median interval, s.
    pub interval: f64,
    /// The shortest interval, s.
    pub shortest: f64,
    /// The longest interval, s.
    pub longest: f64,
    /// Whether every interval is the median one, but for the rounding of the written time.
    pub regular: bool,
}

/// Part of an interval that a clock may be off without the sampling being irregular.
const CLOCK_TOLERANCE: f64 = 1e-3;

impl Sampling {
    /// Of rising times, s, that were written with this number of decimals; `None` with fewer than two.
    pub fn of(time: &[f64], decimals: Option<usize>) -> Option<Self> {
        let mut intervals: Vec<f64> = time.iter().zip(time.iter().skip(1)).map(|(early, late)| late - early).collect();
        intervals.sort_by(f64::total_cmp);
        let shortest = *intervals.first()?;
        let longest = *intervals.last()?;
        let upper = *intervals.get(intervals.len() / 2)?;
        let lower = *intervals.get((intervals.len() - 1) / 2)?;
        let interval = f64::midpoint(lower, upper);
        // Two rounded times differ by at most one last digit more or less than the true ones; a coarse last digit must
        // not hide a missing row.
        let last_digit = decimals.map_or(0.0, |count| 10f64.powf(-(count as f64)));
        let tolerance = (CLOCK_TOLERANCE * interval).max((1.01 * last_digit).min(0.4 * interval));
        Some(Self {
            interval,
            shortest,
            longest,
            regular: longest - interval <= tolerance && interval - shortest <= tolerance,
        })
    }
}
