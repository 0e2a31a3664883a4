//! What the plants may hide: the effect's name in the library, a draw of its size, and how the plant has it.

use borescope::Rig;
use borescope::internals::campaign::random::Stream;

use super::{A, B, Line, PUMP_LINE, Plant};

/// L/min per bar in SI.
const PER_BAR: f64 = 1e-3 / 60.0 / 1e5;

/// The rig file that goes with the plant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sheet {
    /// The telescopic rig as it is.
    Plain,
    /// With a throttle of 1.6 mm, so that the reducing valve regulates and what is left of the pump flow goes over the relief
    /// valve.
    Throttled,
    /// As it is, under loads that bring the pump line near the set pressure.
    Heavy,
    /// Both.
    ThrottledHeavy,
    /// With a worn seal, so that the viscosity matters.
    Leaking,
    /// Without sensors' faults, which would be the same as what is hidden.
    TrueSensors,
}

impl Sheet {
    fn is_throttled(self) -> bool {
        matches!(self, Self::Throttled | Self::ThrottledHeavy)
    }

    /// Loads, in usual ones.
    pub fn loads(self) -> f64 {
        if matches!(self, Self::Heavy | Self::ThrottledHeavy) { 1.9 } else { 1.0 }
    }
}

const WEEPING: &str = "relief-weeping";

/// From 45 to 85 bar on, another pressure for every size.
fn weeps_from(size: f64) -> f64 {
    45.0 + 40.0 * (1e4 * size).fract()
}

/// Where a hidden effect of this size begins, in the unit of the card, if anywhere.
pub fn begins(id: &str, size: f64) -> Option<f64> {
    (id == WEEPING).then(|| weeps_from(size))
}

/// An effect that the telescopic plant can hide.
pub struct Hidden {
    /// `kind@place` as the library calls it.
    pub id: &'static str,
    /// Others that act alike on every record of this rig, to which the same name may be given.
    pub alike: &'static [&'static str],
    pub sheet: Sheet,
    /// A size in the middle of what a rig may have, in the unit of the card.
    pub typical: f64,
    /// Gives the plant the effect in this size.
    pub put: fn(&mut Plant, f64),
}

/// What is one flow out of the pump line over its pressure, wherever it goes.
const OF_PUMP: &[&str] = &["pump-slip", "pump-droop", "external-leakage@pump_line"];

const fn hidden(id: &'static str, typical: f64, put: fn(&mut Plant, f64)) -> Hidden {
    Hidden { id, alike: &[], sheet: Sheet::Plain, typical, put }
}

const fn throttled(id: &'static str, typical: f64, put: fn(&mut Plant, f64)) -> Hidden {
    Hidden { id, alike: &[], sheet: Sheet::Throttled, typical, put }
}

const fn heavy(id: &'static str, typical: f64, put: fn(&mut Plant, f64)) -> Hidden {
    Hidden { id, alike: &[], sheet: Sheet::Heavy, typical, put }
}

const fn throttled_heavy(id: &'static str, typical: f64, put: fn(&mut Plant, f64)) -> Hidden {
    Hidden { id, alike: &[], sheet: Sheet::ThrottledHeavy, typical, put }
}

const fn leaking(id: &'static str, typical: f64, put: fn(&mut Plant, f64)) -> Hidden {
    Hidden { id, alike: &[], sheet: Sheet::Leaking, typical, put }
}

const fn sensor(id: &'static str, typical: f64, put: fn(&mut Plant, f64)) -> Hidden {
    Hidden { id, alike: &[], sheet: Sheet::TrueSensors, typical, put }
}

const fn of_pump(id: &'static str, typical: f64, put: fn(&mut Plant, f64)) -> Hidden {
    Hidden { id, alike: OF_PUMP, sheet: Sheet::Plain, typical, put }
}

/// One of each kind. A record is drawn by the place of what it hides: a new one comes last.
pub const HIDDEN: &[Hidden] = &[
    hidden("external-leakage@A", 0.006, |plant, size| plant.external_leak[A] = size * PER_BAR),
    hidden("external-orifice-leakage@A", 0.08, |plant, size| plant.external_hole[A] = size * 1e-6),
    hidden("hose-compliance@A", 0.03, |plant, size| plant.hose[A] = size * 1e-11),
    hidden("line-resistance@B", 0.06, |plant, size| {
        // K q² at 5 L/min, as q^1.75, with a laminar part.
        let flow: f64 = 5e-3 / 60.0;
        plant.lines[1] = Some(Line { laminar: 5e8, turbulent: size * 25.0 * 1e5 / flow.powf(1.75) });
    }),
    hidden("return-line@tank", 0.06, |plant, size| plant.return_line = size * 1e5 * 60e3_f64.powi(2)),
    hidden("load-force", 250.0, |plant, size| plant.load_force = size),
    hidden("load-mass", 60.0, |plant, size| plant.load_mass = size),
    hidden("load-stiffness", 5.0, |plant, size| plant.load_stiffness = size * 1e3),
    hidden("orifice-leakage@cylinder", 0.15, |plant, size| plant.hole_in_piston = size * 1e-6),
    hidden("position-dependent-clearance@cylinder", 0.02, |plant, size| plant.worn_end = size * PER_BAR),
    hidden("pressure-friction@cylinder", 6.0, |plant, size| plant.friction_per_pressure = size / 1e5),
    hidden("progressive-load", 0.04, |plant, size| plant.progressive_load = size * 1e6),
    of_pump("pump-slip", 0.004, |plant, size| plant.slip = size * PER_BAR),
    heavy(WEEPING, 0.03, |plant, size| {
        (plant.weeping, plant.weeping_from) = (size * PER_BAR, 1e5 * weeps_from(size));
    }),
    hidden("seal-friction@cylinder", 350.0, |plant, size| (plant.coulomb, plant.breakaway) = (size, 0.6 * size)),
    throttled("compensator-lag", 20.0, |plant, size| plant.compensator_lag = size * 1e-3),
    hidden("end-cushioning@cylinder", 2e5, |plant, size| (plant.cushion, plant.cushion_length) = (size, 25e-3)),
    hidden("entrained-air", 1.0, |plant, size| plant.air = size * 1e-2),
    of_pump("pump-droop", 0.0008, |plant, size| plant.droop = size / 1e5),
    throttled("relief-knee", 8.0, |plant, size| plant.knee = size * 1e5),
    sensor("sensor-gain@q_A", 1.05, |plant, size| plant.readings[5].gain = size),
    sensor("sensor-offset@p_A", 1.5, |plant, size| plant.readings[2].offset = size * 1e5),
    hidden("spool-dead-band", 0.2, |plant, size| plant.dead_band = size),
    throttled_heavy("spool-flow-force", 0.36, |plant, size| plant.flow_force = size),
    hidden("spool-lag", 30.0, |plant, size| plant.spool_lags = [0.8e-3 * size, 0.2e-3 * size]),
    hidden("viscous-friction@cylinder", 4000.0, |plant, size| plant.viscous = size),
    sensor("sensor-delay@x", 12.0, |plant, size| plant.readings[7].delay = size * 1e-3),
    sensor("sensor-lag@p_B", 15.0, |plant, size| plant.readings[3].lag = size * 1e-3),
    sensor("sensor-saturation@p_A", 25.0, |plant, size| plant.readings[2].limit = size * 1e5),
    hidden("external-leakage@B", 0.008, |plant, size| plant.external_leak[B] = size * PER_BAR),
    leaking("viscosity-temperature", 0.03, |plant, size| (plant.thinning, plant.warming) = (size, 8.0)),
    leaking("viscosity-drift", 0.02, |plant, size| {
        // Nothing tells that it warms up, nearly straight.
        (plant.thinning, plant.warming_up, plant.logs_temperature) = (0.04, 40.0, false);
        plant.warming = size * plant.warming_up / plant.thinning;
    }),
    of_pump("external-leakage@pump_line", 0.004, |plant, size| plant.external_leak[PUMP_LINE] = size * PER_BAR),
    hidden("spool-leakage", 0.006, |plant, size| plant.null_leak = size * PER_BAR),
    hidden("edge-leakage-to-a", 0.005, |plant, size| plant.scored_land = size * PER_BAR),
];

/// A size from 0.6 to 1.6 of the typical one; of what multiplies, of its distance to one.
pub fn size(hidden: &Hidden, random: &mut Stream) -> f64 {
    let factor = random.uniform(0.6, 1.6);
    if hidden.id.starts_with("sensor-gain") {
        return 1.0 + factor * (hidden.typical - 1.0);
    }
    factor * hidden.typical
}

/// A plant within the tolerance of its data sheet.
pub fn healthy(kind: Sheet, random: &mut Stream) -> Plant {
    let mut sheet = Plant::default();
    if kind.is_throttled() {
        sheet.throttle = 1.6e-3;
    }
    if kind == Sheet::Leaking {
        sheet.clearance = 0.2e-3;
    }
    let mut near = |value: f64, relative: f64| value * (1.0 + relative * random.normal().clamp(-2.0, 2.0));
    Plant {
        viscosity: near(sheet.viscosity, 0.004),
        bulk_modulus: sheet.bulk_modulus,
        pump_flow: near(sheet.pump_flow, 0.005),
        set_pressure: near(sheet.set_pressure, 0.003),
        discharge: near(sheet.discharge, 0.004),
        reducing_discharge: near(sheet.reducing_discharge, 0.004),
        rated_drop: near(sheet.rated_drop, 0.0016),
        compensator_lag: near(sheet.compensator_lag, 0.1),
        spool_lags: [near(8e-3, 0.1), 0.0],
        ..sheet
    }
}

/// The rig file of a plant.
pub fn rig(sheet: Sheet) -> Rig {
    let path = "fixtures/telescopic/rig.toml";
    let text = std::fs::read_to_string(path).expect("the rig file");
    let text = match sheet {
        Sheet::Plain | Sheet::Heavy => text,
        Sheet::Throttled | Sheet::ThrottledHeavy => text.replace("\"5 mm\"", "\"1.6 mm\""),
        Sheet::Leaking => text
            .replace("clearance = \"0 mm\"", "clearance = \"0.2 mm\"")
            .replace("healthy = \"0 mm\"", "healthy = \"0.2 mm\""),
        Sheet::TrueSensors => {
            text.lines().filter(|line| !line.starts_with("\"sensor.")).map(|line| format!("{line}\n")).collect()
        }
    };
    Rig::parse(path, text).expect("a rig")
}
