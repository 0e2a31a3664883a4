//! When a line passes a limit.

use serde::Serialize;

use super::regression::Line;

/// Where a fault stands on its way to its limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum State {
    /// The line is beyond the limit at the last run, and so is its interval.
    Passed,
    /// The interval of the line at the last run holds the limit.
    AtLimit,
    /// The line comes closer, and so does every line within the uncertainty.
    WillPass,
    /// The line comes closer, or may do so; lines that never arrive are within the uncertainty.
    MayPass,
    /// Every line within the uncertainty moves away.
    Receding,
}

/// When the line passes the limit, on its own axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passing {
    pub state: State,
    /// Where the line itself passes; `None` where it does not.
    pub at: Option<f64>,
    /// Where the 95 % band of the line passes, first and last; an open end where it does not.
    pub between: [Option<f64>; 2],
}

/// When the line passes `limit`, seen from `last`, the last run; `upwards` says from which side.
///
/// The ends are those of Fieller (Suppl. J. R. Stat. Soc. 7 (1940) 1): where the limit enters and leaves the 95 % band of
/// the line.
pub fn passing(line: &Line, limit: f64, upwards: bool, last: f64) -> Passing {
    let sign = if upwards { 1.0 } else { -1.0 };
    let room = sign * (limit - line.value(last));
    let half = line.half_width(last);
    let slope_half = line.t * line.slope_sigma;
    let state = if room < -half {
        State::Passed
    } else if room <= half {
        State::AtLimit
    } else if sign * line.slope > slope_half {
        State::WillPass
    } else if sign * line.slope > -slope_half {
        State::MayPass
    } else {
        return Passing { state: State::Receding, at: None, between: [None, None] };
    };
    let at = (line.slope * sign > 0.0).then(|| line.at + (limit - line.level) / line.slope);
    Passing { state, at, between: [entering(line, limit, sign, 1.0), entering(line, limit, sign, -1.0)] }
}

/// Where the end of the band that is ahead (`side` 1) or behind (-1) comes to the limit from the healthy side.
fn entering(line: &Line, limit: f64, sign: f64, side: f64) -> Option<f64> {
    // (slope^2 - t^2 s_b^2) u^2 - 2 slope d u + d^2 - t^2 s_a^2 = 0 with u = x - at and d = limit - level.
    let (slope, distance) = (sign * line.slope, sign * (limit - line.level));
    let (slope_half, level_half) = (line.t * line.slope_sigma, line.t * line.level_sigma);
    let square = slope * slope - slope_half * slope_half;
    let free = distance * distance - level_half * level_half;
    let root = (slope * slope * distance * distance - square * free).sqrt();
    // Each crossing of either end is one of the two, the ends being one curve; the sides differ in their sign.
    [(slope * distance - root) / square, (slope * distance + root) / square].into_iter().find_map(|u| {
        let half = level_half.hypot(slope_half * u);
        let own = (distance - slope * u) * side >= 0.0;
        let rising = slope + side * slope_half * slope_half * u / half > 0.0;
        (u.is_finite() && own && rising).then_some(line.at + u)
    })
}
