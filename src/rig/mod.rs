//! The rig file: nodes, components, sensors, inputs, faults, and the cycle that `simulate` runs.

mod at_odds;
mod attach;
mod before;
mod beside;
mod calibration;
mod commanded;
mod cycle;
mod effect;
mod extent;
mod fault_set;
mod join;
mod mapping;
mod margin;
mod oil;
mod parse;
mod scaling;
mod sensor;
mod set;
mod source;
mod validate;

use std::path::{Path, PathBuf};

use crate::complaint::{Complaint, Place, did_you_mean, help_with_names};
use crate::context::Context;
use crate::numeric::Real;
use crate::physics::card::Role;
use crate::physics::card::{Card, PortKind};
use crate::physics::component::AnyLaw;
use crate::physics::drop::Dropped;
use crate::physics::effect::Effect;
use crate::physics::fluid::Fluid;
use crate::settings::Settings;
use crate::units::Unit;

pub(crate) use beside::Beside;
pub use calibration::Calibration;
pub use cycle::{Cycle, Phase, Profile};
pub use effect::{EffectInstance, InstalledEffect, Location, ParameterSetting, Readings};
pub use fault_set::FaultSet;
pub use mapping::Proposal;
pub use margin::NEVER_KNOWN;
#[cfg(feature = "cli")]
pub(crate) use parse::catalogue;
pub use scaling::Scaling;
pub use sensor::{Hold, Input, Quantity, Sensor, TOLERANCE, Target, Temperature};
pub(crate) use source::document;

/// Whether the lower bound of something only says that it is positive.
pub(crate) fn is_next_to_nothing(low: f64) -> bool {
    low > 0.0 && low < 1e-300
}

/// Physical limits, SI, in words.
pub(crate) fn range(bounds: (f64, f64), unit: &Unit) -> String {
    let shown = |value: f64| crate::units::Quantity { value, unit: unit.clone() };
    match (bounds.0.is_finite(), bounds.1.is_finite()) {
        (true, false) if is_next_to_nothing(bounds.0) => "above 0".to_owned(),
        (true, true) => format!("from {} to {}", shown(bounds.0), shown(bounds.1)),
        (true, false) => format!("{} or more", shown(bounds.0)),
        (false, true) => format!("{} or less", shown(bounds.1)),
        (false, false) => "any value".to_owned(),
    }
}

/// A circuit as its file describes it, checked: every name resolves and every node has an equation.
#[derive(Debug, Clone)]
pub struct Rig {
    /// As the user named it; messages quote it.
    pub path: PathBuf,
    /// The `name` of `[rig]`; empty without.
    pub name: String,
    pub(crate) nodes: Vec<Node>,
    #[doc(hidden)]
    pub components: Vec<Component>,
    #[doc(hidden)]
    pub sensors: Vec<Sensor>,
    #[doc(hidden)]
    pub inputs: Vec<Input>,
    /// Where records tell the temperature of the fluid.
    pub(crate) temperature: Option<Temperature>,
    /// Every parameter there is: the fluid's, dead times of inputs, then each component's in the order of its card, then each sensor's offset
    /// and gain, then those of components that were joined later.
    #[doc(hidden)]
    pub parameters: Vec<Parameter>,
    #[doc(hidden)]
    pub faults: Vec<Fault>,
    /// Physics beyond that of the components, in the order of the file.
    #[doc(hidden)]
    pub effects: Vec<InstalledEffect>,
    /// Effects of the rig file's own, which it may have beside those of the library.
    pub(crate) own_effects: Vec<&'static Effect>,
    /// What effects do to the readings of sensors.
    pub(crate) readings: Vec<Readings>,
    #[doc(hidden)]
    pub cycle: Option<Cycle>,
    /// What healthy records have taught; the values above hold it already.
    #[doc(hidden)]
    pub calibration: Option<Calibration>,
    /// Whether values that the file takes as exact are as uncertain as parts deviate from their data sheets.
    pub(crate) parts_deviate: bool,
    /// Parameters of faults with those that hold what they were before: see [`Rig::with_before`].
    #[doc(hidden)]
    pub before: Vec<(usize, usize)>,
    /// SHA-256 of its text, in hexadecimal digits.
    #[cfg(feature = "cli")]
    pub(crate) own_digest: String,
    /// Files beside it that it names, in the order in which they were read.
    pub(crate) beside: Vec<Beside>,
    /// Lines of the file whose values still bear the [mark](PLACEHOLDER) of a draft.
    pub(crate) unfilled: Vec<usize>,
    /// What computations on it run in; a clone of the rig runs in the same.
    pub(crate) context: Context,
}

/// Behind a value of a draft that only the data sheet knows; a user takes it away with the value.
pub const PLACEHOLDER: &str = "# DATA SHEET";

/// The lines of a rig file whose values bear the mark of a draft. A comment is lost to TOML, so the text is asked.
fn unfilled(text: &str) -> Vec<usize> {
    let marked =
        |line: &str| line.split_once(PLACEHOLDER).is_some_and(|(value, _)| value.contains('=') && !value.contains('#'));
    text.lines().zip(1..).filter(|(line, _)| marked(line)).map(|(_, number)| number).collect()
}

/// What a node is, by the ports that meet there.
#[derive(Debug, Clone, PartialEq)]
pub enum NodeKind {
    /// Hydraulic, its pressure a state.
    Volume { initial: InitialPressure },
    /// Hydraulic, its pressure kept by this parameter (gauge).
    Held { parameter: usize },
    /// A body: position (m) and velocity (m/s) are states. Without a position it begins where its sensor shows it.
    Body { position: Option<f64>, velocity: f64 },
}

/// The pressure of a node before the record begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum InitialPressure {
    /// Gauge, Pa.
    Given(f64),
    /// What this other node starts with.
    Like(usize),
    /// The parameter of this index: gauge, uncertain.
    Uncertain(usize),
    /// What balances the forces on the body that this node's pressure acts on.
    Balance,
    /// What the sensor at this node shows first.
    Record,
}

#[derive(Debug, Clone)]
pub struct Node {
    pub name: String,
    pub kind: NodeKind,
    pub place: Place,
}

#[derive(Debug, Clone)]
pub struct Component {
    pub name: String,
    pub card: &'static Card,
    /// Node of each port, in the order of the card.
    pub ports: Vec<usize>,
    /// Input of each of the card's inputs.
    pub inputs: Vec<usize>,
    /// Index of its first parameter.
    pub first_parameter: usize,
    /// Start of each state, SI; `None` starts where the state would rest.
    pub initial: Vec<Option<f64>>,
    /// Whether the start of each state is that of its kind, which a sensor of the state knows better.
    pub usual_start: Vec<bool>,
    /// Whether it is a margin: see [`Rig::give_margin`].
    pub margin: bool,
    /// What is lost ahead of it.
    pub drop: Option<Drop>,
    pub place: Place,
}

/// Pressure that an effect takes away ahead of a component.
#[derive(Debug, Clone, Copy)]
pub struct Drop {
    /// The card has the formula; see [`Dropped`].
    pub card: &'static Card,
    /// Index of its first parameter.
    pub first_parameter: usize,
}

impl Component {
    /// Indices of its parameters among the rig's, in the order of its card; behind them those of what is lost ahead of it.
    pub fn parameters(&self) -> impl Iterator<Item = usize> + Clone + use<> {
        let lost =
            self.drop.map_or(0..0, |drop| drop.first_parameter..drop.first_parameter + drop.card.parameters.len());
        (self.first_parameter..self.first_parameter + self.card.parameters.len()).chain(lost)
    }

    /// Whether it has a port that meets a body.
    pub fn moves_a_body(&self) -> bool {
        self.card.ports.iter().any(|port| port.kind == PortKind::Mechanical)
    }

    /// Whether a parameter of the rig is one of them.
    pub fn owns(&self, parameter: usize) -> bool {
        self.parameters().any(|own| own == parameter)
    }

    /// Its law, from the rig's parameters by index, SI; `None` of a card that has none.
    pub fn law<T: Real>(&self, parameter: impl Fn(usize) -> T, fluid: &Fluid<T>) -> Option<AnyLaw<T>> {
        let given: Vec<T> = self.parameters().map(parameter).collect();
        let (own, lost) = given.split_at(self.card.parameters.len());
        let law = AnyLaw::new(self.card, own, fluid)?;
        match self.drop {
            None => Some(law),
            Some(drop) => Some(AnyLaw::Dropped(Box::new(Dropped::new(law, drop.card, lost)?))),
        }
    }
}

/// One number of the rig, with what is known about it.
#[derive(Debug, Clone)]
pub struct Parameter {
    /// `component.parameter`.
    pub id: String,
    /// As the rig file writes it.
    pub unit: Unit,
    /// SI.
    pub value: f64,
    /// Physical limits, SI.
    pub bounds: (f64, f64),
    /// One standard deviation, SI; 0 for a value taken as exact.
    pub sigma: f64,
    /// Whether it may be another in each switching; see [`crate::physics::card::Parameter::per_event`].
    pub per_event: bool,
    /// What it is to the rest of the program.
    pub role: Role,
    /// What calibration on healthy records starts from: one standard deviation between data sheet and part, SI: of parts of
    /// the kind, or as the file states if that is more; 0 for what it leaves alone.
    pub spread: f64,
    pub meaning: String,
    pub place: Place,
}

impl Parameter {
    /// Whether it is uncertain, and the same throughout a record.
    pub(crate) fn is_uncertain(&self) -> bool {
        self.sigma > 0.0 && !self.per_event
    }

    /// Whether it may be another in each switching.
    pub(crate) fn varies(&self) -> bool {
        self.sigma > 0.0 && self.per_event
    }
}

/// A fault: a parameter that may have left its healthy value.
#[derive(Debug, Clone)]
pub struct Fault {
    pub parameter: usize,
    /// SI.
    pub healthy: f64,
    /// Range searched, SI.
    pub bounds: (f64, f64),
    /// Value from which the part no longer serves, SI; the history of the rig forecasts when it will be passed.
    pub limit: Option<f64>,
    pub place: Place,
}

/// A part that follows an input through a lag of first order, such as a spool its command: indices among the parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Follower {
    /// Index among the inputs.
    pub input: usize,
    pub lag: usize,
    /// [`Role::InertiaTime`]; `None` where the card does not know it.
    pub inertia_time: Option<usize>,
    /// [`Role::DeadTime`]; `None` where the card does not know it.
    pub dead_time: Option<usize>,
}

impl Rig {
    /// Reads and checks a rig file.
    ///
    /// # Errors
    /// One complaint about the first thing that is wrong, with its line.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, Complaint> {
        let path = path.as_ref();
        let text = crate::files::read_text(path)?;
        Self::parse(path, text)
    }

    /// The same from a text; `path` is what messages call it.
    ///
    /// # Errors
    /// As [`Rig::read`].
    pub fn parse(path: impl Into<PathBuf>, text: String) -> Result<Self, Complaint> {
        let unfilled = unfilled(&text);
        #[cfg(feature = "cli")]
        let own_digest = crate::files::digest(text.as_bytes());
        let rig = Self {
            unfilled,
            #[cfg(feature = "cli")]
            own_digest,
            ..parse::parse(source::Source::new(path, text))?
        };
        validate::validate(&rig)?;
        Ok(rig)
    }

    /// The same rig, whose computations run in `context`.
    pub fn with_context(self, context: &Context) -> Self {
        Self { context: context.clone(), ..self }
    }

    /// What computations on this rig run in.
    pub fn context(&self) -> &Context {
        &self.context
    }

    /// The thresholds that its computations go by.
    pub(crate) fn settings(&self) -> &Settings {
        self.context.settings()
    }

    /// Index of the parameter with this id.
    #[doc(hidden)]
    pub fn parameter(&self, id: &str) -> Option<usize> {
        self.parameters.iter().position(|parameter| parameter.id == id)
    }

    /// Help for an id that is no parameter: the near miss; else those of the component that it names; else whose there are.
    pub(crate) fn help_with_parameters(&self, id: &str) -> String {
        let ids = || self.parameters.iter().map(|parameter| parameter.id.as_str());
        // `p_A.offset` is meant to be `sensor.p_A.offset`.
        let in_full = || ids().find(|full| full.strip_suffix(id).is_some_and(|front| front.ends_with('.')));
        if let Some(near) = did_you_mean(id, ids()).or_else(in_full) {
            return format!("did you mean `{near}`?");
        }
        let owner = |id: &'_ str| id.rsplit_once('.').map_or("", |(owner, _)| owner).to_owned();
        let own: Vec<&str> = ids().filter(|other| owner(other) == owner(id)).collect();
        if !own.is_empty() {
            return help_with_names(id, &format!("parameters of `{}`", owner(id)), own);
        }
        let mut owners: Vec<String> = ids().map(owner).collect();
        owners.dedup();
        format!("write OWNER.PARAMETER; {}", help_with_names(&owner(id), "owners", owners.iter().map(String::as_str)))
    }

    /// Whether the parameter with this index is one of the faults.
    #[doc(hidden)]
    pub fn is_fault(&self, parameter: usize) -> bool {
        self.faults.iter().any(|fault| fault.parameter == parameter)
    }

    /// Whether a parameter is of one record, and of no other: what a node starts with, or what its component has as such.
    pub(crate) fn is_of_record(&self, parameter: usize) -> bool {
        let uncertain = NodeKind::Volume { initial: InitialPressure::Uncertain(parameter) };
        self.parameters[parameter].role.is_of_record() || self.nodes.iter().any(|node| node.kind == uncertain)
    }

    /// The name of the fault with this index among the rig's: that of its parameter.
    pub(crate) fn fault_id(&self, fault: usize) -> &str {
        &self.parameters[self.faults[fault].parameter].id
    }

    /// Whether a parameter is the offset or the gain of a sensor.
    pub(crate) fn is_of_sensor(&self, parameter: usize) -> bool {
        self.sensors.iter().any(|sensor| sensor.owns(parameter))
    }

    /// Whether a fit to a record may choose a parameter: a fault, or what is uncertain.
    pub(crate) fn is_fitted(&self, parameter: usize) -> bool {
        self.parameters[parameter].is_uncertain() || self.is_fault(parameter)
    }

    /// Whether a parameter is one of an effect.
    pub(crate) fn is_of_effect(&self, parameter: usize) -> bool {
        self.effects.iter().any(|effect| effect.parameters.contains(&parameter))
    }

    /// Index of the node with this name.
    pub(crate) fn node(&self, name: &str) -> Option<usize> {
        self.nodes.iter().position(|node| node.name == name)
    }

    /// The unit in which the rig file states a sensor's noise, and in which its column is written.
    #[doc(hidden)]
    pub fn sensor_unit(&self, sensor: &Sensor) -> Unit {
        self.parameters.get(sensor.first_parameter).map_or_else(Unit::dimensionless, |offset| offset.unit.clone())
    }

    /// Parts that follow an input through a lag of first order, with what else their cards know of how they follow.
    pub(crate) fn followers(&self) -> impl Iterator<Item = Follower> + '_ {
        self.components.iter().flat_map(|component| {
            let inputs = component.inputs.iter().zip(component.card.inputs);
            inputs.filter_map(|(&input, card)| {
                let own = component.card.parameters;
                let index = |found: Option<usize>| found.map(|own| component.first_parameter + own);
                let role = |role: Role| index(own.iter().position(|parameter| parameter.role == role));
                Some(Follower {
                    input,
                    lag: index(own.iter().position(|parameter| Some(parameter.name) == card.lag))?,
                    inertia_time: role(Role::InertiaTime),
                    dead_time: role(Role::DeadTime),
                })
            })
        })
    }

    /// Whether a parameter is the lag of a part that no [`Follower`] stands for: of a relief valve, the regulator of a pump, or a valve of
    /// formulas. It may be another in each switching, around a mean that is the part's own.
    pub(crate) fn is_own_lag(&self, parameter: usize) -> bool {
        let known = &self.parameters[parameter];
        let lags = known.role == Role::Lag && known.varies() && !self.is_fault(parameter);
        lags && self.followers().all(|follower| follower.lag != parameter)
    }

    /// Inputs whose dead time is fitted like any other value, by index, with its parameter: those that run straight from row to row.
    pub(crate) fn fitted_dead_times(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let own = self.inputs.iter().enumerate().filter_map(|(input, own)| Some((input, own.dead_time?)));
        own.filter(|&(_, own)| !self.parameters[own].per_event)
    }

    /// Whether nothing else has the input of a follower: reshaped for one part, it drives no other.
    pub(crate) fn is_alone(&self, follower: &Follower) -> bool {
        let inputs = self.components.iter().flat_map(|component| &component.inputs);
        inputs.filter(|&&input| input == follower.input).count() == 1
    }

    /// The unit in which a record holds a sensor's column: of a scaled one, that of the quantity behind it.
    pub(crate) fn column_unit(&self, sensor: &Sensor) -> Unit {
        sensor.scale.as_ref().map_or_else(|| self.sensor_unit(sensor), |scale| scale.unit.clone())
    }

    /// The values of all parameters as the file gives them, SI.
    #[doc(hidden)]
    pub fn nominal(&self) -> Vec<f64> {
        self.parameters.iter().map(|parameter| parameter.value).collect()
    }

    /// Whether the viscosity of the fluid is another as it warms up, or may be.
    pub(crate) fn viscosity_varies(&self) -> bool {
        let of = |id: &str| self.parameter(id).map(|index| &self.parameters[index]);
        let ids = ["fluid.temperature_coefficient", "fluid.viscosity_drift"];
        ids.into_iter().filter_map(of).any(|parameter| parameter.value != 0.0 || parameter.sigma > 0.0)
    }

    /// The same with every fault at its healthy value.
    pub(crate) fn healthy(&self) -> Vec<f64> {
        let mut values = self.nominal();
        for fault in &self.faults {
            values[fault.parameter] = fault.healthy;
        }
        values
    }
}
