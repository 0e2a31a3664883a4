//! What of a residual does not change from window to window: parameters as numbers that carry derivatives.

use crate::numeric::{Dual, Real};
use crate::physics::component::AnyLaw;
use crate::physics::fluid::{self, Fluid};
use crate::rig::Rig;

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
    pub parameters: Parameters<Dual<f64, LANES>>,
}

impl Lanes {
    pub fn new(rig: &Rig, nominal: &[f64], unknowns: &[Unknown]) -> Self {
        let mut parameters: Vec<Dual<f64, LANES>> = nominal.iter().map(|&value| Dual::constant(value)).collect();
        for (lane, unknown) in unknowns.iter().enumerate() {
            if let Unknown::Parameter(index, _) = *unknown {
                parameters[index].eps[lane] = 1.0;
            }
        }
        Self { unknowns: unknowns.to_vec(), parameters: Parameters::new(rig, parameters) }
    }
}

/// What of a residual and a rig does not change from frame to frame.
pub(super) struct Known {
    pub nominal: Parameters<f64>,
    pub second: Parameters<Second>,
    pub lanes: Vec<Lanes>,
}

/// All parameters of a rig as numbers of one kind, SI, with the laws that they give: made once, evaluated at many readings.
pub(super) struct Parameters<T> {
    pub values: Vec<T>,
    /// Of each component.
    pub laws: Vec<Option<Laws<T>>>,
}

/// The law of a component: as it is, and with a derivative by the state that is looked for, without and with all others.
pub(super) struct Laws<T> {
    pub own: AnyLaw<T>,
    pub plain: AnyLaw<Dual<f64, 1>>,
    pub lifted: AnyLaw<Dual<T, 1>>,
}

impl<T: Real> Parameters<T> {
    pub fn new(rig: &Rig, values: Vec<T>) -> Self {
        let laws = (0..rig.components.len()).map(|component| {
            Some(Laws {
                own: law(rig, component, &values, |value| value)?,
                plain: law(rig, component, &values, |value| Dual::lift(value.re()))?,
                lifted: law(rig, component, &values, Dual::lift)?,
            })
        });
        Self { laws: laws.collect(), values }
    }
}

/// The law of a component for the rig's parameters, each as another number.
fn law<T: Real, N: Real>(rig: &Rig, component: usize, p: &[T], lift: impl Fn(T) -> N) -> Option<AnyLaw<N>> {
    let this = &rig.components[component];
    let of_fluid: Vec<N> = p.get(..fluid::CARD.parameters.len())?.iter().map(|&value| lift(value)).collect();
    this.law(|index| lift(p[index]), &Fluid::new(&of_fluid))
}
