//! A campaign as text.

use std::fmt::Write;

use crate::campaign::CampaignOptions;
use crate::campaign::row::{Outcome, Row, SURE};
use crate::campaign::score::{FaultScore, Group, Scores};
use crate::campaign::statistics::{Found, Rate};
use crate::campaign::store::Finished;
use crate::finding::argument;
use crate::number::{rounded, text};

/// Most wrong cases that are listed.
const LISTED: usize = 40;

/// The scores, what they are made of, and which cases went wrong.
pub fn write_text(finished: &Finished) -> String {
    let (options, scores) = (&finished.options, &finished.scores);
    let mut page = String::new();
    let mut line = |text: &str| {
        page.push_str(text.trim_end());
        page.push('\n');
    };
    line(&format!("{}: {} cases, seed {}", finished.rig, scores.cases, options.seed));
    line(&format!("rigs {}, disturbance {}, healthy fraction {}", options.rigs, options.disturbance, options.healthy));
    let redrawn = &scores.redrawn;
    line(&format!(
        "without diagnosis {}, cases drawn again {}, rigs drawn again {}",
        scores.failed, redrawn.cases, redrawn.rigs
    ));
    line(&format!("rigs that were not calibrated to an adequate model: {}", rate(&scores.inadequate_rigs)));
    line("");
    groups(&mut line, scores);
    line("");
    faults(&mut line, &scores.faults);
    line("");
    reliability(&mut line, scores);
    line("");
    confusion(&mut line, scores);
    line("");
    wrong(&mut line, &finished.cases);
    line("");
    let seconds = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.2} s"));
    line(&format!(
        "time per diagnosis: median {}, 95 % within {}",
        seconds(finished.time_s.median),
        seconds(finished.time_s.most95)
    ));
    line("");
    line("What the figures mean, with their sources: docs/how-to/run-a-campaign.md");
    super::table::fitted(&page)
}

/// `3 of 4, 75 % (19.4 to 99.4 %)`.
pub(super) fn rate(rate: &Rate) -> String {
    let percent = |share: f64| text(rounded(100.0 * share, 3));
    match rate.share {
        None => "none".to_owned(),
        Some(share) => format!(
            "{} of {}, {} % ({} to {} %)",
            rate.count,
            rate.of,
            percent(share),
            percent(rate.low95),
            percent(rate.high95)
        ),
    }
}

pub(super) fn short(rate: &Rate) -> String {
    rate.share.map_or("-".to_owned(), |share| format!("{} % of {}", text(rounded(100.0 * share, 3)), rate.of))
}

pub(super) fn number(value: Option<f64>, unit: &str) -> String {
    value.map_or("-".to_owned(), |value| format!("{}{unit}", text(rounded(value, 3))))
}

fn groups(line: &mut impl FnMut(&str), scores: &Scores) {
    let mut main = vec![("all cases", &scores.all)];
    main.extend(scores.identifiable.as_ref().map(|group| ("faults identifiable at their size", group)));
    for (name, group) in main {
        line(&format!("{name} (95 % bounds in brackets)"));
        let alarms = &group.false_alarms;
        let bound = alarms.share.map_or(String::new(), |_| {
            format!("; below {} % at 95 % confidence", text(rounded(100.0 * alarms.upper95, 3)))
        });
        let rows = [
            ("true detection rate", rate(&group.detected)),
            ("false alarm rate", format!("{}{bound}", rate(alarms))),
            ("isolation accuracy", rate(&group.isolated)),
            ("mean ambiguity size", number(group.mean_ambiguity, "")),
            ("detection delay, median", number(group.median_delay_s, " s")),
            ("detection delay, 95 % within", number(group.delay95_s, " s")),
            ("mean error of the deviation", number(group.mape_of_deviation, " %")),
            ("median error of the deviation", number(group.median_ape_of_deviation, " %")),
            ("mean error of the value", number(group.mape_of_value, " %")),
            ("coverage, found faults", rate(&group.coverage_found)),
            ("coverage, all faults", rate(&group.coverage_all)),
        ];
        for (what, value) in rows {
            line(&format!("  {what:<30} {value}"));
        }
        line("");
    }
    line("by number of faults             alarms            isolated          mean error  coverage, found");
    let counts = scores.by_count.iter().enumerate().map(|(count, group)| (count.to_string(), group));
    for (name, group) in counts.chain(std::iter::once(("onset within the record".to_owned(), &scores.midway))) {
        line(&row_of(&name, group));
    }
}

/// The size from which on a fault is found, and its bound, as far as sizes were drawn: beyond them a curve says nothing.
pub fn found_from(found: &Found, unit: &str) -> String {
    let [least, most] = found.drawn;
    let shown = |size: f64| text(rounded(size, 3));
    match found.size {
        size if size > most => format!("beyond {} {unit}", shown(most)),
        size if size < least => format!("below {} {unit}", shown(least)),
        size if found.upper95 > most => format!("{} {unit}", shown(size)),
        size => format!("{} {unit} (below {})", shown(size), shown(found.upper95)),
    }
}

fn row_of(name: &str, group: &Group) -> String {
    let alarms = if group.detected.of > 0 { &group.detected } else { &group.false_alarms };
    format!(
        "  {name:<29} {:<17} {:<17} {:<11} {}",
        short(alarms),
        short(&group.isolated),
        number(group.mape_of_deviation, " %"),
        short(&group.coverage_found)
    )
}

fn faults(line: &mut impl FnMut(&str), faults: &[FaultScore]) {
    line(
        "fault                           found             wrongly blamed    mean error  coverage          found in 90 % from",
    );
    for fault in faults {
        let from =
            |found: &Option<Found>, unit: &str| found.as_ref().map_or(String::new(), |found| found_from(found, unit));
        let flow = from(&fault.found90_l_min, "L/min");
        let flow = if flow.is_empty() { flow } else { format!("; {flow}") };
        line(&format!(
            "  {:<29} {:<17} {:<17} {:<11} {:<17} {}{flow}",
            fault.id,
            short(&fault.found),
            short(&fault.blamed),
            number(fault.mape_of_deviation, " %"),
            short(&fault.coverage),
            from(&fault.found90, &fault.unit),
        ));
    }
}

fn reliability(line: &mut impl FnMut(&str), scores: &Scores) {
    line("probability of the best combination     cases   mean probability   right");
    for bin in scores.reliability.bins.iter().filter(|bin| bin.right.of > 0) {
        let percent = |share: f64| text(rounded(100.0 * share, 4));
        line(&format!(
            "  {:<29} {:<7} {:<18} {}",
            format!("{} to {} %", percent(bin.from), percent(bin.to)),
            bin.right.of,
            number(bin.mean_probability.map(|p| 100.0 * p), " %"),
            rate(&bin.right)
        ));
    }
    let error = scores.reliability.expected_calibration_error.map(|error| 100.0 * error);
    line(&format!("  expected calibration error    {}", number(error, " %")));
}

/// Only what stands beside the diagonal: a matrix of all faults would not fit.
fn confusion(line: &mut impl FnMut(&str), scores: &Scores) {
    let confusion = &scores.confusion;
    line("one fault or none: the most probable combination (as injected; otherwise what was named instead)");
    for (own, (injected, counts)) in confusion.injected.iter().zip(&confusion.counts).enumerate() {
        let total: usize = counts.iter().sum();
        if total == 0 {
            continue;
        }
        let others =
            counts.iter().zip(&confusion.found).enumerate().filter(|(at, (count, _))| *at != own && **count > 0);
        let others: Vec<String> = others.map(|(_, (count, found))| format!("{found} {count}")).collect();
        line(&format!("  {injected:<29} {:<17} {}", format!("{} of {total}", counts[own]), others.join(", ")));
    }
}

fn is_wrong(row: &&Row) -> bool {
    if row.is_faulty() { !row.isolated() } else { row.outcome != Outcome::Healthy }
}

/// The command that leads further: to the first case that went wrong, alone.
pub fn next(finished: &Finished) -> String {
    let (options, rig) = (&finished.options, argument(&finished.rig));
    let Some(first) = finished.cases.iter().find(is_wrong) else { return format!("borescope diagnose {rig} RECORD") };
    let plain = CampaignOptions::new(options.cases);
    let mut command = format!("borescope campaign {rig} --cases {}", options.cases);
    let stated = [
        ("seed", options.seed.to_string(), options.seed == plain.seed),
        ("healthy", options.healthy.to_string(), options.healthy == plain.healthy),
        ("disturbance", options.disturbance.to_string(), options.disturbance == plain.disturbance),
        ("rigs", options.rigs.to_string(), options.rigs == plain.rigs),
    ];
    for (option, value, _) in stated.iter().filter(|(.., is_plain)| !is_plain) {
        command.push_str(&format!(" --{option} {value}"));
    }
    command + &format!(" --case {} --report case.html", first.case)
}

fn wrong(line: &mut impl FnMut(&str), rows: &[Row]) {
    let wrong: Vec<&Row> = rows.iter().filter(is_wrong).collect();
    line(&format!(
        "wrong cases: {}{}",
        wrong.len(),
        if wrong.len() > LISTED { format!(", the first {LISTED}:") } else { String::new() }
    ));
    let list = |ids: &[&str]| if ids.is_empty() { "nothing".to_owned() } else { ids.join(" + ") };
    for row in wrong.into_iter().take(LISTED) {
        let mut text = format!("  {:<5} {}: {}", row.case, row.outcome.name(), sizes(row));
        let _ = match &row.failure {
            Some(failure) => write!(text, "; {}", failure.replace('\n', " ")),
            None => write!(
                text,
                "; found {}; P(best) {}, P(truth) {}, {} set(s) to {} %, chi2 {}{}",
                list(&row.found()),
                number(row.top_probability, ""),
                number(row.truth_probability, ""),
                row.ambiguity.unwrap_or(0),
                100.0 * SURE,
                number(row.chi2_reduced, ""),
                match row.identifiable {
                    Some(true) => "; identifiable".to_owned(),
                    Some(false) => {
                        let rival: Vec<&str> = row.rival.iter().map(String::as_str).collect();
                        format!("; not identifiable, P(taken for {}) {}", list(&rival), number(row.mistaken, ""))
                    }
                    None => String::new(),
                }
            ),
        };
        line(&text);
    }
}

/// The injected faults with their sizes.
pub(super) fn sizes(row: &Row) -> String {
    let injected = row.faults.iter().filter(|fault| fault.injected);
    let each: Vec<String> = injected
        .map(|fault| {
            let unit = if fault.unit == "-" { String::new() } else { format!(" {}", fault.unit) };
            format!("{} {}{unit}", fault.id, text(rounded(fault.truth, 4)))
        })
        .collect();
    let onset = row.onset_s.map_or(String::new(), |onset| format!(" from {} s", text(rounded(onset, 3))));
    format!("injected {}{onset}", if each.is_empty() { "nothing".to_owned() } else { each.join(" + ") })
}

/// One case in a few lines.
pub fn case(row: &Row) -> String {
    let mut page = format!("case {} of rig {}: {}\n", row.case, row.rig, sizes(row));
    let healthy: Vec<String> = row
        .faults
        .iter()
        .filter(|fault| fault.injected)
        .map(|fault| format!("  {} healthy {} {}\n", fault.id, text(fault.healthy), fault.unit))
        .collect();
    page.push_str(&healthy.concat());
    let answer = match (&row.failure, row.is_faulty(), row.isolated(), row.outcome) {
        (Some(failure), ..) => format!("no diagnosis: {failure}"),
        (None, true, true, _) => "isolated".to_owned(),
        (None, true, false, _) => "not isolated".to_owned(),
        (None, false, _, Outcome::Healthy) => "rightly healthy".to_owned(),
        (None, false, ..) => "false alarm".to_owned(),
    };
    let _ = writeln!(page, "{answer}");
    page
}
