//! An estimate and its interval with as many digits as the interval is worth: two of its width, up to four where the estimate
//! would look like an end.

use crate::number::text;
pub use crate::number::worth;

/// Digits beyond those of the width that may tell an estimate from an end next to it.
const FURTHER: i32 = 2;

/// A value and the ends of its interval, in its unit; an end that the record does not bound is `None`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    pub value: f64,
    pub ends: [Option<f64>; 2],
}

impl Estimate {
    /// The value.
    pub fn value(&self) -> String {
        self.number(self.value)
    }

    /// The interval: both ends, or the one that is bounded; `open` where none is.
    pub fn interval(&self) -> String {
        match self.ends {
            [Some(low), Some(high)] => format!("{} to {}", self.number(low), self.number(high)),
            [Some(low), None] => format!("at least {}", self.number(low)),
            [None, Some(high)] => format!("at most {}", self.number(high)),
            [None, None] => "open".to_owned(),
        }
    }

    /// Another value of the same, such as the healthy one: with no more digits than these, as stated where that has fewer.
    pub fn beside(&self, other: f64) -> String {
        let (worth, stated) = (self.number(other), text(other));
        // Digits that the interval does not leave may be what tells the two apart.
        if worth.len() >= stated.len() || worth == self.value() && other != self.value { stated } else { worth }
    }

    fn number(&self, value: f64) -> String {
        // Of an interval with one end its bounded side.
        let width = match self.ends {
            [Some(low), Some(high)] => high - low,
            [Some(end), None] | [None, Some(end)] => (end - self.value).abs(),
            [None, None] => 0.0,
        };
        let finer = (0..=FURTHER).map(|further| width * 10_f64.powi(-further));
        worth(value, finer.into_iter().find(|width| self.apart(*width)).unwrap_or(width))
    }

    /// Whether the digits that `width` leaves tell the estimate from the ends that differ from it.
    fn apart(&self, width: f64) -> bool {
        let mut ends = self.ends.iter().flatten().filter(|end| **end != self.value);
        ends.all(|end| worth(*end, width) != worth(self.value, width))
    }
}

/// A value with its uncertainty, both with two digits of the latter.
pub fn plus_minus(value: f64, sigma: f64) -> String {
    format!("{} +- {}", worth(value, sigma), worth(sigma, sigma))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(value: f64, low: Option<f64>, high: Option<f64>) -> [String; 2] {
        let estimate = Estimate { value, ends: [low, high] };
        [estimate.value(), estimate.interval()]
    }

    #[test]
    fn a_value_beside_it_has_no_more_digits() {
        let estimate = Estimate { value: 0.082_43, ends: [Some(0.081_6), Some(0.083_3)] };
        assert_eq!(estimate.beside(0.012_956_9), "0.0130");
        assert_eq!(estimate.beside(0.05), "0.05");
        assert_eq!(estimate.beside(0.082_432), "0.082432");
    }

    #[test]
    fn digits_follow_the_width_of_the_interval() {
        assert_eq!(shown(1.000_001, Some(0.999_985_3), Some(1.000_012_1)), ["1.000001", "0.999985 to 1.000012"]);
        assert_eq!(shown(4.967_4, Some(4.741_2), Some(5.448_1)), ["4.97", "4.74 to 5.45"]);
        assert_eq!(shown(5.499, Some(5.498_6), Some(5.500_2)), ["5.4990", "5.4986 to 5.5002"]);
        assert_eq!(shown(-0.000_4, Some(-0.003), Some(0.002)), ["-0.0004", "-0.0030 to 0.0020"]);
        assert_eq!(shown(12_345.0, Some(11_000.0), Some(13_700.0)), ["12300", "11000 to 13700"]);
        assert_eq!(shown(3.0e-7, Some(-1.0e-8), Some(6.1e-7)), ["3.0e-7", "-1e-8 to 6.1e-7"]);
        assert_eq!(shown(2.5e9, Some(2.4e9), Some(2.61e9)), ["2.50e9", "2.40e9 to 2.61e9"]);
    }

    #[test]
    fn an_estimate_next_to_an_end_is_told_from_it() {
        assert_eq!(shown(0.007_4, Some(0.006_8), Some(0.021)), ["0.0074", "0.0068 to 0.0210"]);
        assert_eq!(shown(0.007_4, Some(0.007_400_000_1), Some(0.021)), ["0.007", "0.007 to 0.021"]);
        assert_eq!(shown(0.0, Some(0.0), Some(0.021)), ["0.000", "0.000 to 0.021"]);
    }

    #[test]
    fn nothing_below_the_last_digit_of_a_wide_uncertainty_is_shown() {
        assert_eq!(plus_minus(6.0, 100.0), "10 +- 100");
        assert_eq!(plus_minus(4.0, 100.0), "0 +- 100");
        assert_eq!(plus_minus(-1_234.0, 250.0), "-1230 +- 250");
        assert_eq!(plus_minus(14_000.0, 2_800.0), "14000 +- 2800");
        assert_eq!(plus_minus(0.03, 0.01), "0.030 +- 0.010");
    }

    #[test]
    fn an_open_end_is_worded_and_nothing_is_still_a_number() {
        assert_eq!(shown(5.156, Some(3.751), None), ["5.2", "at least 3.8"]);
        assert_eq!(shown(5.565e-7, None, Some(0.003_865)), ["0.0000", "at most 0.0039"]);
        assert_eq!(shown(0.0, None, Some(2.237e-6)), ["0", "at most 2.2e-6"]);
        assert_eq!(shown(0.25, None, None), ["0.25", "open"]);
        assert_eq!(shown(0.123_456, Some(0.123_456), None), ["0.1235", "at least 0.1235"]);
        assert_eq!(worth(-0.000_01, 0.01), "0.000");
        // Nothing has no digits before its decimals, however few these are.
        assert_eq!(worth(0.0, 1e5), "0");
    }
}
