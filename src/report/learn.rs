//! Comparison and suggestion for people.

use std::fmt;

use super::caveats::{learnt_with, left_open};
use super::diagnosis_tables::{explained, of_samples};
use super::digits::Estimate;
#[cfg(feature = "cli")]
use super::html::Table;
#[cfg(feature = "cli")]
use super::style::Tone;
use super::table::{Head, aligned, fitted};
use crate::learn::comparison::{ChannelComparison, Comparison, MisfitPlace, PresentFault};
use crate::learn::evaluated::{Conclusion, EvaluatedModel};
use crate::learn::result::{CandidateReport, EffectParameter, ScoredReport, SuggestionReport};
use crate::learn::separate::Experiment;
use crate::learn::suggest::Suggestion;
use crate::number::{before_unit, rounded, text, with_unit};

const CHANNEL_HEADS: [Head; 9] = [
    ("sensor", false),
    ("rms misfit", true),
    ("noise", true),
    ("unit", false),
    ("NRMSE fit", true),
    ("reduced chi-square", true),
    ("autocorrelation", true),
    ("correlates with", false),
    ("explained", false),
];

fn channel_row(channel: &ChannelComparison) -> Vec<String> {
    let goes = channel.goes_with.first();
    vec![
        channel.name.clone(),
        of_samples(channel.samples, text(rounded(channel.rmse, 3))),
        text(rounded(channel.noise_sigma, 3)),
        channel.unit.clone(),
        channel.fit_percent.map_or("-".to_owned(), |fit| format!("{fit:.1} %")),
        of_samples(channel.samples, format!("{:.2}", channel.chi2_reduced)),
        of_samples(channel.samples, format!("{:.2}", channel.autocorrelation)),
        goes.map_or("-".to_owned(), |goes| format!("{} ({:+.2})", goes.signal, goes.coefficient)),
        explained(channel.adequate, (channel.samples, channel.times_noise), channel.within_noise).to_owned(),
    ]
}

pub(super) const WORST_HEADS: [Head; 7] = [
    ("sensor", false),
    ("phase", false),
    ("from s", true),
    ("to s", true),
    ("rms misfit", true),
    ("unit", false),
    ("deviations", true),
];

/// How a conclusion is meant.
#[cfg(feature = "cli")]
pub(crate) fn tone(conclusion: Conclusion) -> Tone {
    match conclusion {
        Conclusion::Adequate => Tone::Good,
        Conclusion::EffectFound | Conclusion::PartlyExplained => Tone::Alert,
        Conclusion::Confounded | Conclusion::UnknownEffect => Tone::Caution,
    }
}

/// How a comparison is meant.
#[cfg(feature = "cli")]
pub(crate) fn comparison_tone(comparison: &Comparison) -> Tone {
    if comparison.adequate { Tone::Good } else { Tone::Alert }
}

/// A fault with its size.
pub(super) fn named_fault(fault: &PresentFault) -> String {
    format!("{} {}", fault.id, with_unit(rounded(fault.value, 4), &fault.unit))
}

/// An error as a multiple of the sensor noise: `6.3x`.
pub(super) fn multiple(times_noise: f64) -> String {
    format!("{}x", text(rounded(times_noise, 2)))
}

/// An error as people read it: a multiple of the sensor noise.
pub(crate) fn times(times_noise: f64) -> String {
    format!("{} the sensor noise", multiple(times_noise))
}

/// Error from which on a model that is adequate owes a word, times the sensor noise.
const ABOVE_NOISE: f64 = 1.2;

/// What is said of a model that is adequate.
pub(super) fn adequate(comparison: &Comparison) -> String {
    let error = times(comparison.times_noise);
    if comparison.times_noise > ABOVE_NOISE {
        format!(
            "ADEQUATE only within tolerance: {error} is left, which the rig file allows by the tolerance of sensors and where valves switch."
        )
    } else {
        format!("ADEQUATE: your model explains the record, {error}.")
    }
}

/// The comparison in one line: the faults that explain a record, or where its misfit is.
pub(crate) fn comparison_headline(comparison: &Comparison) -> String {
    if comparison.adequate {
        return adequate(comparison);
    }
    let misfit = format!("MISFIT: your model does not explain the record, {}", times(comparison.times_noise));
    match comparison.with_faults.as_ref().filter(|with| with.adequate) {
        None => comparison.place.as_ref().map_or(format!("{misfit}."), |place| format!("{misfit}. {}", sits(place))),
        Some(with) => {
            let faults: Vec<String> = with.faults.iter().map(named_fault).collect();
            let what = if faults.is_empty() { "parts off their data sheets".to_owned() } else { faults.join(", ") };
            format!("{misfit}; with {what} it does, {}.", times(with.times_noise))
        }
    }
}

/// How each sensor is followed, for a page.
#[cfg(feature = "cli")]
pub(super) fn channel_table(comparison: &Comparison) -> Table {
    let rows = comparison.channels.iter().map(channel_row).collect();
    Table::of("Misfit of each sensor; reduced chi-square 1 is noise and tolerance", &CHANNEL_HEADS, rows)
}

/// The worst phases of the sensors that are missed.
pub(super) fn worst_rows(comparison: &Comparison) -> Vec<Vec<String>> {
    let missed = comparison.channels.iter().filter(|channel| !channel.adequate);
    missed
        .flat_map(|channel| {
            channel.worst.iter().map(|miss| {
                vec![
                    channel.name.clone(),
                    miss.phase.clone(),
                    format!("{:.2}", miss.from_s),
                    format!("{:.2}", miss.to_s),
                    text(rounded(miss.rmse, 3)),
                    channel.unit.clone(),
                    format!("{:.1}", miss.deviations),
                ]
            })
        })
        .collect()
}

/// The comparison as a page of text.
pub fn comparison(comparison: &Comparison) -> String {
    let mut lines = vec![comparison_headline(comparison)];
    lines.push(String::new());
    lines.push(format!("rig     {}", comparison.rig));
    lines.push(format!("record  {}", comparison.record));
    let mut block = |title: &str, heads: &[Head], rows: &[Vec<String>]| {
        lines.extend([String::new(), title.to_owned()]);
        lines.extend(aligned(heads, rows));
    };
    let rows: Vec<Vec<String>> = comparison.channels.iter().map(channel_row).collect();
    block("Measured and model (reduced chi-square 1 is noise and tolerance)", &CHANNEL_HEADS, &rows);
    let rows = worst_rows(comparison);
    if !rows.is_empty() {
        block("Largest misfits (mean deviation in standard deviations; 0.8 is noise)", &WORST_HEADS, &rows);
    }
    ended(lines)
}

fn ended(lines: Vec<String>) -> String {
    fitted(&(lines.join("\n") + "\n"))
}

/// What a misfit correlates with, in words; empty where it does with nothing.
pub(super) fn goes_with(place: &MisfitPlace) -> String {
    let named = |signal: &String| if *signal == place.channel { "its own level".to_owned() } else { signal.clone() };
    place.depends_on.iter().map(named).collect::<Vec<_>>().join(", ")
}

/// Where a misfit sits, in a sentence.
pub(super) fn sits(place: &MisfitPlace) -> String {
    format!("The misfit is largest in {}.", at(place))
}

/// The same of the model that a suggestion was made for: what it misses without the effects that were found.
pub(crate) fn missed(suggestion: &SuggestionReport) -> Option<String> {
    let place = suggestion.place.as_ref()?;
    let is_found = !matches!(suggestion.conclusion, Conclusion::Adequate | Conclusion::UnknownEffect);
    let with = match suggestion.faults.as_slice() {
        [] => None,
        faults => Some(format!("with {} fitted", faults_by_name(faults))),
    };
    Some(match (is_found, with) {
        (false, None) => sits(place),
        (false, Some(with)) => format!("Your model, {with}, misses most in {}.", at(place)),
        (true, None) => format!("Without an effect your model misses most in {}.", at(place)),
        (true, Some(with)) => format!("Without an effect your model, {with}, misses most in {}.", at(place)),
    })
}

/// Where your model misses most, in a line.
#[cfg(feature = "cli")]
pub(super) fn missed_in_short(place: &MisfitPlace, (most, of): (&str, &str)) -> String {
    let goes = match goes_with(place) {
        nothing if nothing.is_empty() => String::new(),
        some => format!("; correlates with {some}"),
    };
    let MisfitPlace { channel, phase, from_s, to_s, .. } = place;
    format!("{most} is missed in {channel}{of}, {phase} from {from_s:.2} to {to_s:.2} s{goes}.")
}

fn at(place: &MisfitPlace) -> String {
    let goes = match goes_with(place) {
        nothing if nothing.is_empty() => "correlates with no measured quantity".to_owned(),
        some => format!("correlates with {some}"),
    };
    format!(
        "{} ({}), in the phase `{}` from {:.2} to {:.2} s; that {goes}",
        place.channel, place.equation, place.phase, place.from_s, place.to_s
    )
}

/// What is told of a parameter, with the digits that its interval is worth.
pub(super) fn estimate(parameter: &EffectParameter) -> Estimate {
    Estimate { value: parameter.value, ends: parameter.ci95 }
}

fn parameter(parameter: &EffectParameter) -> String {
    before_unit(estimate(parameter).value(), &parameter.unit)
}

/// The conclusion in one sentence, with the values of the effect that was found.
pub fn conclusion(suggestion: &SuggestionReport) -> String {
    let short = conclusion_in_short(suggestion);
    match (suggestion.conclusion, suggestion.candidates.first()) {
        (Conclusion::EffectFound, Some(best)) => {
            let values: Vec<String> =
                best.parameters.iter().map(|one| format!("{} = {}", one.id, parameter(one))).collect();
            format!("{short} {}.", values.join(", "))
        }
        _ => short,
    }
}

/// The conclusion in one sentence.
pub(super) fn conclusion_in_short(suggestion: &SuggestionReport) -> String {
    let best = suggestion.candidates.first();
    let records = if suggestion.check.is_some() { "both records" } else { "the record" };
    match (suggestion.conclusion, best) {
        (Conclusion::Adequate, _) if suggestion.faults.is_empty() => {
            format!("ADEQUATE: the model explains {records} within noise and tolerance.")
        }
        (Conclusion::Adequate, _) => format!(
            "ADEQUATE: the model explains {records} within noise and tolerance, with {}.",
            faults_by_name(&suggestion.faults)
        ),
        (Conclusion::EffectFound, Some(best)) => {
            format!(
                "EFFECT FOUND: the model lacks {}. It explains {records}; no other effect does so as well.{}",
                named(best),
                at_bounds(&best.parameters)
            )
        }
        (Conclusion::Confounded, Some(best)) => format!(
            "CONFOUNDED: {} explains the misfit, and {} explains it equally well; {records} cannot separate them.",
            named(best),
            best.confounded_with.join(", ")
        ),
        (Conclusion::PartlyExplained, Some(best)) => format!(
            "PARTLY EXPLAINED: {} explains much of the misfit; no effect of the library explains the rest.{}",
            named(best),
            at_bounds(&best.parameters)
        ),
        (Conclusion::UnknownEffect, Some(best)) if suggestion.worth_naming().is_some() => {
            format!("UNKNOWN EFFECT: no effect of the library explains the misfit; {} comes nearest.", best.effect)
        }
        (Conclusion::UnknownEffect, Some(_)) if suggestion.candidates.iter().any(|one| one.lowers_the_error()) => {
            "UNKNOWN EFFECT: no effect of the library explains the misfit.".to_owned()
        }
        (Conclusion::UnknownEffect, Some(_)) => {
            "UNKNOWN EFFECT: no effect of the library explains the misfit; none reduces it.".to_owned()
        }
        (_, None) => "UNKNOWN EFFECT: no effect of the library explains the misfit; none reduces it.".to_owned(),
    }
}

/// A candidate with what its effects are: `load-mass (mass coupled to the rod beyond that of the data sheet)`.
fn named(candidate: &CandidateReport) -> String {
    let each = candidate.effects.iter().map(|effect| match effect.in_words.as_str() {
        "" => effect.id.clone(),
        words => format!("{} ({words})", effect.id),
    });
    each.collect::<Vec<_>>().join(" + ")
}

/// What to make of values at the ends of their search, as a further sentence.
pub(super) fn at_bounds(parameters: &[EffectParameter]) -> String {
    let ends: Vec<&str> = parameters.iter().filter(|one| one.at_bound).map(|one| one.id.as_str()).collect();
    match ends.as_slice() {
        [] => String::new(),
        [one] => format!(" {one} is at the bound of its search: the other values hold only with it."),
        several => format!(
            " {} are at the bounds of their search: the other values hold only with them.",
            several.join(" and ")
        ),
    }
}

fn faults_by_name(faults: &[String]) -> String {
    let word = if faults.len() == 1 { "the fault" } else { "the faults" };
    format!("{word} {}", faults.join(" and "))
}

/// What would tell two rivals apart, in a sentence.
pub(super) fn experiment(experiment: &Experiment) -> String {
    let [first, second] = &experiment.between;
    let apart = format!("{:.1} standard deviations", experiment.sigma);
    if experiment.sigma < TOLD_APART {
        return format!(
            "No change of the rig's cycle that was tried separates {first} from {second}: {apart} at most."
        );
    }
    let length = if experiment.length == 1.0 {
        String::new()
    } else {
        format!(" and phases of {:.0} % of their length", 100.0 * experiment.length)
    };
    format!(
        "To separate {first} from {second}, record the rig's cycle with {} at {:.0} %{length}: they then differ by {apart}.",
        experiment.inputs.join(" and "),
        100.0 * experiment.share
    )
}

/// Standard deviations from which on two explanations are told apart.
const TOLD_APART: f64 = 5.0;

const CANDIDATE_HEADS: [Head; 6] = [
    ("effect", false),
    ("supported", false),
    ("misfit", true),
    ("on the check record", true),
    ("fall of BIC", true),
    ("confounded with", false),
];

pub(super) fn before_after(before: Option<f64>, after: Option<f64>) -> String {
    let number = |value: Option<f64>| value.map_or("-".to_owned(), |value| text(rounded(value, 4)));
    format!("{} -> {}", number(before), number(after))
}

fn candidate_row(candidate: &CandidateReport) -> Vec<String> {
    vec![
        candidate.effect.clone(),
        if candidate.supported { "yes" } else { "no" }.to_owned(),
        before_after(Some(candidate.rmse_before), Some(candidate.rmse_after)),
        before_after(candidate.check_rmse_before, candidate.check_rmse_after),
        format!("{:.1}", candidate.delta_bic),
        if candidate.confounded_with.is_empty() { "-".to_owned() } else { candidate.confounded_with.join(", ") },
    ]
}

pub(super) const PARAMETER_HEADS: [Head; 4] =
    [("parameter", false), ("estimate", true), ("95 % interval", true), ("unit", false)];

pub(super) fn parameter_row(one: &EffectParameter) -> Vec<String> {
    let shown = estimate(one);
    let interval = match one.ci95 {
        [None, None] if one.at_bound => "at the bound of its search".to_owned(),
        [None, None] => "none: a preliminary fit".to_owned(),
        _ => shown.interval(),
    };
    vec![one.id.clone(), shown.value(), interval, one.unit.clone()]
}

pub(super) const SCORED_HEADS: [Head; 5] =
    [("effect", false), ("size", false), ("smallest", true), ("unit", false), ("remark", false)];

pub(super) fn scored_row(scored: &ScoredReport) -> Vec<String> {
    let remark = match (&scored.absorbed_by, scored.onsets.first()) {
        _ if !scored.excited => "not excited".to_owned(),
        (Some(parameter), _) => format!("absorbed by {parameter}"),
        (None, Some(onset)) => format!("from {} {} on", text(rounded(onset.from, 3)), onset.unit),
        (None, None) if scored.smallest_detectable.is_none() => "a level, searched in the record".to_owned(),
        (None, None) => String::new(),
    };
    vec![
        scored.id.clone(),
        scored.parameter.clone(),
        scored.smallest_detectable.map_or("-".to_owned(), |size| text(rounded(size, 3))),
        scored.unit.clone(),
        remark,
    ]
}

/// The suggestion as a page of text.
pub fn suggestion(suggestion: &SuggestionReport) -> String {
    let mut lines = vec![conclusion(suggestion)];
    lines.extend(left_open(&suggestion.left_open));
    lines.extend(missed(suggestion));
    lines.extend(learnt_with(&suggestion.dynamics));
    lines.extend(suggestion.experiment.as_ref().map(experiment));
    lines.push(String::new());
    lines.push(format!("rig     {}", suggestion.rig));
    lines.push(format!("record  {}", suggestion.record));
    lines.extend(suggestion.check.as_ref().map(|check| format!("check   {check}")));
    if !suggestion.faults.is_empty() {
        lines.push(format!(
            "faults  {}: fitted in your model, with and without the effect",
            suggestion.faults.join(", ")
        ));
    }
    let mut block = |title: &str, heads: &[Head], rows: &[Vec<String>]| {
        lines.extend([String::new(), title.to_owned()]);
        lines.extend(aligned(heads, rows));
    };
    if !suggestion.candidates.is_empty() {
        let rows: Vec<Vec<String>> = suggestion.candidates.iter().map(candidate_row).collect();
        block(
            "Fitted (misfit, times the sensor noise, without -> with the effect; supported: improves both records by more than its parameters cost)",
            &CANDIDATE_HEADS,
            &rows,
        );
        for candidate in &suggestion.candidates {
            let rows: Vec<Vec<String>> = candidate.parameters.iter().map(parameter_row).collect();
            block(&candidate.effect, &PARAMETER_HEADS, &rows);
        }
    }
    let rows: Vec<Vec<String>> = suggestion.scored().into_iter().map(scored_row).collect();
    block("All candidates, with the smallest size that this record could show", &SCORED_HEADS, &rows);
    let warned: Vec<String> = suggestion
        .candidates
        .iter()
        .flat_map(|one| one.warnings.iter().map(|warning| format!("  {}: {warning}", one.effect)))
        .collect();
    if !warned.is_empty() {
        lines.extend([String::new(), "Caveats".to_owned()]);
        lines.extend(warned);
    }
    ended(lines)
}

/// What is missing, in one line.
impl fmt::Display for Suggestion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let best = self.judged.first();
        let id = best.map_or_else(String::new, EvaluatedModel::id);
        match self.conclusion {
            Conclusion::Adequate => f.write_str("the model explains the record within its tolerance"),
            Conclusion::EffectFound => write!(f, "the model lacks {id}"),
            Conclusion::Confounded => {
                let others = best.map_or_else(String::new, |best| best.confounded_with.join(", "));
                write!(f, "the model lacks {id}, or one that explains the records as well: {others}")
            }
            Conclusion::PartlyExplained => write!(f, "the model lacks {id} and something that no effect explains"),
            Conclusion::UnknownEffect => {
                f.write_str("the model lacks something that no effect of the library explains")
            }
        }
    }
}

impl fmt::Display for SuggestionReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&suggestion(self))
    }
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&comparison(self))
    }
}
