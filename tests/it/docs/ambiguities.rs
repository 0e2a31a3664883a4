//! The numbers in `docs/theory/two-ambiguities.md` and `docs/theory/order-of-series.md`.
//!
//! `BLESS=1 cargo test --release --test it -- docs::ambiguities` writes the present tables into the pages.

use crate::support::page;

use crate::support::cycle::Run;
use crate::support::steady;
use crate::support::telescopic;

use std::sync::OnceLock;

use borescope::Rig;
use borescope::internals::diagnosis::{Diagnosis, DiagnosisOptions, diagnose};
use borescope::internals::model::{InputSignals, Model};
use borescope::internals::residual::{Detection, Variant, signatures};
use steady::{LPM, Steady};

const AMBIGUITIES: &str = "docs/theory/two-ambiguities.md";
const SERIES: &str = "docs/theory/order-of-series.md";
/// 1 L/min/bar in m³/s/Pa.
const PER_BAR: f64 = LPM / 1e5;
const A_T: &str = "directional_valve.leak_AT";
const P_B: &str = "directional_valve.leak_PB";
const OPENING: &str = "directional_valve.opening";

/// Equal, or two numbers that differ by no more than one of the last digit: another processor may round another way.
fn same(a: &str, b: &str) -> bool {
    let [a, b] = [a, b].map(|word| word.trim_matches(['(', ')', ',']));
    let decimals = a.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    match (a.parse::<f64>(), b.parse::<f64>()) {
        (Ok(x), Ok(y)) => (x - y).abs() < 1.01 * 0.1_f64.powi(decimals as i32),
        _ => a == b,
    }
}

/// Holds a page's part between `<!-- name -->` and `<!-- end -->` against what it should say, or writes it.
fn page_says(page: &str, name: &str, lines: &[String]) {
    let now = lines.iter().map(|line| format!("{line}\n")).collect::<String>();
    println!("{now}");
    if page::blessed() {
        page::write(page, name, &now);
    }
    let old = page::part(page, name);
    let (old, new): (Vec<&str>, Vec<&str>) = (old.split_whitespace().collect(), now.split_whitespace().collect());
    assert!(old.len() == new.len() && old.iter().zip(&new).all(|(a, b)| same(a, b)), "{page}, {name} is stale:\n{now}");
}

fn row(cells: &[String]) -> String {
    format!("| {} |", cells.join(" | "))
}

fn header(cells: &[&str]) -> [String; 2] {
    [format!("| {} |", cells.join(" | ")), format!("|{}", "---|".repeat(cells.len()))]
}

/// The rig with the faults that the paper speaks of; with so few the joint fit of simulated cases is quick.
fn model() -> &'static Model {
    static MODEL: OnceLock<Model> = OnceLock::new();
    MODEL.get_or_init(|| {
        let mut rig = Rig::read(telescopic::RIG).unwrap_or_else(|complaint| panic!("{complaint}"));
        let spoken_of = [FAULTS.as_slice(), &[A_T, P_B]].concat();
        let own: Vec<usize> = spoken_of.iter().map(|id| rig.parameter(id).unwrap()).collect();
        rig.faults.retain(|fault| own.contains(&fault.parameter));
        assert_eq!(rig.faults.len(), own.len());
        Model::new(rig)
    })
}

/// Cases of section 2.2.3.2: opening, leak A to T and leak P to B in L/min/bar.
const CASES: [(&str, f64, f64, f64); 8] = [
    ("healthy", 1.0, 0.0, 0.0),
    ("leak A to T", 1.0, 0.02, 0.0),
    ("leak P to B", 1.0, 0.0, 0.02),
    ("opening 0.7", 0.7, 0.0, 0.0),
    ("opening 0.3", 0.3, 0.0, 0.0),
    ("opening 0.3, leak A to T", 0.3, 0.02, 0.0),
    ("opening 0.3, leak P to B", 0.3, 0.0, 0.02),
    ("opening 0.25", 0.25, 0.0, 0.0),
];

fn set((_, opening, a_t, p_b): (&str, f64, f64, f64)) -> [(&'static str, f64); 3] {
    [(OPENING, opening), (A_T, a_t * PER_BAR), (P_B, p_b * PER_BAR)]
}

/// The first outstroke of a case, from 1.2 to 2.2 s.
fn cases() -> &'static [Steady] {
    static CASES_STEADY: OnceLock<Vec<Steady>> = OnceLock::new();
    CASES_STEADY.get_or_init(|| {
        let model = model();
        CASES
            .iter()
            .map(|&case| Steady::of(&model.rig, &Run::of(model).with(&set(case)).record("simulated"), 1.2, 2.2))
            .collect()
    })
}

#[test]
fn leak_or_lost_opening_by_the_pressure() {
    let mut lines = header(&["", "relief valve", "p_P, bar", "step, bar", "p_pump, bar", "step, bar"]).to_vec();
    let mut steps = Vec::new();
    for (index, (case, steady)) in CASES.iter().zip(cases()).enumerate() {
        // The second half is compared with an opening of 0.3 alone.
        let from = &cases()[if index < 4 { 0 } else { 4 }];
        let (at_p, at_pump) = (steady.p_p - from.p_p, steady.p_pump - from.p_pump);
        let state = if steady.p_pump > 100e5 { "open" } else { "shut" };
        let mut cells = vec![case.0.to_owned(), state.to_owned()];
        for (pressure, step) in [(steady.p_p, at_p), (steady.p_pump, at_pump)] {
            let step = if index % 4 == 0 { "-".to_owned() } else { format!("{:+.2}", step / 1e5) };
            cells.extend([format!("{:.1}", pressure / 1e5), step]);
        }
        lines.push(row(&cells));
        steps.push((state, at_p));
    }
    page_says(AMBIGUITIES, "pressure", &lines);
    // The printed rule: a leak lowers the pressure, a lost opening raises it.
    let noise = 0.25e5;
    assert!(
        steps[..4].iter().all(|(state, _)| *state == "shut") && steps[4..].iter().all(|(state, _)| *state == "open")
    );
    assert!(steps[1].1 < -noise && steps[3].1 > noise, "{steps:?}");
    // Its steps are lost in what one sample shows once the relief valve is open, although faults are as large.
    assert!(steps[5].1.abs() < noise && steps[7].1.abs() < 2.0 * noise, "{steps:?}");
}

#[test]
fn leak_or_lost_opening_by_the_residuals() {
    let ids = ["leakage", "consumer", "supply", "return"].map(|name| format!("directional_valve.{name}"));
    let mut lines =
        header(&["", "(16)", "(18)", "(20)", "B to T", "opening", "A to T, L/min", "set", "P to B, L/min", "set"])
            .to_vec();
    for (case, steady) in CASES.iter().zip(cases()) {
        let residuals = ids.clone().map(|id| steady.residual(&id, Variant::Corrected));
        let [leakage, consumer, supply, back] = residuals;
        // Rank 2: the third is the difference of the others, up to the noise of what rates of pressure add.
        assert!((leakage - (consumer - supply)).abs() < 0.01 * LPM, "{}", case.0);
        // One common opening and both edges: q_P - l_PB = alpha Q_PA, q_B + l_PB = alpha Q_BT, q_A + l_AT = alpha Q_PA.
        let (q_pa, q_bt) = (supply + steady.q_p, back + steady.q_b);
        let opening = (steady.q_p + steady.q_b) / (q_pa + q_bt);
        let (a_t, p_b) = (opening * q_pa - steady.q_a, steady.q_p - opening * q_pa);
        let truth = [case.2 * PER_BAR * steady.p_a, case.3 * PER_BAR * (steady.p_p - steady.p_b)];
        let mut cells = vec![case.0.to_owned()];
        cells.extend(residuals.map(|value| format!("{:.2}", value / LPM + 0.0)));
        cells.push(format!("{opening:.3}"));
        for (found, truth) in [(a_t, truth[0]), (p_b, truth[1])] {
            cells.extend([found, truth].map(|flow| format!("{:.2}", flow / LPM)));
            assert!((found - truth).abs() < 0.03 * LPM, "{}: {} of {}", case.0, found / LPM, truth / LPM);
        }
        assert!((opening - case.1).abs() < 0.005 * case.1.max(0.5), "{}: {opening}", case.0);
        lines.push(row(&cells).replace("-0.00", "0.00"));
    }
    page_says(AMBIGUITIES, "residuals", &lines);
}

/// Singular values of the answers of these residuals to leaks and opening, each answer by its limit and noise.
fn singular(matrix: &[borescope::internals::residual::Signature], names: &[&str]) -> Vec<f64> {
    let of = |name: &str| {
        let id = format!("directional_valve.{name}");
        let row = matrix.iter().find(|row| row.generator.id == id && row.phase == "P-A").unwrap();
        let answer = |id: &str| row.answers.iter().find(|answer| answer.parameter == id).unwrap();
        // A tenth of the range, in L/min: a common scale for all of them.
        [A_T, P_B, OPENING].map(|id| answer(id).slope * answer(id).step * 0.1 / LPM)
    };
    let rows: Vec<[f64; 3]> = names.iter().map(|name| of(name)).collect();
    let matrix = nalgebra::DMatrix::from_fn(rows.len(), 3, |i, j| rows[i][j]);
    let mut values: Vec<f64> = matrix.singular_values().iter().copied().collect();
    values.sort_by(|a, b| b.total_cmp(a));
    values
}

#[test]
fn three_printed_estimators_have_rank_2_and_the_return_makes_it_3() {
    // One stroke that ends while it runs steadily, so that every residual is asked at the same pressures.
    let mut model = model().clone();
    let phases = &mut model.rig.cycle.as_mut().unwrap().phases;
    phases.truncate(2);
    phases[1].duration = 1.9;
    let (rig, record) = (&model.rig, Run::of(&model).with(&[]).record("simulated"));
    let drive = InputSignals::from_record(rig, &record).unwrap();
    let matrix = signatures(rig, &record, &drive, Detection::default().window).unwrap();
    let printed = singular(&matrix, &["leakage", "consumer", "supply"]);
    let all = singular(&matrix, &["leakage", "consumer", "supply", "return"]);
    let mut lines = header(&["residuals", "first", "second", "third", "rank"]).to_vec();
    for (name, values) in [("(16), (18), (20)", &printed), ("and B to T", &all)] {
        let rank = values.iter().filter(|value| **value > 1e-3 * values[0]).count();
        let mut cells = vec![name.to_owned()];
        cells.extend(values.iter().map(|value| format!("{value:.2}")));
        cells.push(rank.to_string());
        lines.push(row(&cells));
    }
    page_says(AMBIGUITIES, "rank", &lines);
    assert!(printed[2] < 1e-3 * printed[0], "{printed:?}");
    assert!(all[2] > 0.05 * all[0], "{all:?}");
}

/// A joint fit in a line: each fault that is present with its interval.
fn said(diagnosis: &Diagnosis) -> String {
    let number = |value: f64| borescope::internals::number::text(borescope::internals::number::rounded(value, 4));
    let present = diagnosis.present().map(|fault| {
        let unit = if fault.unit == "-" { String::new() } else { format!(" {}", fault.unit) };
        let [low, high] = fault.ci95.map(|end| end.map_or("open".to_owned(), number));
        format!("`{}` {} ({low} to {high}){unit}", fault.id, number(fault.value))
    });
    let all: Vec<String> = present.collect();
    if all.is_empty() { "healthy".to_owned() } else { all.join(", ") }
}

#[test]
fn leak_or_lost_opening_by_the_joint_fit() {
    let model = model();
    let fit = |index: usize| {
        diagnose(model, &Run::of(model).with(&set(CASES[index])).record("simulated"), &DiagnosisOptions::default())
            .unwrap()
            .diagnosis
    };
    let cases = [1, 6];
    let found = std::thread::scope(|scope| {
        let running = cases.map(|index| scope.spawn(move || fit(index)));
        running.map(|thread| thread.join().unwrap())
    });
    let mut lines = header(&["", "found"]).to_vec();
    for (index, diagnosis) in cases.into_iter().zip(&found) {
        let (name, opening, a_t, p_b) = CASES[index];
        lines.push(row(&[name.to_owned(), said(diagnosis)]));
        for (id, value, healthy) in [(OPENING, opening, 1.0), (A_T, a_t, 0.0), (P_B, p_b, 0.0)] {
            let fault = diagnosis.faults.iter().find(|fault| fault.id == id).unwrap();
            assert_eq!(fault.present, value != healthy, "{name}: {fault:?}");
            assert!(value == healthy || (fault.value / value - 1.0).abs() < 0.03, "{name}: {fault:?}");
        }
    }
    page_says(AMBIGUITIES, "fit", &lines);
}

/// A series of the paper: what its record shows near the end of the first outstroke, and its diagnosis.
struct Series {
    steady: Steady,
    diagnosis: &'static Diagnosis,
}

/// Clearance in mm, orifice in mm and opening that were put in, from `fixtures/telescopic/truth.toml`.
const TRUTH: [[f64; 3]; 3] = [[0.25, 2.5, 0.3], [0.15, 3.5, 0.2], [0.2, 1.5, 0.6]];
const FAULTS: [&str; 3] = ["cylinder.clearance", "flow_control.orifice_diameter", OPENING];

fn series() -> &'static [Series; 3] {
    static SERIES: OnceLock<[Series; 3]> = OnceLock::new();
    SERIES.get_or_init(|| {
        ["series_1", "series_2", "series_3"].map(|name| {
            let record = telescopic::record(name);
            let (from, to) = steady::between(&record, 0.120, 0.165);
            let steady = Steady::of(&model().rig, &record, from, to);
            Series { steady, diagnosis: &telescopic::diagnosis(name).result }
        })
    })
}

/// Series from the worst to the lightest, the largest number first.
fn order(values: [f64; 3]) -> String {
    let mut series = [1, 2, 3];
    series.sort_by(|a, b| values[b - 1].total_cmp(&values[a - 1]));
    format!("{} > {} > {}", series[0], series[1], series[2])
}

/// Sizes of the three faults from single components, at their healthy neighbours' measured pressures: SI.
fn sizes(steady: &Steady, rig: &Rig) -> [f64; 3] {
    [
        steady.clearance(rig, steady.residual("cylinder.leakage", Variant::Corrected)),
        steady.diameter(rig),
        steady.q_p / (steady.q_p + steady.residual("directional_valve.supply", Variant::Corrected)),
    ]
}

/// Stories of half a minute, which `.ci/run` goes through behind the tests.
mod gallery {
    use super::*;

    #[test]
    #[ignore = "half a minute"]
    fn more_flow_less_speed() {
        let [one, two, _] = series();
        let mut lines = header(&["", "series 1", "series 2"]).to_vec();
        let mut add = |name: &str, decimals: usize, of: &dyn Fn(&Steady) -> f64| {
            let cells = [one, two].map(|series| format!("{:.decimals$}", of(&series.steady)));
            lines.push(row(&[name.to_owned(), cells[0].clone(), cells[1].clone()]));
        };
        add("flow into the cylinder, L/min", 2, &|steady| steady.q_a / LPM);
        add("speed, mm/s", 1, &|steady| steady.speed * 1e3);
        add("pump pressure, bar", 1, &|steady| steady.p_pump / 1e5);
        add("flow that moves the piston, $A_1 v$, L/min", 2, &|steady| {
            (steady.q_a - steady.residual("cylinder.flow_A", Variant::Corrected)) / LPM
        });
        for (name, id) in [
            ("flow past the piston, (4), L/min", "cylinder.leakage"),
            ("lost opening, (20), L/min", "directional_valve.supply"),
            ("lost flow of the throttle, (10), L/min", "flow_control.flow"),
        ] {
            add(name, 2, &|steady| steady.residual(id, Variant::Corrected) / LPM);
        }
        page_says(AMBIGUITIES, "speed", &lines);
        let [one, two] = [&one.steady, &two.steady];
        assert!(one.q_a > two.q_a && one.speed < two.speed);
        let leak = |steady: &Steady| steady.residual("cylinder.leakage", Variant::Corrected);
        // What series 1 takes more is less than what leaks more.
        assert!(leak(one) - leak(two) > one.q_a - two.q_a);
    }

    #[test]
    #[ignore = "half a minute"]
    fn the_three_series_come_out_in_the_papers_order() {
        let rig = &model().rig;
        let all = series();
        let residual = |id: &str, variant| [0, 1, 2].map(|index: usize| all[index].steady.residual(id, variant) / LPM);
        // Residual, its variant, the paper's order.
        let rows = [
            ("leakage", "(4)", "cylinder.leakage", Variant::Corrected, "1 > 3 > 2"),
            ("leakage", "(4) as printed", "cylinder.leakage", Variant::Paper, "1 > 3 > 2"),
            ("orifice", "(10)", "flow_control.flow", Variant::Corrected, "3 > 1 > 2"),
            ("orifice", "(10) as printed", "flow_control.flow", Variant::Paper, "3 > 1 > 2"),
            ("opening", "(20)", "directional_valve.supply", Variant::Corrected, "2 > 1 > 3"),
            ("opening", "(18)", "directional_valve.consumer", Variant::Corrected, "2 > 1 > 3"),
            ("opening", "B to T", "directional_valve.return", Variant::Corrected, "2 > 1 > 3"),
        ];
        let mut lines = header(&["fault", "residual", "series 1", "series 2", "series 3", "order", "as set"]).to_vec();
        for (fault, name, id, variant, set) in rows {
            let values = residual(id, variant);
            let found = order(values);
            let mut cells = vec![fault.to_owned(), name.to_owned()];
            cells.extend(values.map(|value| format!("{value:.2}")));
            cells.extend([found.clone(), set.to_owned()]);
            lines.push(row(&cells));
            if variant == Variant::Corrected {
                assert_eq!(found, set, "{name}: {values:?}");
            }
        }
        page_says(SERIES, "residuals", &lines);
        // A regulating valve passes the same whatever its throttle, so the printed form ranks by flow alone.
        assert_ne!(order(residual("flow_control.flow", Variant::Paper)), "3 > 1 > 2");

        let columns = ["fault", "series", "set", "one residual", "joint fit", "95 % interval"];
        let mut lines = header(&columns).to_vec();
        for (fault, id) in FAULTS.iter().enumerate() {
            let (mut single, mut joint) = ([0.0; 3], [0.0; 3]);
            for (index, series) in all.iter().enumerate() {
                let found = series.diagnosis.faults.iter().find(|fault| fault.id == *id).unwrap();
                let unit = if fault < 2 { 1e3 } else { 1.0 };
                single[index] = sizes(&series.steady, rig)[fault] * unit;
                joint[index] = found.value;
                let [low, high] = found.ci95.map(|end| end.map_or("open".to_owned(), |end| format!("{end:.3}")));
                let truth = TRUTH[index][fault];
                lines.push(row(&[
                    format!("`{id}`"),
                    (index + 1).to_string(),
                    truth.to_string(),
                    format!("{:.3}", single[index]),
                    format!("{:.3}", joint[index]),
                    format!("{low} to {high}"),
                ]));
                assert!((joint[index] / truth - 1.0).abs() < 0.05, "{id}, series {}: {}", index + 1, joint[index]);
                // The single residual has the tolerance of its law only; 3.5 mm is where that is worst.
                let allowed = if fault == 1 { 0.25 } else { 0.05 };
                assert!((single[index] / truth - 1.0).abs() < allowed, "{id}, series {}: {}", index + 1, single[index]);
            }
            // A larger clearance is worse, a smaller orifice or opening is.
            let worst = |values: [f64; 3]| order(if fault == 0 { values } else { values.map(|value| -value) });
            let set = worst([0, 1, 2].map(|index: usize| TRUTH[index][fault]));
            assert_eq!((worst(single), worst(joint)), (set.clone(), set), "{id}");
        }
        page_says(SERIES, "sizes", &lines);
    }
}
