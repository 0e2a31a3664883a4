//! What was fitted, for those who know lmfit: estimates, standard errors, correlation, profiles.

use crate::support::command::borescope;

use serde_json::Value;

#[test]
fn a_diagnosis_has_standard_errors_their_correlation_and_profiles() {
    let ran =
        borescope(["diagnose", "fixtures/telescopic/rig.toml", "fixtures/telescopic/leak_020.csv", "--format=json"]);
    let diagnosis: Value = serde_json::from_str(&ran.out).unwrap();
    let fit = &diagnosis["fit"];
    let parameters = fit["parameters"].as_array().unwrap();
    let correlation: Vec<Vec<f64>> = serde_json::from_value(fit["correlation"].clone()).unwrap();
    assert_eq!(correlation.len(), parameters.len());
    for (row, shares) in correlation.iter().enumerate() {
        assert_eq!(shares.len(), parameters.len());
        assert!((shares[row] - 1.0).abs() < 1e-6, "{shares:?}");
        for (column, share) in shares.iter().enumerate() {
            assert!(share.abs() <= 1.0 && (share - correlation[column][row]).abs() < 1e-9, "{row} {column}: {share}");
        }
    }
    let faults: Vec<&Value> = parameters.iter().filter(|one| one["fault"] == true).collect();
    assert_eq!(faults.len(), 1, "{faults:?}");
    assert_eq!(faults[0]["id"], "cylinder.clearance");
    let number = |value: &Value| value.as_f64().unwrap();
    let found = &diagnosis["faults"].as_array().unwrap()[0];
    assert_eq!(found["id"], "cylinder.clearance");
    assert!((number(&faults[0]["value"]) - number(&found["value"])).abs() < 1e-4);
    // The interval allows for misfits that are correlated, so it is no narrower than that of white ones.
    let width = number(&found["ci95"][1]) - number(&found["ci95"][0]);
    let error = number(&faults[0]["standard_error"]);
    assert!(error > 0.0 && width > 0.9 * 2.0 * 1.96 * error, "{width} {error}");
    let profile = &fit["profiles"].as_array().unwrap()[0];
    assert_eq!(profile["id"], "cylinder.clearance");
    let points: Vec<[f64; 2]> = serde_json::from_value(profile["points"].clone()).unwrap();
    let rises = || points.iter().map(|point| point[1]);
    assert!(rises().fold(f64::INFINITY, f64::min) == 0.0 && rises().fold(0.0, f64::max) > 3.8, "{points:?}");
}
