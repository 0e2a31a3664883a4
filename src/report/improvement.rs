//! The ledger of `improve`: as JSON (`borescope.improvement/1`) and as text with its staircase.

use std::collections::BTreeMap;
use std::io::{self, Write};

use serde::Serialize;

use super::learn::sits;
use super::number::rounded;
use crate::learn::compare::Where;
use crate::learn::improve::{Improvement, Step};
use crate::learn::suggest::Conclusion;
use crate::rig::Rig;

/// Digits of an error.
const DIGITS: usize = 5;
/// Characters of the longest bar of the staircase.
const BAR: f64 = 48.0;

/// The whole result. Outer errors are normalised by sensor noise over all channels, those of channels are in `unit`.
#[derive(Debug, Clone, Serialize)]
pub struct Ledger {
    pub schema: &'static str,
    pub rig: String,
    pub fit_record: String,
    pub check_record: String,
    pub conclusion: Conclusion,
    pub steps: Vec<Row>,
    /// What is left where something is.
    pub remaining: Option<Where>,
}

/// One row: the model with what was added.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    pub added: Option<String>,
    pub fit_rmse: f64,
    pub check_rmse: f64,
    /// Mean square of the weighted misfits on the fit record: 1 within noise and tolerance.
    pub chi2_reduced: f64,
    pub check_chi2_reduced: f64,
    pub channels: BTreeMap<String, Channel>,
    pub warnings: Vec<String>,
    /// Extensions that reached less error on the check record but make no physical sense.
    pub refused: Vec<Refused>,
}

#[derive(Debug, Clone, Serialize)]
pub struct Channel {
    pub unit: String,
    pub fit_rmse: f64,
    pub check_rmse: f64,
}

#[derive(Debug, Clone, Serialize)]
pub struct Refused {
    pub effect: String,
    pub check_rmse: f64,
    pub warnings: Vec<String>,
}

impl Ledger {
    /// From what `improve` found; `names` are the files as the user gave them: rig, fit record, check record.
    pub fn new(improvement: &Improvement, names: [String; 3]) -> Self {
        let rig = &improvement.trial.rig;
        let [rig_name, fit_record, check_record] = names;
        Self {
            schema: "borescope.improvement/1",
            rig: rig_name,
            fit_record,
            check_record,
            conclusion: improvement.conclusion,
            steps: improvement.steps.iter().map(|step| row(rig, step)).collect(),
            remaining: improvement.rest.clone(),
        }
    }

    /// The conclusion in one sentence.
    pub fn headline(&self) -> &'static str {
        match self.conclusion {
            Conclusion::Adequate => "ADEQUATE: the model as given explains both records; nothing to add.",
            Conclusion::EffectFound => "EFFECT FOUND: with what was added the model explains both records.",
            Conclusion::Confounded => "CONFOUNDED: what was added explains the records, and so do others.",
            Conclusion::UnknownEffect => "UNKNOWN EFFECT: no law of the library explains all that is missed.",
        }
    }

    /// Table and staircase.
    ///
    /// # Errors
    /// What `out` gives.
    pub fn write_text(&self, out: &mut dyn Write) -> io::Result<()> {
        let conclusion = self.headline();
        writeln!(
            out,
            "{conclusion}\n\nrig    {}\nfit    {}\ncheck  {}\n",
            self.rig, self.fit_record, self.check_record
        )?;
        writeln!(out, "Errors, normalised by sensor noise over all channels")?;
        let name = Row::name;
        let width = self.steps.iter().map(|row| name(row).chars().count()).max().unwrap_or(0).max(8);
        writeln!(
            out,
            "  {:width$}  {:>8}  {:>8}  {:>12}  {:>12}",
            "model", "fit", "check", "chi2 (fit)", "chi2 (check)"
        )?;
        for row in &self.steps {
            writeln!(
                out,
                "  {:width$}  {:>8.3}  {:>8.3}  {:>12.3}  {:>12.3}",
                name(row),
                row.fit_rmse,
                row.check_rmse,
                row.chi2_reduced,
                row.check_chi2_reduced
            )?;
        }
        writeln!(out, "\nCheck error of each model, 1 at the noise of the sensors")?;
        let most = self.steps.iter().map(|row| row.check_rmse).fold(1.0, f64::max);
        for row in &self.steps {
            let bar = "#".repeat(((row.check_rmse / most * BAR).round() as usize).max(1));
            writeln!(out, "  {:width$}  {bar} {:.3}", name(row), row.check_rmse)?;
        }
        writeln!(out, "\nError of each channel on the check record, first and last model")?;
        if let (Some(first), Some(last)) = (self.steps.first(), self.steps.last()) {
            for (name, before) in &first.channels {
                let after = last.channels.get(name).map_or(f64::NAN, |channel| channel.check_rmse);
                writeln!(out, "  {name:10}  {:>10}  {:>10}  {}", before.check_rmse, after, before.unit)?;
            }
        }
        for row in &self.steps {
            for warning in &row.warnings {
                writeln!(out, "\nwarning, {}: {warning}", name(row))?;
            }
            for refused in &row.refused {
                let why = refused.warnings.join("; ");
                writeln!(out, "\nrefused, {}: check error {:.3}, but {why}", refused.effect, refused.check_rmse)?;
            }
        }
        if let Some(rest) = &self.remaining {
            writeln!(out, "\n{}", left(rest))?;
        }
        Ok(())
    }
}

/// What is left unexplained, in words.
pub fn left(rest: &Where) -> String {
    format!("Left unexplained: {}", sits(rest))
}

impl Row {
    /// What the model of the row is called.
    pub fn name(&self) -> String {
        self.added.as_ref().map_or("as given".to_owned(), |added| format!("+ {added}"))
    }
}

fn row(rig: &Rig, step: &Step) -> Row {
    let channels = rig.sensors.iter().enumerate().map(|(index, sensor)| {
        let unit = rig.sensor_unit(sensor);
        let shown = |si: f64| rounded(unit.difference_from_si(si), DIGITS);
        let channel = Channel {
            unit: unit.symbol.clone(),
            fit_rmse: shown(step.fit.rmse[index]),
            check_rmse: shown(step.check.rmse[index]),
        };
        (sensor.name.clone(), channel)
    });
    let refused = step.refused.iter().map(|(effect, run, warnings)| Refused {
        effect: effect.clone(),
        check_rmse: rounded(run.normalised, DIGITS),
        warnings: warnings.clone(),
    });
    Row {
        added: step.added.clone(),
        fit_rmse: rounded(step.fit.normalised, DIGITS),
        check_rmse: rounded(step.check.normalised, DIGITS),
        chi2_reduced: rounded(step.fit.chi2, DIGITS),
        check_chi2_reduced: rounded(step.check.chi2, DIGITS),
        channels: channels.collect(),
        warnings: step.warnings.clone(),
        refused: refused.collect(),
    }
}
