//! The ledger of `improve` as text, with its staircase.

use std::io::{self, Write};

use super::brief::{ErrorRow, errors, next_line, wrapped};
use super::caveats::learnt_with;
use super::learn::{PARAMETER_HEADS, at_bounds, estimate, experiment, missed_in_short, parameter_row, sits};
use super::ledger::{DeclinedReport, FaultReport, Ledger, Row};
use super::suggestion::{OWN_LAW, faults};
use super::table::aligned;
use crate::finding::argument;
use crate::learn::comparison::MisfitPlace;
use crate::learn::evaluated::Conclusion;
use crate::learn::result::EffectParameter;
use crate::learn::warning::joined;
use crate::number::before_unit;

/// Characters of the longest bar of the staircase.
const BAR: f64 = 48.0;
/// Parameters of an effect up to which they are printed one by one, of all effects together, and caveats, in the short text.
const SIZES: usize = 6;
const MOST_SIZES: usize = 4;
const WARNINGS: usize = 1;
impl Ledger {
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
        if let Some(rise) = &self.rise {
            writeln!(out, "\n{}\n{}", rise.sentence(), rise.lines(&self.rig).join("\n"))?;
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
