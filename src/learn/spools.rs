//! How spools follow their commands, asked where a model has learnt what it lacks.
//!
//! What a spool with mass does to trapped oil is left in the error of every model whose spools have none, and bends the size of
//! the effect that is found. Weights of events forgive it, so chi-square cannot ask: other dynamics of the spools are searched by
//! the error itself, measured minus model over noise, all else as in the best model of the record. All is then learnt once more.
//! Another lag is an effect, `spool-lag`, and found as such; mass and dead time are none.

use std::path::Path;

use toml_edit::{DocumentMut, Item};

use super::fitted_model::FittedModel;
use super::run::times_noise;
use crate::complaint::{Complaint, Kind, Place};
use crate::diagnosis::DynamicsReport;
use crate::diagnosis::problem::root_mean_square;
use crate::diagnosis::switching::{self, Open, beyond_noise};
use crate::diagnosis::weighed;
use crate::model::{InputSignals, Model};
use crate::number::written;
use crate::record::Record;
use crate::rig::{Rig, document};

/// Digits of a value in the rig file.
const DIGITS: usize = 4;

/// What `learn` gives of the rig as stated; where its best model shows that spools follow otherwise, what it gives of the rig with those,
/// from the values of that model.
///
/// # Errors
/// Those of `learn`, and columns that are missing.
pub(super) fn with_spools<T>(
    rig: &Rig,
    record: &Record,
    learn: impl Fn(&Rig, Option<&FittedModel>) -> Result<T, Complaint>,
    best: impl Fn(&T) -> &FittedModel,
) -> Result<T, Complaint> {
    let given = learn(rig, None)?;
    let Some(other) = otherwise(rig, record, best(&given))? else { return Ok(given) };
    let Ok(again) = learn(&other, Some(best(&given))) else {
        // What was found stands, unless it was asked to stop.
        rig.context().check()?;
        return Ok(given);
    };
    let missed = |of: &T| beyond_noise(best(of).fit.normalised);
    Ok(if missed(&again) < rig.settings().diagnosis.dynamics_left_share * missed(&given) { again } else { given })
}

/// The rig with spools that follow as a record shows at a model of it, which may have effects more; `None` where they may be as
/// stated.
///
/// # Errors
/// Columns that are missing.
fn otherwise(rig: &Rig, record: &Record, fitted: &FittedModel) -> Result<Option<Rig>, Complaint> {
    let stated = beyond_noise(fitted.fit.normalised);
    // A lag that an effect bends is that of no command as it is reshaped.
    if stated == 0.0 || !switching::changed(rig, &fitted.rig, Open::All).is_empty() {
        return Ok(None);
    }
    rig.context().stage("how spools follow");
    let measured = weighed::measured(rig, record)?;
    let fall = |other: &Rig| {
        let model = Model::new(switching::applied(&fitted.rig, &switching::values(rig, other, Open::MassAndDeadTime)));
        let drive = InputSignals::from_record(&model.rig, record).ok()?;
        let outputs = model.solve(&fitted.values, &drive, &record.time).ok()?.values;
        let missed: Vec<Option<f64>> =
            outputs.iter().zip(&measured).map(|(curve, measured)| root_mean_square(curve, measured)).collect();
        Some(1.0 - beyond_noise(times_noise(rig, &missed)) / stated)
    };
    let found = switching::searched(
        rig,
        rig,
        &fall,
        (|_: &[Rig]| true, |gain| gain > rig.settings().diagnosis.dynamics_gain_share),
        Open::MassAndDeadTime,
    );
    Ok(found.map(|(other, _)| other))
}

/// How spools follow in a fitted model otherwise than in the rig.
pub(super) fn report(rig: &Rig, fitted: &Rig) -> Vec<DynamicsReport> {
    switching::report(rig, fitted, Open::MassAndDeadTime)
}

/// The text of a rig file with what a fitted model has of its spools otherwise than the rig, in the place of what it said of them.
///
/// # Errors
/// A text that is no TOML.
pub(super) fn with_dynamics(path: &Path, text: &str, rig: &Rig, fitted: &Rig) -> Result<String, Complaint> {
    let mut document = document(path, text)?;
    for own in switching::changed(rig, fitted, Open::MassAndDeadTime) {
        let parameter = &fitted.parameters[own];
        let value = written(parameter.unit.from_si(parameter.value), DIGITS, &parameter.unit);
        let Some((component, name)) = parameter.id.rsplit_once('.') else { continue };
        let is_calibrated = rig.calibration.as_ref().is_some_and(|calibration| calibration.dynamics.contains(&own));
        let keys = match is_calibrated {
            true => ["calibration", "dynamics", &parameter.id],
            false => ["components", component, name],
        };
        put(&mut document, keys, &value).ok_or_else(|| {
            Complaint::new(Kind::Shape, format!("`{}` cannot be written into the rig file", parameter.id))
                .at(Place::file(path))
                .help(format!("write `[{}.{}]` as a table of its own", keys[0], keys[1]))
        })?;
    }
    Ok(document.to_string())
}

/// Puts a value into a table of a table; its comment stays.
fn put(document: &mut DocumentMut, [outer, inner, key]: [&str; 3], value: &str) -> Option<()> {
    let table = document.get_mut(outer)?.as_table_like_mut()?.get_mut(inner)?.as_table_like_mut()?;
    match table.get_mut(key).and_then(Item::as_value_mut) {
        Some(before) => {
            let decor = before.decor().clone();
            *before = value.into();
            *before.decor_mut() = decor;
        }
        None => {
            table.insert(key, toml_edit::value(value));
        }
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spools_that_follow_otherwise_stand_in_the_rig_file() {
        let text = include_str!("../../fixtures/telescopic/rig.toml");
        let stated = text.replacen("lag = \"8 ms\"", "lag = \"8 ms\"\ninertia_time = \"2 ms\"  # by the maker", 1);
        let path = Path::new("rig.toml");
        let rig = Rig::parse(path, stated.clone()).unwrap();
        assert_eq!(with_dynamics(path, &stated, &rig, &rig).unwrap(), stated);
        let mut other = rig.clone();
        other.set("directional_valve.dead_time", "0.5 ms").unwrap();
        other.set("directional_valve.inertia_time", "4 ms").unwrap();
        let new = with_dynamics(path, &stated, &rig, &other).unwrap();
        assert!(new.contains("\ninertia_time = \"4 ms\"  # by the maker\ndead_time = \"0.5 ms\"\n"), "{new}");
        let read = Rig::parse(path, new).unwrap();
        for id in ["dead_time", "inertia_time"].map(|name| format!("directional_valve.{name}")) {
            let of = |rig: &Rig| rig.parameters[rig.parameter(&id).unwrap()].value;
            assert_eq!(of(&read), of(&other), "{id}");
        }
    }
}
