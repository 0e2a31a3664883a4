//! What of a residual does not change from window to window: parameters as numbers that carry derivatives.

use crate::numeric::{Dual, Real};

/// Readings by which the first and second derivatives are taken together.
pub(super) const BENDS: usize = 4;
/// A number with its first and second derivatives.
pub(super) type Second = Dual<Dual<f64, BENDS>, BENDS>;

/// Unknowns that are differentiated by together.
pub(super) const LANES: usize = 4;

/// Something that is uncertain but constant.
#[derive(Debug, Clone, Copy)]
pub(super) enum Unknown {
    /// A parameter of the rig and its standard uncertainty, SI.
    Parameter(usize, f64),
    /// A reading and what rounding does to it, SI.
    Reading(usize, f64),
}

/// Unknowns with the parameters that differentiate by them.
pub(super) struct Lanes {
    pub unknowns: Vec<Unknown>,
    pub parameters: Vec<Dual<f64, LANES>>,
}

impl Lanes {
    pub fn new(nominal: &[f64], unknowns: &[Unknown]) -> Self {
        let mut parameters: Vec<Dual<f64, LANES>> = nominal.iter().map(|&value| Dual::constant(value)).collect();
        for (lane, unknown) in unknowns.iter().enumerate() {
            if let Unknown::Parameter(index, _) = *unknown {
                parameters[index].eps[lane] = 1.0;
            }
        }
        Self { unknowns: unknowns.to_vec(), parameters }
    }
}

/// What of a residual and a rig does not change from frame to frame.
pub(super) struct Known {
    pub nominal: Vec<f64>,
    pub second: Vec<Second>,
    pub lanes: Vec<Lanes>,
}
