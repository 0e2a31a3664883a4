//! What a component tells about itself: its parameters, ports, states and one worked number.

use super::own::Own;
use crate::expression::Expression;

/// One parameter of a component: the data from which the rig file is read and the reference is written.
#[derive(Debug, Clone, Copy)]
pub struct Parameter {
    pub name: &'static str,
    /// Symbol in formulas.
    pub symbol: &'static str,
    /// Unit in which the numbers of this entry are given; a rig file may use any unit of its dimension.
    pub unit: &'static str,
    /// Value where the rig file is silent; `None` where it has to speak.
    pub default: Option<f64>,
    /// Parameter of the same card whose stated value it has instead where the rig file is silent.
    pub default_from: Option<&'static str>,
    /// Physical limits, in `unit`.
    pub bounds: (f64, f64),
    /// Standard uncertainty where the rig file states none, relative, or in `unit` where the value is 0, as its default is; 0 for a
    /// data-sheet value taken as exact.
    pub tolerance: f64,
    /// Whether the value may be another in each switching: it matters only while something moves, and what stands for it
    /// here (a lag of first order, say) is a simplification.
    pub per_event: bool,
    /// What it is to the rest of the program.
    pub role: Role,
    /// Standard deviation between a data sheet and the part at hand, relative, or in `unit` where the value is 0, as its default is; what
    /// calibration on healthy records starts from. 0 for what calibration leaves alone.
    pub spread: f64,
    /// Name of the parameter of the same card that it may not exceed.
    pub within_other: Option<&'static str>,
    /// What catalogues have, in `unit`: a value beyond is asked about.
    pub usual: (f64, f64),
    pub meaning: &'static str,
}

impl Parameter {
    /// What is given of it by its name, or else of the parameter that it is stated as.
    pub fn given<T>(&self, by_name: impl Fn(&str) -> Option<T>) -> Option<T> {
        by_name(self.name).or_else(|| by_name(self.default_from?))
    }

    /// A parameter that the rig file must give and that is never negative.
    pub const fn required(name: &'static str, symbol: &'static str, unit: &'static str, meaning: &'static str) -> Self {
        Self {
            name,
            symbol,
            unit,
            default: None,
            default_from: None,
            bounds: (0.0, f64::INFINITY),
            tolerance: 0.0,
            per_event: false,
            role: Role::Plain,
            spread: 0.0,
            within_other: None,
            usual: (f64::NEG_INFINITY, f64::INFINITY),
            meaning,
        }
    }

    /// The same, never larger than another parameter of the card.
    pub const fn at_most(mut self, other: &'static str) -> Self {
        self.within_other = Some(other);
        self
    }

    /// The same, asked about beyond what catalogues have.
    pub const fn usually(mut self, low: f64, high: f64) -> Self {
        self.usual = (low, high);
        self
    }

    /// The same, with a default value in `unit`.
    pub const fn or(mut self, default: f64) -> Self {
        self.default = Some(default);
        self
    }

    /// The same, by default as another parameter of the card is stated: what that one becomes later, by wear or in a fit, leaves it alone.
    pub const fn or_as(mut self, other: &'static str) -> Self {
        self.default_from = Some(other);
        self.role = Role::Reference;
        self
    }

    /// The same, with what it is to the rest of the program.
    pub const fn is(mut self, role: Role) -> Self {
        self.role = role;
        self
    }

    /// The same, above zero: a law divides by it.
    pub const fn positive(mut self) -> Self {
        self.bounds.0 = f64::MIN_POSITIVE;
        self
    }

    /// The same, with physical limits in `unit`.
    pub const fn within(mut self, low: f64, high: f64) -> Self {
        self.bounds = (low, high);
        self
    }

    /// The same, uncertain by this much (one standard deviation) unless the rig file says otherwise, and anew in each
    /// switching.
    pub const fn uncertain_per_event(mut self, tolerance: f64) -> Self {
        self.tolerance = tolerance;
        self.per_event = true;
        self
    }

    /// The same, open to calibration: data sheets miss it by this fraction (one standard deviation).
    pub const fn calibrated(mut self, spread: f64) -> Self {
        self.spread = spread;
        self
    }

    /// The same, uncertain by this fraction (one standard deviation) unless the rig file says otherwise.
    pub const fn uncertain(mut self, fraction: f64) -> Self {
        self.tolerance = fraction;
        self
    }
}

impl Card {
    /// What a parameter is by default, in `unit`: by itself, or as the other that it is stated as.
    pub fn default_of(&self, own: &Parameter) -> Option<f64> {
        let other = || self.parameters.iter().find(|other| Some(other.name) == own.default_from)?.default;
        own.default.or_else(other)
    }
}

/// What a parameter is to the rest of the program, whatever its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Role {
    /// Nothing else.
    #[default]
    Plain,
    /// A time constant: what it belongs to settles with it after a jump of an input.
    Lag,
    /// `T` of a part with mass that follows its input by `T² s'' + tau s' + s = u`, beside its [`Role::Lag`] `tau`; 0 without mass.
    InertiaTime,
    /// How much later than it is given an input acts on a part that follows it.
    DeadTime,
    /// How an edge of a valve opens while its part that follows an input is between its ends.
    Edge,
    /// A width over which a law is smooth; known to a factor, not to a share.
    Smoothing,
    /// A moving mass.
    Mass,
    /// A volume of enclosed oil.
    Volume,
    /// A gap through which port 0 leaks to port 1.
    Clearance,
    /// The viscosity of the fluid.
    Viscosity,
    /// A force per speed, or a torque, by sheared oil: goes with the viscosity.
    Viscous,
    /// A flow per pressure through a gap or a mesh: goes with one over the viscosity.
    Laminar,
    /// How a gas is compressed, by the heat that it exchanges: no property of a part, so that no two rigs of a kind differ in it.
    GasLaw,
    /// A condition at which another value of the data sheet holds, or the form of a law away from it: nothing wears it, and a healthy
    /// record of a part at that condition says nothing of it. A calibration leaves it as it is.
    Reference,
    /// What is another in each record and is known of none: a load that was not weighed. Nothing wears it; a calibration, and the check of
    /// a model on another record, fit it to each record by itself.
    OfRecord,
    /// What the instrument of the component's input shows per true value; known where the input is exact.
    Instrument,
}

/// What meets at a port.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PortKind {
    /// One variable, the pressure (Pa); the component answers with the flow into it (m³/s).
    Hydraulic,
    /// Two variables, position (m) and velocity (m/s); the component answers with a force on the body (N).
    Mechanical,
}

impl PortKind {
    /// How many variables the port brings to the component.
    pub const fn variables(self) -> usize {
        match self {
            PortKind::Hydraulic => 1,
            PortKind::Mechanical => 2,
        }
    }
}

#[derive(Debug, Clone, Copy)]
pub struct Port {
    pub name: &'static str,
    pub kind: PortKind,
    pub meaning: &'static str,
}

impl Port {
    pub const fn hydraulic(name: &'static str, meaning: &'static str) -> Self {
        Self { name, kind: PortKind::Hydraulic, meaning }
    }
    pub const fn mechanical(name: &'static str, meaning: &'static str) -> Self {
        Self { name, kind: PortKind::Mechanical, meaning }
    }
}

/// A state that the component owns.
#[derive(Debug, Clone, Copy)]
pub struct State {
    pub name: &'static str,
    pub unit: &'static str,
    /// Value at the start where the rig file is silent, in `unit`.
    pub initial: f64,
    /// Typical magnitude in `unit`; the integrator's absolute tolerance is relative to it.
    pub scale: f64,
    pub meaning: &'static str,
}

/// A signal that drives the component, named in the rig file and read from the record.
#[derive(Debug, Clone, Copy)]
pub struct Input {
    pub name: &'static str,
    pub unit: &'static str,
    pub meaning: &'static str,
    /// What it runs between in a working circuit, SI.
    pub range: (f64, f64),
    /// The parameter with which the part follows the input in a lag of first order; `None` where it acts at once.
    pub lag: Option<&'static str>,
}

/// The range of an input that may be anything.
pub const ANY: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

/// Which of a component's answers a worked number is about.
#[derive(Debug, Clone, Copy)]
pub enum Answer {
    /// Flow into (m³/s) or force at (N) the port with this index.
    Through(usize),
    /// Capacity at the port: m³/Pa, or kg.
    Capacity(usize),
    /// Rate of the state with this index, per second.
    Rate(usize),
}

/// One number worked by hand, which a test evaluates.
#[derive(Debug, Clone, Copy)]
pub struct Worked {
    pub text: &'static str,
    /// Parameters that differ from their defaults, in the units of their cards.
    pub parameters: &'static [(&'static str, f64)],
    /// Port variables in order, then states, SI.
    pub at: &'static [f64],
    /// Inputs, SI.
    pub inputs: &'static [f64],
    pub answer: Answer,
    /// SI.
    pub expect: f64,
}

/// The whole card of a component.
#[derive(Debug, Clone, Copy)]
pub struct Card {
    /// Name in the rig file.
    pub kind: &'static str,
    pub meaning: &'static str,
    /// The law as formulas.
    pub law: &'static str,
    pub source: &'static str,
    /// Where the law holds and what it leaves out.
    pub validity: &'static str,
    pub parameters: &'static [Parameter],
    pub ports: &'static [Port],
    pub states: &'static [State],
    pub inputs: &'static [Input],
    /// Index of the parameter that fixes the pressure of port 0, for boundaries such as a tank.
    pub fixes_pressure: Option<usize>,
    /// Typical gauge pressure at its ports, Pa; the integrator's absolute tolerance at a node is relative to the smallest
    /// of the components that meet there.
    pub pressure_scale: f64,
    pub worked: &'static [Worked],
    /// The law of an effect that a user has written; see [`Formula`](super::formula::Formula).
    pub formula: Option<&'static Expression>,
    /// The law of a component that a rig file or the catalogue writes.
    pub own: Option<&'static Own>,
    /// Whether it sees, behind its inputs, the seconds since the run began.
    pub sees_time: bool,
    /// Whether its law has the viscosity of the fluid.
    pub sees_viscosity: bool,
    /// Whether one flow passes from port 0 to port 1, which a difference of their pressures drives: pressure may be lost ahead
    /// of it.
    pub throttles: bool,
}

/// Square root of the mass of a spool over the stiffness that centres it: no data sheet states it, Bode plots show it.
pub(crate) const INERTIA_TIME: Parameter =
    Parameter::required("inertia_time", "T", "ms", "time constant of the spool's mass: its damping is tau/(2 T)")
        .is(Role::InertiaTime)
        .or(0.0)
        .uncertain_per_event(0.0);

/// What solenoid, pilot and electronics take until a spool begins to move.
pub(crate) const DEAD_TIME: Parameter =
    Parameter::required("dead_time", "t_d", "ms", "time between the command and the first movement of the spool")
        .is(Role::DeadTime)
        .or(0.0)
        .uncertain_per_event(0.0);

impl Role {
    /// Whether the parameter changes what drives the law and not the law, so that no sensitivity shows what it does.
    pub const fn is_of_the_drive(self) -> bool {
        matches!(self, Self::InertiaTime | Self::DeadTime)
    }

    /// Whether it is [`Role::Reference`].
    pub const fn is_reference(self) -> bool {
        matches!(self, Self::Reference)
    }

    /// Whether it is [`Role::OfRecord`].
    pub const fn is_of_record(self) -> bool {
        matches!(self, Self::OfRecord)
    }

    /// Whether the value may be another than it was, as a part wears.
    pub const fn may_wear(self) -> bool {
        !self.is_of_the_drive() && !self.is_reference() && !self.is_of_record()
    }
}

/// Whether two names are equal, at compile time too.
const fn is_same(a: &str, b: &str) -> bool {
    let (a, b) = (a.as_bytes(), b.as_bytes());
    let mut place = 0;
    while place < a.len() && place < b.len() && a[place] == b[place] {
        place += 1;
    }
    place == a.len() && place == b.len()
}

impl Card {
    /// Place of a parameter of the card among its parameters; where it has none of this name, what asks for it does not compile.
    pub const fn place(&self, name: &str) -> usize {
        let mut place = 0;
        while !is_same(self.parameters[place].name, name) {
            place += 1;
        }
        place
    }

    /// How many of its ports are hydraulic.
    pub const fn hydraulic_ports(&self) -> usize {
        let (mut port, mut count) = (0, 0);
        while port < self.ports.len() {
            count += matches!(self.ports[port].kind, PortKind::Hydraulic) as usize;
            port += 1;
        }
        count
    }

    /// An empty card to fill with struct update syntax.
    pub const EMPTY: Card = Card {
        kind: "",
        meaning: "",
        law: "",
        source: "",
        validity: "",
        parameters: &[],
        ports: &[],
        states: &[],
        inputs: &[],
        fixes_pressure: None,
        pressure_scale: 1e7,
        worked: &[],
        formula: None,
        own: None,
        sees_time: false,
        sees_viscosity: false,
        throttles: false,
    };

    /// Whether a parameter of the card has a role.
    pub const fn has(&self, role: Role) -> bool {
        let mut index = 0;
        while index < self.parameters.len() {
            if self.parameters[index].role as u8 == role as u8 {
                return true;
            }
            index += 1;
        }
        false
    }

    /// Number of variables that the ports and states bring to one evaluation.
    pub fn variables(&self) -> usize {
        self.ports.iter().map(|port| port.kind.variables()).sum::<usize>() + self.states.len()
    }
}
