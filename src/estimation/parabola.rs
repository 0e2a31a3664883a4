//! A curve through what a profile has been found to be at two values, and the value at which it is asked for.

/// The root of the rise along a profile: a parabola through the best value and two coordinates.
pub(super) struct Parabola {
    inner: (f64, f64),
    outer: (f64, f64),
    /// Of the chords from the best value to either.
    slopes: (f64, f64),
}

impl Parabola {
    /// Through two coordinates with their roots. Where the first of them is the best value itself, the parabola has the slope there that
    /// the local model gives it.
    pub(super) fn through(slope: f64, inner: (f64, f64), outer: (f64, f64)) -> Self {
        let first = if inner.0 == 0.0 { slope } else { inner.1 / inner.0 };
        Self { inner, outer, slopes: (first, outer.1 / outer.0) }
    }

    /// By how much the slope changes over the distance, as a share of it.
    fn bend(&self) -> f64 {
        (self.slopes.1 / self.slopes.0 - 1.0) * self.outer.0 / (self.outer.0 - self.inner.0)
    }

    /// By how much the crossing of `target` would be wrong, as a share of its distance, if the root were as straight on from the outer
    /// coordinate as it is found to be up to there; on the parabola it is less.
    pub(super) fn error(&self, target: f64) -> f64 {
        (target / self.outer.1 - 1.0).abs() * self.bend().abs()
    }

    /// Coordinate at which the root is `target`.
    pub(super) fn crossing(&self, target: f64) -> f64 {
        let ((inner, inner_root), (outer, outer_root)) = (self.inner, self.outer);
        let bend = (self.slopes.1 - self.slopes.0) / (outer - inner);
        let straight = inner + (outer - inner) * (target - inner_root) / (outer_root - inner_root);
        // Newton's method from the chord; the parabola is all but straight between two points of one side.
        let mut at = straight;
        for _ in 0..4 {
            let chord = self.slopes.0 + bend * (at - inner);
            at -= (at * chord - target) / (chord + bend * at);
        }
        // A parabola that has turned back says nothing.
        let near_chord = (at - straight).abs() <= 0.25 * (straight - inner).abs() && at.is_finite();
        if near_chord { at } else { straight }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn a_parabola_is_crossed_where_it_is() {
        // x (1 + x / 4): 1.25 at 1, 3 at 2.
        let first = Parabola::through(1.0, (0.0, 0.0), (1.0, 1.25));
        assert_relative_eq!(first.crossing(3.0), 2.0, max_relative = 1e-9);
        let second = Parabola::through(1.0, (1.0, 1.25), (1.2, 1.56));
        assert_relative_eq!(second.crossing(3.0), 2.0, max_relative = 1e-6);
        // A quarter steeper over the way to 1, and 3 is 1.4 times as far again.
        assert_relative_eq!(first.error(3.0), 0.25 * 1.4, max_relative = 1e-9);
        // The same bend, told from two points that are near each other: 4 % of the slope over a sixth of the way.
        assert_relative_eq!(second.bend(), (1.3 / 1.25 - 1.0) * 1.2 / 0.2, max_relative = 1e-9);
        assert_eq!(Parabola::through(1.0, (0.0, 0.0), (1.0, 1.0)).error(2.0), 0.0);
        // x (1 - x / 2) turns back at 1 and never gets to 0.505: the end is not carried off from the chord, which is at 1.01.
        let turned = Parabola::through(1.0, (0.0, 0.0), (1.0, 0.5));
        assert!(turned.error(0.505) < 0.01);
        assert!((turned.crossing(0.505) - 1.01).abs() < 0.25 * 1.01, "{}", turned.crossing(0.505));
    }
}
