//! Flow laws shared by several components.

use crate::numeric::Real;
use std::f64::consts::PI;

/// Square root of a pressure drop with its sign, linear near zero: `dp / (dp² + dt²)^(1/4)`.
///
/// `drop` and `transition` in Pa, result in Pa^½. For |dp| >> dt this is the turbulent orifice law
/// (equations (5), (6), (13) of the paper) to `dt²/(4 dp²)`; below `transition` the flow is laminar, with slope
/// `1/sqrt(dt)`. `transition` must be positive. Worked: `root(1e5, 1e4) = 315.443` (`sqrt(1e5) = 316.228`).
#[inline]
pub fn root<T: Real>(drop: T, transition: T) -> T {
    drop / (drop * drop + transition * transition).sqrt().sqrt()
}

/// Conductance `Cd A sqrt(2/rho)` of a sharp-edged orifice, m³/s per Pa^½.
///
/// Equation (6). `diameter` in m, `density` in kg/m³. Worked: 2 mm, Cd 0.7, 870 kg/m³ and 0.74 MPa pass
/// `conductance * sqrt(dp) = 9.070e-5 m³/s` = 5.44 L/min, the paper's pump flow at its saturation at 2 mm.
#[inline]
pub fn orifice_conductance<T: Real>(discharge: T, diameter: T, density: T) -> T {
    discharge * diameter * diameter * (PI / 4.0) * (T::constant(2.0) / density).sqrt()
}

/// Laminar conductance `pi D h³ (1 + 1.5 e²) / (12 mu L)` of an annular gap, m³/s per Pa.
///
/// `diameter`, `gap` (half the diametral clearance) and `length` in m, `eccentricity` relative (0 concentric, 1
/// touching), `viscosity` in Pa·s. Merritt, Hydraulic Control Systems (1967), eq. 2-53. Valid for h << D and
/// laminar flow (Re below about 1000). Worked: D 40 mm, h 0.125 mm, L 37.4 mm, mu 45.5 mPa·s, concentric:
/// 1.2019e-11 m³/s/Pa, so 36.8 bar leak 2.65 L/min.
#[inline]
pub fn annular_gap_conductance<T: Real>(diameter: T, gap: T, length: T, viscosity: T, eccentricity: T) -> T {
    diameter * PI * gap * gap * gap * (eccentricity * eccentricity * 1.5 + 1.0) / (viscosity * length * 12.0)
}
