//! Every effect's card: its units read, its worked numbers come out, and at its neutral value it does nothing.

use crate::support::cards;

use borescope::internals::model::{InputSignals, Model, cycle_times};
use borescope::internals::physics::effect::{EFFECTS, EffectLaw, Form, FreeParameter, LAWS};
use borescope::internals::physics::ports::{INPUTS, PORTS, STATES, VARIABLES};
use borescope::internals::report::effects::entry;
use borescope::internals::rig::{EffectInstance, ParameterSetting, Rig};
use cards::unit;

#[test]
fn cards_are_complete() {
    for effect in EFFECTS {
        for text in [effect.name, effect.meaning, effect.law, effect.source, effect.validity] {
            assert!(!text.is_empty(), "{}: a text is missing", effect.name);
        }
        let kebab = effect.name.split('-').all(|word| !word.is_empty() && word.chars().all(|c| c.is_ascii_lowercase()));
        assert!(kebab, "`{}` is not kebab-case", effect.name);
        assert_eq!(
            EFFECTS.iter().filter(|other| other.name == effect.name).count(),
            1,
            "{} appears twice",
            effect.name
        );
        assert!(!effect.parameters.is_empty(), "{} has no size", effect.name);
        for free in effect.parameters {
            assert!(free.plausible.0 < free.plausible.1, "{}.{}", effect.name, free.name);
            let neutral = free.neutral.unwrap_or(free.plausible.0);
            assert!((free.plausible.0..=free.plausible.1).contains(&neutral), "{}.{}", effect.name, free.name);
            if effect.form.card().is_some() {
                assert!(entry(effect, free.name).is_some(), "the card of {} has no {}", effect.name, free.name);
            }
        }
        for parameter in effect.form.card().into_iter().flat_map(|card| card.parameters) {
            unit(parameter.unit);
            assert!(parameter.bounds.0 < parameter.bounds.1, "{}.{}", effect.name, parameter.name);
        }
    }
    for card in LAWS {
        assert!(card.variables() <= VARIABLES && card.ports.len() <= PORTS, "{}", card.kind);
        assert!(card.states.len() <= STATES && card.inputs.len() <= INPUTS, "{}", card.kind);
        assert!(!card.worked.is_empty(), "{} has no worked number", card.kind);
    }
}

#[test]
fn worked_numbers_come_out() {
    for card in LAWS {
        cards::worked_numbers_come_out(card, |parameters, fluid, seen, answers| {
            EffectLaw::new(card.kind, parameters, fluid).unwrap().evaluate(seen, answers);
        });
    }
}

/// Every parameter of an effect where it does nothing.
fn neutral(rig: &Rig, placed: &EffectInstance) -> Vec<ParameterSetting> {
    placed
        .effect
        .parameters
        .iter()
        .enumerate()
        .map(|(place, free)| {
            let unit = rig.effect_unit(placed, free.name);
            let value = match (free.neutral, rig.bent(placed, free.name)) {
                (Some(neutral), _) => unit.difference_to_si(neutral),
                // What the rig has already.
                (None, Some(index)) if matches!(placed.effect.form, Form::ParameterChange) => {
                    rig.parameters[index].value
                }
                // A limit that nothing reaches.
                (None, _) if place == 0 => 1e9,
                // It only shapes the effect.
                (None, _) => {
                    let default = entry(placed.effect, free.name).and_then(|entry| entry.default);
                    unit.difference_to_si(default.unwrap_or(1.0))
                }
            };
            ParameterSetting { name: free.name.to_owned(), value, sigma: 0.0 }
        })
        .collect()
}

fn readings(rig: &Rig) -> Vec<Vec<f64>> {
    let cycle = rig.cycle.clone().unwrap();
    let drive = InputSignals::from_cycle(rig, &cycle);
    let times = cycle_times(rig, &cycle);
    let model = Model::new(rig.clone());
    model.solve(&rig.nominal(), &drive, &times).unwrap().values
}

#[test]
fn at_its_neutral_value_an_effect_does_nothing() {
    for name in ["telescopic", "two_tanks", "servo_axis", "hydrostatic_drive"] {
        let path = &format!("fixtures/{name}/rig.toml");
        let rig = Rig::read(path).unwrap();
        let without = readings(&rig);
        for placed in rig.effect_places() {
            // Its neutral value is a limit: a line always has some resistance, lest node and cylinder be one.
            if matches!(placed.effect.form, Form::Series { .. }) {
                continue;
            }
            // Nor is it neutral where the rig file states that the circuit has it.
            let stated = |free: &FreeParameter| {
                let own = rig.bent(&placed, free.name).map(|index| rig.parameters[index].value);
                let neutral = free.neutral.map(|neutral| rig.effect_unit(&placed, free.name).difference_to_si(neutral));
                own.zip(neutral).is_some_and(|(own, neutral)| own != neutral)
            };
            if matches!(placed.effect.form, Form::ParameterChange) && placed.effect.parameters.iter().any(stated) {
                continue;
            }
            let mut with = rig.clone();
            let id = with.effect_id(&placed);
            with.give_effect(&placed, &neutral(&rig, &placed)).unwrap();
            for ((sensor, before), after) in rig.sensors.iter().zip(&without).zip(&readings(&with)) {
                let size = before.iter().fold(0.0_f64, |size, value| size.max(value.abs()));
                let change = before.iter().zip(after).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(change <= 1e-9 * size, "{path}: {id} changes {} by {:.1e}", sensor.name, change / size);
            }
        }
    }
}
