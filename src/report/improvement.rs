//! The ledger of `improve`: as JSON (`borescope.improvement/1`) and as text with its staircase.

use std::collections::BTreeMap;
use std::io::{self, Write};

use serde::Serialize;

use super::brief::{ErrorRow, errors, next_line, wrapped};
use super::caveats::learnt_with;
use super::digits::plus_minus;
use super::learn::{PARAMETER_HEADS, at_bounds, estimate, experiment, missed_in_short, multiple, parameter_row, sits};
use super::suggestion::{OWN_LAW, faults};
use super::table::aligned;
use super::unknown::Rise;
use crate::diagnosis::DynamicsReport;
use crate::finding::argument;
use crate::learn::comparison::MisfitPlace;
use crate::learn::evaluated::Conclusion;
use crate::learn::improve::{Declined, Improvement, ImprovementStep};
use crate::learn::result::{EffectParameter, parameters};
use crate::learn::separate::Experiment;
use crate::learn::warning::{Warning, joined};
use crate::number::{before_unit, rounded, text};
use crate::rig::Rig;

/// Digits of an error.
const DIGITS: usize = 5;
/// Characters of the longest bar of the staircase.
const BAR: f64 = 48.0;
/// Parameters of an effect up to which they are printed one by one, of all effects together, and caveats, in the short text.
const SIZES: usize = 6;
const MOST_SIZES: usize = 4;
const WARNINGS: usize = 1;

/// The whole result. Outer errors are normalised by sensor noise over all channels, those of channels are in `unit`.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Ledger {
    pub schema: &'static str,
    /// The rig file, as the user named it.
    pub rig: String,
    /// The fit record, as the user named it.
    pub fit_record: String,
    /// The check record, as the user named it.
    pub check_record: String,
    /// Whether the best one explains both records, or what is missing still.
    pub conclusion: Conclusion,
    /// The models, from yours to the best.
    pub steps: Vec<Row>,
    /// Faults that are fitted in the model of the first row; named beside it, since without them its error is another.
    #[serde(skip)]
    pub first_faults: Vec<String>,
    /// What a curve without a formula says, and the formula for the rig file.
    #[serde(skip)]
    pub rise: Option<Rise>,
    /// How spools follow their commands, where the fit record asks for other than the rig file has; the new rig file has it.
    pub dynamics: Vec<DynamicsReport>,
    /// What was added, as fitted in the end.
    pub effects: Vec<EffectReport>,
    /// Faults with which the model at the end explains the fit record; they are not in the new rig file.
    pub faults: Vec<FaultReport>,
    /// What explains the records alike, where several do, and what would tell the first of these from the second.
    pub alike: Vec<String>,
    /// What would tell rivals apart; `null` where there are none.
    pub experiment: Option<Experiment>,
    /// The best explanation where none was worth to be added.
    pub declined: Option<DeclinedReport>,
    /// What is left where something is.
    pub remaining: Option<MisfitPlace>,
}

/// An effect with its parameters.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct EffectReport {
    /// As rig files and programs know it.
    pub id: String,
    /// As they were fitted in the end.
    pub parameters: Vec<EffectParameter>,
}

/// What would have explained the records best and was not added, with its errors, times the sensor noise.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct DeclinedReport {
    /// Effect and place; of several all, with ` + ` between.
    pub effect: String,
    /// Error on the fit record, times the sensor noise.
    pub fit_rmse: f64,
    /// Error on the check record, times the sensor noise.
    pub check_rmse: f64,
    /// Share by which an addition has to lower what is missed of the fit record beyond noise.
    pub asked_of_fit: f64,
    /// Share by which it has to lower the error of the check record.
    pub asked_of_check: f64,
}

impl DeclinedReport {
    fn of(declined: &Declined) -> Self {
        Self {
            effect: declined.id.clone(),
            fit_rmse: rounded(declined.model.fit.normalised, DIGITS),
            check_rmse: rounded(declined.check.normalised, DIGITS),
            asked_of_fit: declined.asked.0,
            asked_of_check: declined.asked.1,
        }
    }

    /// What it would give, and what it would have had to.
    pub fn sentence(&self) -> String {
        let percent = |share: f64| text(rounded(100.0 * share, 3));
        format!(
            "Not added: {}, with which the error is {} on the fit record and {} on the check record; it would have to lower the first by {} % \
             of what is beyond noise and the second by {} %.",
            self.effect,
            multiple(self.fit_rmse),
            multiple(self.check_rmse),
            percent(self.asked_of_fit),
            percent(self.asked_of_check)
        )
    }
}

/// A fault that was fitted along, in `unit`, with one standard deviation.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct FaultReport {
    /// As rig files and programs know it.
    pub id: String,
    /// Estimate, in `unit`.
    pub value: f64,
    /// One standard deviation, in `unit`.
    pub sigma: f64,
    /// Unit of the numbers beside it.
    pub unit: String,
}

impl FaultReport {
    fn text(&self) -> String {
        format!("{} {}", self.id, before_unit(plus_minus(self.value, self.sigma), &self.unit))
    }
}

/// One row: the model with what was added.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Row {
    /// The effect that was added; `null` of the model as it was given.
    pub added: Option<String>,
    /// Error on the fit record, times the sensor noise.
    pub fit_rmse: f64,
    /// Error on the check record, times the sensor noise.
    pub check_rmse: f64,
    /// Mean square of the weighted misfits on the fit record: 1 within noise and tolerance.
    pub chi2_reduced: f64,
    /// Mean square of the weighted misfit of the check record.
    pub check_chi2_reduced: f64,
    /// Sensor by sensor.
    pub channels: BTreeMap<String, Channel>,
    /// Caveats, in words.
    #[cfg_attr(feature = "internals", schemars(with = "Vec<String>"))]
    pub warnings: Vec<Warning>,
    /// Extensions that reached less error on the check record but make no physical sense.
    pub refused: Vec<Refused>,
}

#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Channel {
    /// Unit of the numbers beside it.
    pub unit: String,
    /// Error on the fit record, times the sensor noise.
    pub fit_rmse: f64,
    /// Error on the check record, times the sensor noise.
    pub check_rmse: f64,
}

#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "internals", derive(schemars::JsonSchema))]
pub struct Refused {
    /// Effect and place; of several all, with ` + ` between.
    pub effect: String,
    /// Error on the check record, times the sensor noise.
    pub check_rmse: f64,
    /// Caveats, in words.
    #[cfg_attr(feature = "internals", schemars(with = "Vec<String>"))]
    pub warnings: Vec<Warning>,
}

impl Ledger {
    /// From what `improve` found; `names` are the files as the user gave them: rig, fit record, check record.
    pub fn new(improvement: &Improvement, names: [String; 3]) -> Self {
        let Improvement { given, trial, .. } = improvement;
        let rig = &trial.rig;
        let added = rig.effects.iter().filter(|effect| given.rig.effects.iter().all(|old| old.id != effect.id));
        let fault = |fault: usize| {
            let index = rig.faults[fault].parameter;
            let parameter = &rig.parameters[index];
            let sigma = trial.sigmas.get(&index).copied().unwrap_or(0.0);
            FaultReport {
                id: parameter.id.clone(),
                value: rounded(parameter.unit.from_si(trial.values[index]), DIGITS),
                sigma: rounded(parameter.unit.difference_from_si(sigma), DIGITS),
                unit: parameter.unit.symbol.clone(),
            }
        };
        let first_faults =
            given.set.iter().map(|fault| given.rig.parameters[given.rig.faults[fault].parameter].id.clone());
        let [rig_name, fit_record, check_record] = names;
        Self {
            schema: "borescope.improvement/1",
            rig: rig_name,
            fit_record,
            check_record,
            conclusion: improvement.conclusion,
            first_faults: first_faults.collect(),
            rise: Rise::of(trial).or_else(|| Rise::of(&improvement.declined.as_ref()?.model)),
            steps: improvement.steps.iter().map(|step| row(rig, step)).collect(),
            dynamics: improvement.dynamics.clone(),
            effects: added
                .map(|effect| EffectReport { id: effect.id.clone(), parameters: parameters(trial, &effect.id) })
                .collect(),
            faults: trial.set.iter().map(fault).collect(),
            alike: improvement.alike.clone(),
            experiment: improvement
                .experiment
                .clone()
                .map(|experiment| Experiment { sigma: rounded(experiment.sigma, DIGITS), ..experiment }),
            declined: improvement.declined.as_ref().map(DeclinedReport::of),
            remaining: improvement.rest.clone(),
        }
    }

    /// The conclusion in a sentence or two.
    pub fn headline(&self) -> String {
        let faults: Vec<String> = self.faults.iter().map(FaultReport::text).collect();
        let with = if faults.is_empty() { String::new() } else { format!(", with {}", faults.join(" and ")) };
        let all: Vec<EffectParameter> = self.effects.iter().flat_map(|effect| effect.parameters.clone()).collect();
        let ends = at_bounds(&all);
        match (self.conclusion, self.alike.split_first()) {
            (Conclusion::Adequate, _) if !self.dynamics.is_empty() => {
                format!(
                    "ADEQUATE: with spools that follow otherwise your model explains both records{with}; no effect is missing."
                )
            }
            (Conclusion::Adequate, _) => {
                format!("ADEQUATE: your model explains both records{with}; nothing to add.")
            }
            (Conclusion::EffectFound, _) => {
                format!("EFFECT FOUND: with the added effects the model explains both records{with}.{ends}")
            }
            (Conclusion::Confounded, Some((first, others))) if !others.is_empty() => {
                let added = if self.effects.is_empty() { "; nothing is added" } else { "" };
                format!(
                    "CONFOUNDED: {first} explains the records, and {} explains them equally well{added}.{ends}",
                    others.join(", ")
                )
            }
            (Conclusion::Confounded, _) => {
                format!("CONFOUNDED: the added effects explain the records, and so do others.{ends}")
            }
            (Conclusion::PartlyExplained, _) => {
                let rest = "no effect of the library explains the rest";
                format!("PARTLY EXPLAINED: the added effects explain much of the misfit{with}; {rest}.{ends}")
            }
            (Conclusion::UnknownEffect, _) => {
                let added =
                    if self.effects.is_empty() { "" } else { " What was added may stand in for what is missing." };
                format!("UNKNOWN EFFECT: no effect of the library explains the whole misfit{with}.{ends}{added}")
            }
        }
    }

    /// What the new rig file does not have of what was fitted.
    pub fn not_written(&self) -> &'static str {
        "The new rig file has the effects, and how spools follow where the record asks for it. Faults and uncertain data-sheet values are unchanged in it and are fitted to each \
         record again; `calibrate` writes their values from healthy records, for `simulate`."
    }

    /// The ledger in a few lines, no wider than a terminal: the verdict first, the fall of the error, the next command last.
    /// `new` is the file that was written.
    pub fn brief(&self, new: &str) -> String {
        let mut lines = wrapped(&self.headline(), "  ");
        lines.push(String::new());
        let row = |row: &Row| ErrorRow { name: self.name(row), fit: row.fit_rmse, check: Some(row.check_rmse) };
        lines.extend(errors(&self.steps.iter().map(row).collect::<Vec<_>>()));
        lines.extend(self.several_faults().into_iter().flat_map(|words| wrapped(&words, "  ")));
        lines.push(String::new());
        let all: Vec<&EffectParameter> = self.effects.iter().flat_map(|effect| &effect.parameters).collect();
        // A curve has twenty values; the page draws it.
        let few = self.effects.iter().filter(|effect| effect.parameters.len() <= SIZES);
        let sizes: Vec<&EffectParameter> = few.flat_map(|effect| &effect.parameters).collect();
        lines.extend(sizes.iter().take(MOST_SIZES).flat_map(|one| {
            let shown = estimate(one);
            let interval = if one.ci95 == [None, None] { String::new() } else { format!(" ({})", shown.interval()) };
            wrapped(&format!("{} {}{interval}", one.id, before_unit(shown.value(), &one.unit)), "    ")
        }));
        if sizes.len() > MOST_SIZES {
            lines.push(format!("and {} more values", sizes.len() - MOST_SIZES));
        }
        lines.extend(learnt_with(&self.dynamics).into_iter().flat_map(|words| wrapped(&words, "  ")));
        let curves = self.effects.iter().filter(|effect| effect.parameters.len() > SIZES);
        lines.extend(curves.map(|curve| format!("{}: a curve of {} values", curve.id, curve.parameters.len())));
        if let Some(rise) = &self.rise {
            lines.extend(wrapped(&rise.sentence(), "  "));
            lines.extend(rise.lines(&self.rig));
        }
        lines.extend(self.declined.iter().flat_map(|declined| wrapped(&declined.sentence(), "  ")));
        lines.extend(self.caveats().take(WARNINGS).flat_map(|caveat| wrapped(&caveat, "  ")));
        lines.extend(self.experiment.as_ref().map(experiment).into_iter().flat_map(|words| wrapped(&words, "  ")));
        let remaining = self.remaining.as_ref().map(|place| missed_in_short(place, ("Most of the rest", "")));
        lines.extend(remaining.into_iter().flat_map(|words| wrapped(&words, "  ")));
        if self.conclusion == Conclusion::UnknownEffect && self.rise.is_none() {
            lines.extend(wrapped(OWN_LAW, "  "));
        }
        let (rig, file) = (argument(&self.rig), argument(new));
        let what = if !all.is_empty() {
            let spools = if self.dynamics.is_empty() { "" } else { " and the spools" };
            format!("{file} has the effects{spools}; a fault belongs to its record.")
        } else if self.dynamics.is_empty() {
            format!("{file} is a copy of {rig}: no effect was added.")
        } else {
            format!("{file} has the spools as the record shows them; no effect was added.")
        };
        lines.extend(wrapped(&what, "  "));
        lines.push("`--all` shows every sensor, chi-square, caveats and what was refused.".to_owned());
        lines.push(next_line(&self.next(new)));
        lines.join("\n") + "\n"
    }

    /// The names of the faults of the first row, where its name gives but their number.
    fn several_faults(&self) -> Option<String> {
        let gone =
            if self.faults.is_empty() && !self.effects.is_empty() { "; with what was added none is left" } else { "" };
        (self.first_faults.len() > 1).then(|| format!("Faults of your model: {}{gone}.", self.first_faults.join(", ")))
    }

    /// What speaks against what was added, in the order in which it was.
    pub fn caveats(&self) -> impl Iterator<Item = String> + '_ {
        self.steps.iter().flat_map(|row| &row.warnings).map(|warning| format!("Caveat: {warning}."))
    }

    /// The command that leads further; `new` is the file that was written.
    pub fn next(&self, new: &str) -> String {
        let (rig, new, check) = (argument(&self.rig), argument(new), argument(&self.check_record));
        match (self.effects.is_empty(), self.dynamics.is_empty()) {
            (false, _) => format!("borescope compare {new} {check} --before {rig}"),
            (true, true) => format!("borescope diagnose {rig} {check}"),
            (true, false) => format!("borescope diagnose {new} {check}"),
        }
    }

    /// What the model of a row is called; of the first with the faults that are fitted in it.
    pub fn name(&self, row: &Row) -> String {
        if row.added.is_some() {
            return row.name();
        }
        let with = faults(&self.first_faults);
        let with = if self.first_faults.is_empty() { String::new() } else { format!(", with {with}") };
        format!("{}{with}", row.name())
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
        writeln!(out, "Error over all sensors, times the sensor noise")?;
        let name = |row: &Row| self.name(row);
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
        writeln!(out, "\nImprovement per effect: check error, times the sensor noise")?;
        let most = self.steps.iter().map(|row| row.check_rmse).fold(1.0, f64::max);
        for row in &self.steps {
            let bar = "#".repeat(((row.check_rmse / most * BAR).round() as usize).max(1));
            writeln!(out, "  {:width$}  {bar} {:.3}", name(row), row.check_rmse)?;
        }
        for effect in &self.effects {
            let rows: Vec<Vec<String>> = effect.parameters.iter().map(parameter_row).collect();
            writeln!(out, "\n{}", effect.id)?;
            for line in aligned(&PARAMETER_HEADS, &rows) {
                writeln!(out, "{line}")?;
            }
        }
        if !self.faults.is_empty() {
            let faults: Vec<String> = self.faults.iter().map(FaultReport::text).collect();
            writeln!(out, "\nFaults on the fit record (one standard deviation)\n  {}", faults.join("\n  "))?;
        }
        writeln!(out, "\nError of each sensor on the check record, first and last model")?;
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
                let why = joined(&refused.warnings);
                writeln!(out, "\nrefused, {}: check error {:.3}, but {why}", refused.effect, refused.check_rmse)?;
            }
        }
        if let Some(spools) = learnt_with(&self.dynamics) {
            writeln!(out, "\n{spools}")?;
        }
        if let Some(apart) = &self.experiment {
            writeln!(out, "\n{}", experiment(apart))?;
        }
        for words in self.several_faults().into_iter().chain(self.declined.iter().map(DeclinedReport::sentence)) {
            writeln!(out, "\n{words}")?;
        }
        if let Some(rest) = &self.remaining {
            writeln!(out, "\n{}", left(rest))?;
        }
        if !self.effects.is_empty() {
            writeln!(out, "\n{}", self.not_written())?;
        }
        Ok(())
    }
}

/// What is left unexplained, in words.
pub fn left(rest: &MisfitPlace) -> String {
    format!("Left unexplained: {}", sits(rest))
}

impl Row {
    /// What the model of the row is called.
    pub fn name(&self) -> String {
        self.added.as_ref().map_or("your model".to_owned(), |added| format!("+ {added}"))
    }
}

fn row(rig: &Rig, step: &ImprovementStep) -> Row {
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
