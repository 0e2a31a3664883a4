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

/// Which residuals are made of a component's law; each is a function of `residual`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Residuals {
    /// Flow and force balances of a cylinder.
    Cylinder,
    /// Flow against pressure drop of a flow control valve.
    FlowControl,
    /// Flow against pressure drop over each edge of a directional valve.
    Directional,
    /// Delivery against what leaves.
    Pump,
    /// What should be shut below its set pressure, at the pump that it guards.
    Relief,
    /// Flow of the law at the measured pressures against the flow that passes from one port to the other.
    Through,
    /// The same at each port that takes a flow.
    EachPort,
    /// None is known.
    None,
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
    /// It takes no flow while the pressure keeps it shut.
    OneWay,
    /// It takes a flow that has to be measured.
    Ends,
    /// It takes the flow of its law at the measured quantities.
    Law,
    /// The same, and it stores oil.
    LawAndStores,
    /// What enters leaves at the other port, where it is measured; otherwise the flow of its law.
    ThroughOrLaw,
}
