//! The residuals on records that another, more detailed simulator wrote, which stand beside the project.

use std::path::{Path, PathBuf};

use borescope::Record;
use borescope::Rig;
use borescope::internals::model::InputSignals;
use borescope::internals::residual::{Detection, ResidualReport, detect};

const RECORDS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/records");

fn reports(name: &str) -> Vec<ResidualReport> {
    let path: PathBuf = Path::new(RECORDS).join(format!("{name}.csv"));
    let rig = Rig::read("fixtures/telescopic/rig.toml").unwrap_or_else(|complaint| panic!("{complaint}"));
    let record = Record::read(path).unwrap_or_else(|complaint| panic!("{complaint}"));
    let drive = InputSignals::from_record(&rig, &record).unwrap_or_else(|complaint| panic!("{complaint}"));
    let reports = detect(&rig, &record, &drive, &Detection::default()).unwrap();
    println!("{name}: {:.1} s", record.time.last().unwrap());
    for report in &reports {
        println!(
            "  {:28} {:5} {:>10.4} +- {:<8.4} tol {:<8.4} {:6} {} {:>8.3} {:>8.3} {:7} {} {}",
            report.id,
            report.equation,
            report.mean.unwrap_or(f64::NAN),
            report.sigma.unwrap_or(f64::NAN),
            report.tolerance.unwrap_or(f64::NAN),
            report.unit,
            if report.fired { "FIRED" } else { "  -  " },
            report.alarm_at_s.unwrap_or(f64::NAN),
            report.onset_s.unwrap_or(f64::NAN),
            report.phase.unwrap_or("-"),
            report.direction.map_or(String::new(), |direction| format!("{direction:?}")),
            report.windows
        );
        for phase in &report.phases {
            let (mean, sigma, tolerance) = (phase.mean, phase.sigma, phase.tolerance);
            println!("    {:6} {mean:>10.4} +- {sigma:<8.4} tol {tolerance:<8.4} {}", phase.phase, phase.windows);
        }
    }
    reports
}

fn fired(reports: &[ResidualReport]) -> Vec<&str> {
    reports.iter().filter(|report| report.fired).map(|report| report.id.as_str()).collect()
}

fn mean(reports: &[ResidualReport], id: &str) -> f64 {
    reports.iter().find(|report| report.id == id).and_then(|report| report.mean).unwrap()
}

#[test]
#[ignore = "needs ../shared/records"]
fn a_healthy_rig_is_called_healthy() {
    for name in ["healthy_1", "healthy_2", "healthy_3"] {
        assert_eq!(fired(&reports(name)), Vec::<&str>::new(), "{name}");
    }
}

#[test]
#[ignore = "needs ../shared/records"]
fn a_leak_is_seen_at_the_cylinder_only() {
    let reports = reports("leak_020");
    assert_eq!(fired(&reports), ["cylinder.leakage", "cylinder.flow_A", "cylinder.flow_B"]);
}

#[test]
#[ignore = "needs ../shared/records"]
fn a_blocked_throttle_is_seen_at_the_flow_control_valve_only() {
    let reports = reports("blocked_16");
    assert_eq!(fired(&reports), ["flow_control.flow"]);
}

#[test]
#[ignore = "needs ../shared/records"]
fn a_lost_opening_is_seen_at_the_directional_valve_only() {
    let reports = reports("opening_040");
    assert_eq!(fired(&reports), ["directional_valve.consumer", "directional_valve.supply", "directional_valve.return"]);
}

#[test]
#[ignore = "needs ../shared/records"]
fn three_faults_at_once_are_ranked_as_in_the_paper() {
    let series = ["series_1", "series_2", "series_3"].map(reports);
    for (index, reports) in series.iter().enumerate() {
        for id in ["cylinder.leakage", "directional_valve.supply", "directional_valve.return"] {
            assert!(fired(reports).contains(&id), "{id}");
        }
        // 3.5 mm at 0.4 bar is no proof of a fault while the laminar start of the orifice is only roughly known.
        assert!(index == 1 || fired(reports).contains(&"flow_control.flow"));
    }
    let of = |id| [0, 1, 2].map(|index| mean(&series[index], id));
    let [one, two, three] = of("directional_valve.supply");
    assert!(two > one && one > three, "opening: series 2 worst, series 3 lightest: {one} {two} {three}");
    let [one, two, three] = of("flow_control.flow");
    assert!(three > one && one > two, "orifice: series 3 worst, series 2 lightest: {one} {two} {three}");
    let [one, two, three] = of("cylinder.leakage");
    assert!(one > three && three > two, "leakage: series 1 worst, series 2 smallest: {one} {two} {three}");
}

#[test]
#[ignore = "needs ../shared/records"]
fn a_throttle_of_three_and_a_half_millimetres_stands_out_of_the_noise_but_not_of_the_tolerance() {
    let reports = reports("series_2");
    let orifice = reports.iter().find(|report| report.id == "flow_control.flow").unwrap();
    let (mean, sigma, tolerance) = (orifice.mean.unwrap(), orifice.sigma.unwrap(), orifice.tolerance.unwrap());
    println!("{mean:.3} L/min: {:.1} deviations of noise, {:.2} of tolerance", mean / sigma, mean / tolerance);
    assert!(mean > 20.0 * sigma, "{mean} +- {sigma}");
    // What is open is where the laminar start of the orifice ends; a better known transition pressure would settle it.
    assert_eq!(orifice.fired, mean > Detection::default().coverage * tolerance);
}
