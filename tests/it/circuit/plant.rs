//! Rigs of more states than any size that is compiled for itself.

use approx::assert_relative_eq;
use borescope::Rig;
use borescope::internals::model::{Model, Tolerance};
use borescope::internals::numeric::MOST_STATES;

use crate::support::cycle::Run;

/// Tanks side by side that drain through orifices of 3 mm, 4 mm, ... into one sump.
fn text(diameters: &[usize]) -> String {
    let mut nodes = String::from("[nodes]\nsump = {}\n");
    let mut components = String::from("[components.sump]\nkind = \"tank\"\nports = { T = \"sump\" }\n");
    let mut sensors = String::from("[sensors]\n");
    for (index, diameter) in diameters.iter().enumerate() {
        nodes += &format!("n{index} = {{ initial = \"200 mbar\" }}\n");
        components += &format!(
            "[components.tank{index}]\nkind = \"reservoir\"\nports = {{ P = \"n{index}\" }}\narea = \"150 cm2\"\n\
             [components.outlet{index}]\nkind = \"orifice\"\nports = {{ in = \"n{index}\", out = \"sump\" }}\n\
             diameter = \"{diameter} mm\"\ntransition_pressure = \"1 mbar\"\n"
        );
        sensors += &format!("level{index} = {{ quantity = \"level\", at = \"n{index}\", noise = \"1 mm\" }}\n");
    }
    let fluid = "[fluid]\ndensity = \"998 kg/m3\"\n";
    let cycle = "[cycle]\ninterval = \"1 s\"\nphases = [{ duration = \"60 s\" }]\n";
    format!("{fluid}{nodes}{components}{sensors}{cycle}")
}

fn tanks(diameters: &[usize]) -> Model {
    let tight = Tolerance { relative: 1e-9, absolute: 1e-9 };
    Model::new(Rig::parse("tanks.toml", text(diameters)).unwrap()).with_tolerance(tight)
}

#[test]
fn a_plant_of_many_tanks_empties_as_each_alone_does() {
    let diameters: Vec<usize> = (3..40).collect();
    let together = tanks(&diameters);
    assert!((25..=MOST_STATES).contains(&together.states().len()));
    let run = Run::of(&together);
    let (drive, times) = (run.drive(), (0..60).map(f64::from).collect::<Vec<_>>());
    let of = |model: &Model, index: usize| model.rig.parameter(&format!("outlet{index}.diameter")).unwrap();
    let by: Vec<usize> = (0..diameters.len()).map(|index| of(&together, index)).collect();
    let all = together.sensitivities(&together.rig.nominal(), &by, &drive, &times).unwrap();
    let plain = together.solve(&together.rig.nominal(), &drive, &times).unwrap();
    for index in [0, 11, 36] {
        let alone = tanks(&diameters[index..=index]);
        let own = alone.sensitivities(&alone.rig.nominal(), &[of(&alone, 0)], &drive, &times).unwrap();
        for row in 0..times.len() {
            // Steps follow the fastest of all tanks; 1e-9 of the 100 bar that states are scaled by are 1e-6 m.
            assert_relative_eq!(
                plain.values[index][row],
                own.outputs.values[0][row],
                epsilon = 1e-6,
                max_relative = 1e-6
            );
            assert_relative_eq!(
                all.derivatives[index][index][row],
                own.derivatives[0][0][row],
                epsilon = 1e-3,
                max_relative = 1e-3
            );
            // What one tank's outlet does, no other tank feels.
            let other = (index + 1) % diameters.len();
            assert_eq!(all.derivatives[index][other][row], 0.0);
        }
    }
}

#[test]
fn a_rig_of_too_many_states_is_refused_with_their_number() {
    let complaint = Rig::parse("tanks.toml", text(&[5; MOST_STATES + 1])).unwrap_err();
    assert!(complaint.to_string().contains("the rig has 101 states, more than 100"), "{complaint}");
}
