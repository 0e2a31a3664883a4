//! Effects: physics that a model may have left out, one file each. A new one is its file and its line in `effects!`.
//!
//! At its neutral value an effect contributes exactly nothing, so the model without it is the model with it at that value.
//! An effect comes in one of a few forms ([`Form`]): a further component that is joined to the circuit, a parameter that a
//! law has already, something that a sensor does to what it reads, or a loss of pressure ahead of a component.

mod edge_leakage;
pub(crate) mod spline;

use super::card::Card;
use super::component::facts::Symbol;
use super::fluid::Fluid;
use super::formula;
use super::ports::{Law, PortFlows, PortVariables};
use crate::numeric::Real;

/// Where an effect may sit.
#[derive(Debug, Clone, Copy)]
pub enum At {
    /// This property of the fluid, and so the whole rig.
    Fluid(&'static str),
    /// This property of the fluid, where records tell its temperature.
    Warmth(&'static str),
    /// A node with a volume; written `@node`.
    Node,
    /// A node with a volume where a cylinder or motor stands; written `@node`.
    Actuator,
    /// A node into which directional valves drain through their port `T`, held or with a volume; written `@node`.
    Return,
    /// A component of this kind; written `@name` where `named`, else only where there are several.
    Component { card: &'static Card, named: bool },
    /// A component of whatever kind that has this symbol, and the ports and parameters that the effect needs; written in the same way.
    Like { symbol: Symbol, named: bool },
    /// A sensor; written `@name`.
    Sensor,
    /// The node of this name, whatever stands there.
    Named(&'static str),
    /// The sensor of this name; written `@name`.
    NamedSensor(&'static str),
    /// The component of this name; written `@name`.
    NamedComponent(&'static str),
}

/// Which node a port of a joined component meets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Joint {
    /// The node where the effect sits.
    Here,
    /// The node of the rig's tank.
    Tank,
    /// The node at this hydraulic port, counted from 0, of the component where the effect sits.
    Hydraulic(usize),
    /// The body that the component moves where the effect sits, from inside the component: a load cell at its rod reads what rubs there.
    Body,
    /// The same body from outside: a load, which such a cell does not read.
    Load,
    /// The node into which what stands at the first port drains; the tank where there is none.
    Next,
    /// The node of this name.
    Named(&'static str),
}

/// How an effect changes the model.
#[derive(Debug, Clone, Copy)]
pub enum Form {
    /// One more component.
    Shunt {
        card: &'static Card,
        joints: &'static [Joint],
        /// Parameters that are those of the component where the effect sits: own name, its name.
        shared: &'static [(&'static str, &'static str)],
    },
    /// One more component between the node and what stands there: actuators, or at [`At::Return`] the valves that drain into it.
    Series { card: &'static Card },
    /// Parameters that fluid, component or sensor have already.
    ParameterChange,
    /// Pressure that is lost ahead of a component, by the formula of the card over its flow.
    PressureLoss { card: &'static Card },
    /// What the sensor does to its readings; the card holds its parameters.
    Reading { card: &'static Card },
}

impl Form {
    /// The card that holds the parameters of the effect; `None` where something else has them already.
    pub fn card(self) -> Option<&'static Card> {
        match self {
            Self::Shunt { card, .. } | Self::Series { card } | Self::Reading { card } | Self::PressureLoss { card } => {
                Some(card)
            }
            Self::ParameterChange => None,
        }
    }
}

/// A parameter of an effect that is estimated.
#[derive(Debug, Clone, Copy)]
pub struct FreeParameter {
    pub name: &'static str,
    /// What it is when the effect does nothing, in the unit of its card; `None` where it is what the rig has.
    pub neutral: Option<f64>,
    /// What is tried first.
    pub first: InitialGuess,
    /// Values with physical sense, in the unit of its card.
    pub plausible: (f64, f64),
}

/// Where the search for a parameter of an effect begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum InitialGuess {
    /// This value, in the unit of the card.
    Value(f64),
    /// This many times the noise of the sensor where the effect sits.
    Noise(f64),
    /// This value, in the unit of the card; with a record several shares of the highest pressure at the node where the effect
    /// sits.
    Onset(f64),
    /// This share of the way from the least to the largest reading of the sensor, or level at the node, where it sits.
    Range(f64),
}

/// The card of an effect.
#[derive(Debug, Clone, Copy)]
pub struct Effect {
    /// Name in the rig file, before the `@`.
    pub name: &'static str,
    pub meaning: &'static str,
    /// The law as formulas.
    pub law: &'static str,
    pub source: &'static str,
    /// Where the law holds and what it leaves out.
    pub validity: &'static str,
    /// Whether it is a curve without a formula, to be added only where no law of the library explains the record.
    pub empirical: bool,
    /// Whether no circuit is quite without it: calibrated rigs hold it as a margin.
    pub everywhere: bool,
    pub at: At,
    pub form: Form,
    /// The size first.
    pub parameters: &'static [FreeParameter],
}

impl At {
    /// The property of the fluid that it is about.
    pub fn property_of_fluid(&self) -> Option<&'static str> {
        match self {
            At::Fluid(property) | At::Warmth(property) => Some(property),
            _ => None,
        }
    }
}

impl Effect {
    /// Whether it begins at a level that has to be found.
    pub fn has_level(&self) -> bool {
        self.parameters.iter().any(|free| matches!(free.first, InitialGuess::Range(_)))
    }

    /// What it is, as part of a sentence: the first clause of its meaning. Empty where a rig file says nothing of it.
    pub fn in_words(&self) -> String {
        let clause = self.meaning.split([':', ';', '.']).next().unwrap_or_default().trim();
        let mut letters = clause.chars();
        letters.next().map_or_else(String::new, |first| first.to_lowercase().chain(letters).collect())
    }
}

/// What a sensor does to its readings.
pub trait Reading {
    /// Changes the readings at `times` (s) in place, by the parameters in the order of the card, SI.
    fn apply<T: Real>(parameters: &[T], times: &[f64], readings: &mut [T]);
}

macro_rules! effects {
    (
        joined { $($module:ident :: $name:ident),+ $(,)? }
        readings { $($reading:ident :: $does:ident),+ $(,)? }
        bent { $($plain:ident),+ $(,)? }
    ) => {
        $(mod $module;)+
        $(mod $reading;)+
        $(mod $plain;)+

        /// Every effect that a model may be given.
        pub const EFFECTS: &[&Effect] = &[$(&$module::EFFECT,)+ $(&$plain::EFFECT,)+ $(&$reading::EFFECT),+];

        /// The cards of the laws that effects join to a rig.
        #[cfg(feature = "internals")]
        pub const LAWS: &[&Card] = &[$(&$module::CARD),+];

        $(const _: () = assert!(!$module::CARD.worked.is_empty(), concat!("the law of an effect has a number worked by hand: ", stringify!($module)));)+

        /// The law of any joined effect, chosen by kind.
        #[derive(Debug, Clone)]
        pub enum EffectLaw<T> { $($name($module::$name<T>)),+ }

        impl<T: Real> EffectLaw<T> {
            /// The law of `kind`, or `None` for a kind that is not in [`LAWS`].
            pub fn new(kind: &str, parameters: &[T], fluid: &Fluid<T>) -> Option<Self> {
                $(if kind == $module::CARD.kind {
                    return Some(EffectLaw::$name($module::$name::new(parameters, fluid)));
                })+
                None
            }

            // Most rigs have none: what is rare need not be laid out in every loop.
            #[inline(never)]
            pub fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
                match self { $(EffectLaw::$name(law) => law.evaluate(seen, answers)),+ }
            }
        }

        /// Does to the readings of a sensor at `times` what the effect of this card does; `parameters` in its order, SI. The run
        /// began at `begun`, s.
        pub fn read<T: Real>(card: &'static Card, parameters: &[T], begun: f64, times: &[f64], readings: &mut [T]) {
            if let Some(expression) = card.formula {
                formula::read(expression, parameters, begun, times, readings);
            }
            let kind = card.kind;
            $(if kind == $reading::CARD.kind {
                $reading::$does::apply(parameters, times, readings);
            })+
        }
    };
}

effects! {
    joined {
        empirical_drag::EmpiricalDrag,
        empirical_friction::EmpiricalFriction,
        empirical_leakage::EmpiricalLeakage,
        empirical_load::EmpiricalLoad,
        empirical_piston_leakage::EmpiricalPistonLeakage,
        end_cushioning::EndCushioning,
        external_leakage::ExternalLeakage,
        external_orifice_leakage::ExternalOrificeLeakage,
        hose_compliance::HoseCompliance,
        line_resistance::LineResistance,
        load_force::LoadForce,
        load_mass::LoadMass,
        load_stiffness::LoadStiffness,
        orifice_leakage::OrificeLeakage,
        position_dependent_clearance::PositionDependentClearance,
        pressure_friction::PressureFriction,
        progressive_load::ProgressiveLoad,
        pump_slip::PumpSlip,
        relief_weeping::ReliefWeeping,
        reservoir_overflow::ReservoirOverflow,
        return_line::ReturnLine,
        seal_friction::SealFriction,
    }
    readings {
        sensor_delay::SensorDelay,
        sensor_lag::SensorLag,
        sensor_saturation::SensorSaturation,
    }
    bent {
        compensator_lag,
        dead_voltage,
        edge_leakage_to_a,
        edge_leakage_to_b,
        entrained_air,
        motor_orifice_leakage,
        pump_droop,
        pump_leakage,
        relief_knee,
        sensor_gain,
        sensor_offset,
        spool_dead_band,
        spool_flow_force,
        spool_hysteresis,
        spool_lag,
        spool_leakage,
        viscosity_drift,
        viscosity_temperature,
        viscous_friction,
    }
}

/// The effect of this name.
pub fn effect(name: &str) -> Option<&'static Effect> {
    EFFECTS.iter().copied().find(|effect| effect.name == name)
}
