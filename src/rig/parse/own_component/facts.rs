//! What a component of formulas is to the drawing, to residuals and to balances.

use super::formulas::Formulas;
use crate::complaint::Complaint;
use crate::physics::card::{Parameter, Port, PortKind, Role};
use crate::physics::component::facts::{Balance, Facts, Residuals, Settles, Symbol};
use crate::rig::parse::named;
use crate::rig::source::Table;

/// The symbols that one may have.
pub(super) const SYMBOLS: &[(&str, Symbol)] = &[
    ("box", Symbol::Box),
    ("pump", Symbol::Pump),
    ("variable-pump", Symbol::VariablePump),
    ("relief-valve", Symbol::ReliefValve),
    ("flow-control-valve", Symbol::FlowControlValve),
    ("check-valve", Symbol::CheckValve),
    ("pilot-check-valve", Symbol::PilotCheckValve),
    ("on-off-valve", Symbol::OnOffValve),
    ("restrictor", Symbol::Restrictor),
    ("orifice", Symbol::Orifice),
    ("one-way-throttle", Symbol::OneWayThrottle),
    ("filter", Symbol::Filter),
    ("bypass-filter", Symbol::BypassFilter),
    ("motor", Symbol::Motor),
    ("accumulator", Symbol::Accumulator),
    ("cylinder", Symbol::Cylinder),
    ("directional-valve", Symbol::DirectionalValve),
    ("hidden", Symbol::Hidden),
    ("force", Symbol::Force),
];

pub(super) fn symbol(table: &Table<'_>) -> Result<Symbol, Complaint> {
    table.get("symbol").map_or(Ok(Symbol::Box), |value| named(&value, "symbols", SYMBOLS))
}

/// What follows from the lines.
pub(super) fn of(
    formulas: &Formulas,
    ports: &[Port],
    parameters: &[Parameter],
    symbol: Symbol,
    settles: bool,
) -> Facts {
    let takes_flow = !formulas.flows.is_empty() || !formulas.pistons.is_empty();
    let stores = !formulas.volumes.is_empty();
    let hydraulic = ports.iter().all(|port| port.kind == PortKind::Hydraulic);
    // What enters at one of two ports leaves at the other.
    let series = hydraulic && ports.len() == 2 && !stores && !formulas.flows.is_empty();
    // States that do not settle have to be measured, which is looked at where the residuals are formed.
    let residuals = match (takes_flow, series) {
        (false, _) => Residuals::None,
        (true, true) => Residuals::Through,
        (true, false) => Residuals::EachPort,
    };
    let balance = match (settles, takes_flow, stores) {
        // A state that does not come to rest is not known from measured quantities.
        (_, false, true) if settles => Balance::Stores,
        (false, _, _) if series => Balance::Through,
        (false, _, _) => Balance::Ends,
        (true, _, true) => Balance::LawAndStores,
        (true, _, false) if series => Balance::ThroughOrLaw,
        (true, _, false) => Balance::Law,
    };
    let lags = parameters.iter().any(|own| own.role == Role::Lag);
    Facts { symbol, residuals, balance, settles: if lags { Settles::Lag } else { Settles::AtOnce } }
}
