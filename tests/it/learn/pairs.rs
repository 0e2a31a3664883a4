//! Two effects missing at once, in a press that hides both: each named for what it is, and no third in their place.

use std::fs;

use borescope::internals::learn::add::add;
use borescope::internals::learn::evaluated::Conclusion;
use borescope::internals::learn::improve::improve;
use borescope::internals::model::Model;
use borescope::{Record, Rig};

use crate::support::cycle::Run;

const PRESS: &str = "fixtures/press/rig.toml";
const HIDDEN: &str = "
[effects]
\"line-resistance@A\" = { turbulent = \"0.02 bar.min2/L2\" }
\"seal-friction@cylinder\" = { coulomb = \"1500 N\", breakaway = \"600 N\", stribeck_velocity = \"10 mm/s\" }
";

/// Two records of the press that hides both, under different loads.
fn records() -> [Record; 2] {
    let hidden = Model::new(Rig::parse(PRESS, fs::read_to_string(PRESS).unwrap() + HIDDEN).unwrap());
    [(1, 1.0), (2, 1.5)].map(|(seed, load)| {
        let mut cycle = hidden.rig.cycle.clone().unwrap();
        // The second input is the force.
        for phase in &mut cycle.phases {
            phase.inputs[1].from *= load;
            phase.inputs[1].to *= load;
        }
        Run::of(&hidden).through(cycle).seed(seed).record("press")
    })
}

mod studies {
    use super::*;

    /// What is added first has taken over what it can of the other; from the same record that is no knowledge.
    #[test]
    #[ignore = "ten seconds"]
    fn effects_that_are_added_one_after_the_other_are_fitted_together() {
        let record = &records()[0];
        for order in [["line-resistance@A", "seal-friction@cylinder"], ["seal-friction@cylinder", "line-resistance@A"]]
        {
            let mut text = fs::read_to_string(PRESS).unwrap();
            for effect in order {
                let rig = Rig::parse(PRESS, text.clone()).unwrap();
                text = add(&text, &rig, effect, Some(record)).unwrap().text;
            }
            let rig = Rig::parse(PRESS, text).unwrap();
            for (id, truth) in [("line-resistance@A.turbulent", 0.02), ("seal-friction@cylinder.coulomb", 1500.0)] {
                let parameter = &rig.parameters[rig.parameter(id).unwrap()];
                let [value, sigma] = [parameter.value, parameter.sigma].map(|si| parameter.unit.difference_from_si(si));
                let off = (value - truth) / sigma;
                assert!(off.abs() < 4.0 && sigma < 0.2 * truth, "{order:?}: {id} {value} +- {sigma}");
            }
        }
    }

    #[test]
    #[ignore = "ten seconds"]
    fn a_line_and_a_seal_are_no_viscous_friction() {
        let records = records();
        let found = improve(&Rig::read(PRESS).unwrap(), &records[0], &records[1], |_| ()).unwrap();
        let added: Vec<&str> = found.steps.iter().filter_map(|step| step.added.as_deref()).collect();
        assert_eq!(
            (found.conclusion, added),
            (Conclusion::EffectFound, vec!["line-resistance@A + seal-friction@cylinder"])
        );
        let value = |id: &str| {
            let index = found.trial.rig.parameter(id).unwrap();
            found.trial.rig.parameters[index].unit.from_si(found.trial.values[index])
        };
        // What viscous friction alone leaves is 1.9 and 1.6 times the noise.
        let left = found.steps.last().unwrap().times_noise();
        assert!(left.iter().all(|times| *times < 1.1), "{left:?}");
        let (line, seal) = (value("line-resistance@A.turbulent"), value("seal-friction@cylinder.coulomb"));
        assert!((line - 0.02).abs() < 0.002 && (seal - 1500.0).abs() < 150.0, "{line} {seal}");
    }
}
