//! Robust losses: how much an outlier may pull.

/// The loss `rho(s)` of a squared misfit `s = r^2`; a fit minimises `1/2 sum rho(r^2)`.
///
/// All grow like `s` near zero; the width `k` is in units of the misfit, so in standard deviations of the sensor.
/// Source: Triggs et al., *Bundle adjustment: a modern synthesis* (2000), section 4.3; the parametrisation of Ceres Solver.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Loss {
    /// `rho = s`: least squares.
    #[default]
    None,
    /// `rho = s` up to `k^2`, then `2 k sqrt(s) - k^2`: an outlier pulls with constant force.
    Huber { k: f64 },
    /// `rho = 2 k^2 (sqrt(1 + s/k^2) - 1)`: Huber without the kink.
    SoftL1 { k: f64 },
    /// `rho = k^2 ln(1 + s/k^2)`: the further out, the weaker the pull. Not convex, so it needs a good start.
    Cauchy { k: f64 },
}

impl Loss {
    /// `rho`, its first and its second derivative at `s = r^2`.
    pub fn at(self, s: f64) -> (f64, f64, f64) {
        match self {
            Self::None => (s, 1.0, 0.0),
            Self::Huber { k } if s <= k * k => (s, 1.0, 0.0),
            Self::Huber { k } => {
                let r = s.sqrt();
                (2.0 * k * r - k * k, k / r, -0.5 * k / (r * s))
            }
            Self::SoftL1 { k } => {
                let u = 1.0 + s / (k * k);
                let root = u.sqrt();
                (2.0 * k * k * (root - 1.0), 1.0 / root, -0.5 / (k * k * u * root))
            }
            Self::Cauchy { k } => {
                let u = 1.0 + s / (k * k);
                (k * k * u.ln(), 1.0 / u, -1.0 / (k * k * u * u))
            }
        }
    }

    /// The cost `1/2 sum rho(r^2)`, without unit.
    pub fn cost(self, misfit: &[f64]) -> f64 {
        if self == Self::None {
            return 0.5 * misfit.iter().map(|r| r * r).sum::<f64>();
        }
        0.5 * misfit.iter().map(|r| self.at(r * r).0).sum::<f64>()
    }

    /// `rho'(r^2)`: the weight of a row in the quadratic model of the cost that never lies below it.
    ///
    /// With it each step of least squares lowers the cost (iteratively reweighted least squares; Holland and Welsch,
    /// Communications in Statistics A6 (1977)).
    pub fn weight(self, r: f64) -> f64 {
        self.at(r * r).1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_agree_with_differences() {
        for loss in [Loss::None, Loss::Huber { k: 1.3 }, Loss::SoftL1 { k: 0.7 }, Loss::Cauchy { k: 2.0 }] {
            for s in [0.2, 1.0, 4.0, 90.0] {
                let h = 1e-5 * s;
                let (_, slope, bend) = loss.at(s);
                let (above, below) = (loss.at(s + h), loss.at(s - h));
                approx::assert_relative_eq!(slope, (above.0 - below.0) / (2.0 * h), max_relative = 1e-7);
                approx::assert_abs_diff_eq!(bend, (above.1 - below.1) / (2.0 * h), epsilon = 1e-7);
            }
        }
    }

    #[test]
    fn the_weighted_square_never_lies_below_the_loss() {
        for loss in [Loss::Huber { k: 1.3 }, Loss::SoftL1 { k: 0.7 }, Loss::Cauchy { k: 2.0 }] {
            for at in [0.3_f64, 2.0, -9.0] {
                for r in [0.0_f64, 0.7, 5.0, 40.0] {
                    let square = loss.at(at * at).0 + loss.weight(at) * (r * r - at * at);
                    assert!(square >= loss.at(r * r).0 - 1e-9, "{loss:?} at {at}: {r}");
                }
            }
        }
    }
}
