//! What every component owes besides its law: asked by the type, so that one that lacks an answer does not compile.

/// What a component is to the drawing, to residuals and to balances.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Facts {
    /// How the circuit shows it.
    pub symbol: Symbol,
    /// Which residuals are made of its law.
    pub residuals: Residuals,
    /// What a flow balance makes of it.
    pub balance: Balance,
    /// How long it takes to settle after a jump of an input.
    pub settles: Settles,
}

impl Facts {
    /// Those of physics that an effect joins to a circuit: a box, without residuals, and no balance reaches past it.
    pub const OF_EFFECT: Self =
        Self { symbol: Symbol::Box, residuals: Residuals::None, balance: Balance::Ends, settles: Settles::AtOnce };

    /// Place of the pressure drop below which it is shut, where it should be then.
    pub const fn opens_at(self) -> Option<usize> {
        match (self.residuals, self.balance) {
            (Residuals::Relief { opens_at }, _) | (_, Balance::OneWay { opens_at }) => Some(opens_at),
            _ => None,
        }
    }

    /// Whether it is asked for a second hydraulic port, and only one.
    pub const fn needs_two_ports(self) -> bool {
        matches!(self.residuals, Residuals::Through | Residuals::FlowControl { .. })
            || matches!(self.balance, Balance::Through | Balance::ThroughOrLaw | Balance::OneWay { .. })
    }
}

/// What a component is, and so how it is drawn, after ISO 1219-1: effects of cylinders and relief valves sit at whatever has their symbol.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Symbol {
    Pump,
    VariablePump,
    ReversiblePump,
    ReliefValve,
    FlowControlValve,
    DirectionalValve,
    CheckValve,
    PilotCheckValve,
    OnOffValve,
    Restrictor,
    Orifice,
    OneWayThrottle,
    Filter,
    BypassFilter,
    Motor,
    FreeOutlet,
    Cylinder,
    Vessel,
    Accumulator,
    /// A box with its name.
    Box,
    /// Part of a line, or of a body.
    Hidden,
    /// An arrow at the body that it pushes.
    Force,
}

impl Symbol {
    /// What has this symbol, of those that effects ask for.
    pub fn words(self) -> &'static str {
        match self {
            Self::Cylinder => "a cylinder",
            Self::Motor => "a motor",
            Self::ReliefValve => "a relief valve",
            _ => "a component",
        }
    }

    /// Whether it takes a place of its own in the circuit.
    #[cfg(feature = "cli")]
    pub fn has_place(self) -> bool {
        !matches!(self, Self::Hidden | Self::Force)
    }
}

/// Which residuals are made of a component's law; each is a function of `residual`. What a formula reads of the card besides the law is
/// here by its place; [`Card::place`](crate::physics::card::Card::place) gives it by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Residuals {
    /// Flow and force balances of a cylinder: its ports are A, B and the body.
    Cylinder { bore: usize, rod: usize, stroke: usize },
    /// Flow against pressure drop of a flow control valve.
    FlowControl { orifice: Throttle, spring: Spring },
    /// Flow against pressure drop over each edge of a directional valve: its ports are P, T, A and B.
    Directional { opening: usize, rated_flow: usize, rated_drop: usize },
    /// Delivery against what leaves.
    Pump,
    /// What should be shut below its set pressure, at the pump that it guards.
    Relief { opens_at: usize },
    /// Flow of the law at the measured pressures against the flow that passes from one port to the other.
    Through,
    /// The same at each port that takes a flow.
    EachPort,
    /// None is known.
    None,
}

/// The throttle of a flow control valve: places of its parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Throttle {
    pub diameter: usize,
    pub discharge_coefficient: usize,
}

/// What holds the pressure drop of that throttle: places of its parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Spring {
    pub rate: usize,
    pub compression: usize,
    pub spool_area: usize,
}

/// How long a component takes to settle after a jump of an input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Settles {
    /// No longer than the circuit around it.
    AtOnce,
    /// With its time constants: its parameters of [`Role::Lag`](crate::physics::card::Role::Lag).
    Lag,
}

/// What the flow balance of a node makes of a component that is joined to it and whose flow nobody measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Balance {
    /// It stores oil and takes no flow.
    Stores,
    /// It stores oil and takes a flow that has to be measured.
    Chamber,
    /// What enters leaves at the other port.
    Through,
    /// It takes no flow while the pressure from port 0 to port 1 keeps it shut.
    OneWay { opens_at: usize },
    /// It takes a flow that has to be measured.
    Ends,
    /// It takes the flow of its law at the measured quantities.
    Law,
    /// The same, and it stores oil.
    LawAndStores,
    /// What enters leaves at the other port, where it is measured; otherwise the flow of its law.
    ThroughOrLaw,
}
