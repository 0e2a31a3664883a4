//! The components, one file each. A new one is its file and its line in `components!`.

use self::facts::{Facts, Settles};
use super::card::{Card, Role};
use super::drop::{Dropped, Throttle};
use super::effect::EffectLaw;
use super::fluid::Fluid;
use super::formula::Formula;
use super::own_law::OwnLaw;
use super::ports::{Law, PortFlows, PortVariables};
use crate::numeric::Real;

pub mod facts;

macro_rules! components {
    ($($module:ident :: $name:ident),+ $(,)?) => {
        $(pub mod $module;)+

        /// Every component that a rig file may name.
        pub const CARDS: &[&Card] = &[$(&$module::CARD),+];

        $(const _: () = {
            let card = $module::CARD;
            assert!(
                !card.worked.is_empty() || card.fixes_pressure.is_some(),
                concat!("a component has a number worked by hand: ", stringify!($module))
            );
            assert!(
                card.hydraulic_ports() == 2 || !(card.throttles || $module::FACTS.needs_two_ports()),
                concat!("what one flow passes through has two hydraulic ports: ", stringify!($module))
            );
            let lags = matches!($module::FACTS.settles, Settles::Lag);
            assert!(
                lags == card.has(Role::Lag),
                concat!("what settles with a lag has a parameter of Role::Lag: ", stringify!($module))
            );
        };)+

        /// What the component of a card is to the drawing, to residuals and to balances.
        pub fn facts(card: &Card) -> Facts {
            if let Some(own) = card.own {
                return own.facts;
            }
            $({
                if card.kind == $module::CARD.kind {
                    return $module::FACTS;
                }
            })+
            Facts::OF_EFFECT
        }

        /// Any component's law, chosen by kind.
        #[derive(Debug, Clone)]
        pub enum AnyLaw<T> {
            $($name($module::$name<T>),)+
            /// What an effect has joined to the rig.
            Effect(EffectLaw<T>),
            /// What a user's effect has joined to it.
            Formula(Formula<T>),
            /// A component in whose line a user's effect loses pressure.
            Dropped(Box<Dropped<AnyLaw<T>, T>>),
            /// A component that the rig file or the catalogue writes.
            Own(Box<OwnLaw<T>>),
        }

        impl<T: Real> AnyLaw<T> {
            /// The law of a card, or `None` for a card that is neither in [`CARDS`] nor an effect's.
            pub fn new(card: &'static Card, parameters: &[T], fluid: &Fluid<T>) -> Option<Self> {
                if card.formula.is_some() {
                    return Formula::new(card, parameters).map(AnyLaw::Formula);
                }
                if let Some(own) = card.own {
                    return Some(AnyLaw::Own(Box::new(OwnLaw::new(card, own, parameters, fluid))));
                }
                let kind = card.kind;
                $({
                    if kind == $module::CARD.kind {
                        return Some(AnyLaw::$name($module::$name::new(parameters, fluid)));
                    }
                })+
                EffectLaw::new(kind, parameters, fluid).map(AnyLaw::Effect)
            }

            #[inline]
            pub fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
                match self {
                    $(AnyLaw::$name(law) => law.evaluate(seen, answers),)+
                    AnyLaw::Effect(law) => law.evaluate(seen, answers),
                    AnyLaw::Formula(law) => law.evaluate(seen, answers),
                    AnyLaw::Dropped(law) => law.evaluate(seen, answers),
                    AnyLaw::Own(law) => law.evaluate(seen, answers),
                }
            }
        }

        impl<T: Real> Throttle<T> for AnyLaw<T> {
            #[inline]
            fn evaluate(&self, seen: &PortVariables<T>, answers: &mut PortFlows<T>) {
                AnyLaw::evaluate(self, seen, answers);
            }
        }
    };
}

components! {
    accumulator::Accumulator,
    check_valve::CheckValve,
    coulomb_friction::CoulombFriction,
    cylinder::Cylinder,
    directional_valve::DirectionalValve,
    external_force::ExternalForce,
    flow_control_valve::FlowControlValve,
    flow_source::FlowSource,
    free_outlet::FreeOutlet,
    line_volume::LineVolume,
    on_off_valve::OnOffValve,
    orifice::Orifice,
    pilot_check_valve::PilotCheckValve,
    proportional_relief_valve::ProportionalReliefValve,
    pump::Pump,
    relief_valve::ReliefValve,
    reservoir::Reservoir,
    restrictor::Restrictor,
    reversible_pump::ReversiblePump,
    suction_strainer::SuctionStrainer,
    tank::Tank,
}

/// The card of `kind`.
pub fn card(kind: &str) -> Option<&'static Card> {
    CARDS.iter().copied().find(|card| card.kind == kind)
}
