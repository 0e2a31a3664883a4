//! Rigs as they come from a shop floor: near the data sheet, and with small physics that the model leaves out.

use super::random::Stream;
use crate::complaint::Complaint;
use crate::physics::card::Card;
use crate::physics::card::Role;
use crate::physics::component::facts;
use crate::physics::component::facts::Symbol;
use crate::physics::component::{coulomb_friction, line_volume, restrictor};
use crate::rig::{NodeKind, Parameter, Rig};

/// Most that a parameter strays from its data sheet, relative, one standard deviation.
const STRAY: f64 = 0.03;
/// The same where calibration expects a data sheet to be off by [`LOOSE_FROM`] or more, as of friction and bulk modulus.
const STRAY_LOOSE: f64 = 0.1;
const LOOSE_FROM: f64 = 0.2;
/// Share of their standard uncertainty by which lags and progressions stray.
const STRAY_ANEW: f64 = 0.5;
/// Logarithm by which transition pressures stray: another smoothing.
const SMOOTHING: f64 = 1.0;
/// Offsets of sensors, in standard deviations of their noise; gains of sensors and load cells.
const OFFSET: f64 = 0.5;
const GAIN: f64 = 0.002;
/// Logarithms by which lag and noise of sensors stray.
const SENSOR_LAG: f64 = 0.2;
const SENSOR_NOISE: f64 = 0.1;
/// Coulomb friction of a body, of the largest load.
const FRICTION: f64 = 0.002;
/// External leak of a volume: 0.002 L/min at 100 bar, m³/s and Pa.
const LEAK: (f64, f64) = (0.002e-3 / 60.0, 100e5);
/// Volume that no data sheet counts, of a typical one.
const COMPLIANCE: f64 = 0.02;
/// Logarithm by which these small terms differ from place to place.
const SPREAD: f64 = 0.5;
/// A strayed lag, volume or the like keeps at least this share of its value.
const LEAST: f64 = 0.2;

/// A disturbed rig.
#[derive(Debug, Clone)]
pub struct Disturbed {
    /// With the parameters that it has while healthy, and the components that the model leaves out.
    pub rig: Rig,
    /// Healthy value of each fault, SI.
    pub healthy: Vec<f64>,
}

/// Standard deviation by which a parameter of a part strays at size 1, SI.
fn stray(parameter: &Parameter) -> f64 {
    if parameter.per_event {
        return STRAY_ANEW * parameter.sigma;
    }
    let value = parameter.value;
    let known = if parameter.spread > 0.0 { parameter.spread } else { parameter.sigma };
    let most = if known >= LOOSE_FROM * value.abs() { STRAY_LOOSE } else { STRAY };
    if value == 0.0 { known } else { known.min(most * value.abs()) }
}

/// The same rig file, its author knowing how far rigs stray at size 1.
#[cfg(feature = "internals")]
pub fn well_known(rig: &Rig) -> Rig {
    let mut known = rig.clone();
    for parameter in &mut known.parameters {
        let most = stray(parameter);
        (parameter.spread, parameter.sigma) = (parameter.spread.min(most), parameter.sigma.min(most));
    }
    for sensor in &rig.sensors {
        let (offset, gain) = (sensor.first_parameter, sensor.first_parameter + 1);
        known.parameters[offset].spread = OFFSET * sensor.noise;
        known.parameters[gain].spread = GAIN * rig.parameters[gain].value;
    }
    known
}

/// Draws a rig near `rig`. All deviations are proportional to `size`; at 0 the rig comes back as it is.
///
/// # Errors
/// None with a rig that was read; those of [`Rig::join`].
pub fn disturb(rig: &Rig, size: f64, random: &mut Stream) -> Result<Disturbed, Complaint> {
    let mut disturbed = rig.clone();
    let is_of_a_part = |own: &&mut Parameter| !matches!(own.role, Role::Instrument | Role::GasLaw | Role::OfRecord);
    for parameter in disturbed.parameters.iter_mut().filter(is_of_a_part) {
        let value = parameter.value;
        let by = random.normal() * size;
        if parameter.role == Role::Smoothing {
            parameter.value = value * (SMOOTHING * by).exp();
        } else {
            parameter.value += stray(parameter) * by;
        }
        let (low, high) = parameter.bounds;
        let least = if value > 0.0 { LEAST * value } else { low };
        parameter.value = parameter.value.clamp(low.max(least), high);
    }
    for sensor in &mut disturbed.sensors {
        let (offset, gain) = (sensor.first_parameter, sensor.first_parameter + 1);
        disturbed.parameters[offset].value =
            rig.parameters[offset].value + OFFSET * sensor.noise * random.normal() * size;
        disturbed.parameters[gain].value = rig.parameters[gain].value * (1.0 + GAIN * random.normal() * size);
        sensor.lag *= (SENSOR_LAG * random.normal() * size).exp();
        sensor.noise *= (SENSOR_NOISE * random.normal() * size).exp();
        sensor.stated_noise = sensor.noise;
    }
    let healthy = rig.faults.iter().map(|fault| {
        let (file, own) = (&rig.parameters[fault.parameter], &disturbed.parameters[fault.parameter]);
        (fault.healthy + own.value - file.value).clamp(fault.bounds.0, fault.bounds.1)
    });
    let healthy: Vec<f64> = healthy.collect();
    for (fault, &value) in rig.faults.iter().zip(&healthy) {
        disturbed.parameters[fault.parameter].value = value;
    }
    for (input, measured) in rig.inputs.iter().enumerate() {
        let stray = random.normal();
        if measured.noise > 0.0 {
            instruments(rig, input).for_each(|gain| disturbed.parameters[gain].value *= 1.0 + GAIN * stray * size);
        }
    }
    leave_out(rig, size, random, &mut disturbed)?;
    Ok(Disturbed { rig: disturbed, healthy })
}

/// Draws what is another in each record, SI, in proportion to `size`.
pub fn of_record(rig: &Rig, parameters: &mut [f64], size: f64, random: &mut Stream) {
    let all = parameters.iter_mut().zip(&rig.parameters);
    for (value, parameter) in all.filter(|(_, parameter)| parameter.role.is_of_record()) {
        *value = (*value + parameter.sigma * random.normal() * size).clamp(parameter.bounds.0, parameter.bounds.1);
    }
}

/// Indices of the parameters that tell what the instrument of an input shows.
fn instruments(rig: &Rig, input: usize) -> impl Iterator<Item = usize> {
    let driven = rig.components.iter().filter(move |component| component.inputs.contains(&input));
    let own = driven.flat_map(|component| (component.first_parameter..).take(component.card.parameters.len()));
    own.filter(|&index| rig.parameters[index].role == Role::Instrument)
}

/// Joins what the model that diagnoses leaves out.
fn leave_out(rig: &Rig, size: f64, random: &mut Stream, disturbed: &mut Rig) -> Result<(), Complaint> {
    if size == 0.0 {
        return Ok(());
    }
    let held = rig.nodes.iter().position(|node| matches!(node.kind, NodeKind::Held { .. }));
    let volume = typical_volume(rig);
    for (index, node) in rig.nodes.iter().enumerate() {
        // Drawn in any case, so that one term more leaves the others as they are.
        let [first, second] = [random.normal(), random.normal()].map(|normal| size * (SPREAD * normal).exp());
        let mut join = |what: &str, card: &'static Card, ports: &[usize], values: &[(&str, f64)]| {
            disturbed.join(&format!("unmodelled_{what}_{}", node.name), card, ports, values)
        };
        match node.kind {
            NodeKind::Body { .. } => {
                let force = FRICTION * largest_load(rig, index) * first;
                if force > 0.0 {
                    join("friction", &coulomb_friction::CARD, &[index], &[("force", force)])?;
                }
            }
            NodeKind::Volume { .. } => {
                if let Some(held) = held {
                    let values = [("rated_flow", LEAK.0 * first), ("rated_drop", LEAK.1)];
                    join("leak", &restrictor::CARD, &[index, held], &values)?;
                }
                if let Some(volume) = volume {
                    join("volume", &line_volume::CARD, &[index], &[("volume", COMPLIANCE * volume * second)])?;
                }
            }
            NodeKind::Held { .. } => {}
        }
    }
    Ok(())
}

/// Median of the volumes that the rig file states, m³.
fn typical_volume(rig: &Rig) -> Option<f64> {
    let stated = rig.parameters.iter().filter(|own| own.role == Role::Volume && own.value > 0.0);
    let mut volumes: Vec<f64> = stated.map(|own| own.value).collect();
    volumes.sort_by(f64::total_cmp);
    volumes.get(volumes.len() / 2).copied()
}

/// Largest force in N that the rig's cycle puts on a body.
fn largest_load(rig: &Rig, body: usize) -> f64 {
    let on_body = |component: &&crate::rig::Component| {
        facts(component.card).symbol == Symbol::Force && component.ports.contains(&body)
    };
    let inputs = rig.components.iter().filter(on_body).flat_map(|component| &component.inputs);
    let phases = || rig.cycle.iter().flat_map(|cycle| &cycle.phases);
    let load = |&input: &usize| {
        phases().map(|phase| phase.inputs[input].from.abs().max(phase.inputs[input].to.abs())).fold(0.0, f64::max)
    };
    inputs.map(load).fold(0.0, f64::max)
}
