//! The page of a campaign.

use crate::campaign::row::{Outcome, Row};
use crate::campaign::score::{Confusion, FaultScore, Group, Scores};
use crate::campaign::statistics::Rate;
use crate::campaign::store::Finished;
use crate::campaign::{CampaignOptions, HEALTHY};
use crate::number::{rounded, text};
use crate::report::campaign as words;
use crate::report::html::{Cell, Column, Mark, Page, Scale, Section, Table};
use crate::report::plot::{Axis, Chart, Envelope, Live, Series};
use crate::report::style::Tone;

/// Wrong cases that are listed.
const LISTED: usize = 30;
/// Cases of a fault from which on its detection is drawn over its size, and cases that make a point of it.
const DRAWN: usize = 6;
const POINT: usize = 5;
/// What is left free around points, of the range.
const RIM: f64 = 0.05;
/// What an interval should hold.
const HOLDS: f64 = 0.95;

/// The page: rates, confusion, detection over size, calibration of the probabilities, estimates, wrong cases. Nothing of it
/// depends on the machine.
pub fn html(finished: &Finished) -> String {
    let (options, scores) = (&finished.options, &finished.scores);
    let mut page = Page::new(
        format!("Campaign on {}", finished.rig),
        format!(
            "{} cases on {} disturbed rigs, seed {}, disturbance {}, healthy fraction {}",
            scores.cases,
            options.rigs,
            options.seed,
            text(options.disturbance),
            text(options.healthy)
        ),
    );
    page.section(rates(scores)).section(faults(scores)).section(confusion(&scores.confusion));
    page.section(detection(&finished.cases)).section(reliability(scores)).section(estimates(&finished.cases));
    page.section(wrong(finished));
    page.html()
}

/// A rate as a number and on a scale from 0 to 1, with a stroke where it should be.
fn rate(rate: &Rate, should: Option<f64>) -> [Cell; 2] {
    let Some(share) = rate.share else { return ["-".into(), "".into()] };
    let mut marks = vec![Mark::Bar(Some(rate.low95), Some(rate.high95))];
    marks.extend(should.map(Mark::Stroke));
    marks.push(Mark::Point(share));
    let shown = words::rate(rate);
    [words::short(rate).into(), Cell::Scale(Scale { from: 0.0, to: 1.0, marks, text: shown })]
}

fn number(value: Option<f64>, unit: &str) -> Cell {
    words::number(value, unit).into()
}

fn rates(scores: &Scores) -> Section {
    let mut section = Section::new("Scores");
    let detected = words::rate(&scores.all.detected);
    let false_alarms = words::rate(&scores.all.false_alarms);
    section.notice(
        if scores.failed == 0 { Tone::Good } else { Tone::Caution },
        format!(
            "Faults detected: {detected}. False alarms: {false_alarms}. Isolated: {}.",
            words::rate(&scores.all.isolated)
        ),
    );
    let mut groups: Vec<(String, &Group)> = vec![("all cases".to_owned(), &scores.all)];
    groups.extend(scores.identifiable.as_ref().map(|group| ("identifiable at their size".to_owned(), group)));
    let counts = scores.by_count.iter().enumerate();
    let named = |count: usize| if count == 1 { "1 fault".to_owned() } else { format!("{count} faults") };
    groups.extend(counts.map(|(count, group)| (named(count), group)));
    groups.push(("onset within the record".to_owned(), &scores.midway));
    let mut rows: Vec<Vec<Cell>> = Vec::new();
    for (name, group) in groups {
        let each = [
            ("detected", &group.detected, None),
            ("false alarms", &group.false_alarms, None),
            ("isolated", &group.isolated, None),
            ("intervals that hold the truth, faults found", &group.coverage_found, Some(HOLDS)),
            ("intervals that hold the truth, all faults", &group.coverage_all, Some(HOLDS)),
        ];
        for (what, value, should) in each.into_iter().filter(|(_, value, _)| value.of > 0) {
            let mut row: Vec<Cell> = vec![name.clone().into(), what.into()];
            let [_, scale] = rate(value, should);
            row.extend([words::rate(value).into(), scale]);
            rows.push(row);
        }
    }
    section.table(Table::new(
        "Rates with their 95 % bounds; tick at the nominal rate",
        vec![Column::text("cases"), Column::text("what"), Column::number("rate", ""), Column::text("from 0 to 1")],
        rows,
    ));
    let all = &scores.all;
    section.facts(vec![
        ("cases without diagnosis".to_owned(), scores.failed.to_string()),
        ("rigs not calibrated to an adequate model".to_owned(), words::rate(&scores.inadequate_rigs)),
        ("fault combinations that reach 95 %, mean".to_owned(), words::number(all.mean_ambiguity, "")),
        ("detection delay, median".to_owned(), words::number(all.median_delay_s, " s")),
        ("detection delay, 95 % within".to_owned(), words::number(all.delay95_s, " s")),
        ("mean error, of the distance to healthy".to_owned(), words::number(all.mape_of_deviation, " %")),
        ("mean error, of the true value".to_owned(), words::number(all.mape_of_value, " %")),
    ]);
    section
}

fn faults(scores: &Scores) -> Section {
    let mut section = Section::new("Fault by fault");
    let row = |fault: &FaultScore| -> Vec<Cell> {
        let mut row: Vec<Cell> = vec![fault.id.clone().into()];
        row.extend(rate(&fault.found, None));
        row.extend(rate(&fault.coverage, Some(HOLDS)));
        let smallest = fault.found90.map_or("-".to_owned(), |found| words::found_from(&found, &fault.unit));
        row.extend([words::short(&fault.blamed).into(), number(fault.mape_of_deviation, " %"), smallest.into()]);
        row
    };
    section.table(Table::new(
        "Every fault over the cases in which it was injected; wrongly blamed over those in which it was not. Coverage: intervals that hold the truth",
        vec![
            Column::text("fault"),
            Column::number("found", ""),
            Column::text("0 to 1"),
            Column::number("coverage", ""),
            Column::text("0 to 1"),
            Column::number("false positives", ""),
            Column::number("mean error", ""),
            Column::text("found in 90 % from"),
        ],
        scores.faults.iter().map(row).collect(),
    ));
    section
}

fn confusion(confusion: &Confusion) -> Section {
    let mut section = Section::new("Confusion matrix");
    let total = |row: &[usize]| row.iter().sum::<usize>();
    let rows: Vec<usize> = (0..confusion.counts.len()).filter(|&row| total(&confusion.counts[row]) > 0).collect();
    let columns: Vec<usize> = (0..confusion.found.len())
        .filter(|&at| rows.iter().any(|&row| at == row || confusion.counts[row][at] > 0))
        .collect();
    let line = |&row: &usize| -> Vec<Cell> {
        let counts = &confusion.counts[row];
        let cell = |&at: &usize| match counts[at] {
            0 => Cell::Shade(String::new(), 0.0),
            count => Cell::Shade(count.to_string(), count as f64 / total(counts) as f64),
        };
        std::iter::once(Cell::from(confusion.injected[row].clone())).chain(columns.iter().map(cell)).collect()
    };
    let heads = columns.iter().map(|&at| Column::text(confusion.found[at].clone()));
    let mut table = Table::new(
        "One fault or none: as injected (rows), and what the most probable set took it for (columns). What never came up is left out",
        std::iter::once(Column::text("injected")).chain(heads).collect(),
        rows.iter().map(line).collect(),
    );
    table.upright = true;
    section.table(table);
    section
}

/// Share of injected faults that were found over their size.
fn detection(cases: &[Row]) -> Section {
    let mut section = Section::new("Detection over the size of the fault");
    let mut charts = Vec::new();
    for (index, fault) in cases.first().map_or(&[][..], |case| &case.faults).iter().enumerate() {
        let own = cases.iter().filter_map(|case| case.faults.get(index)).filter(|fault| fault.injected);
        let mut sizes: Vec<(f64, bool)> = own.map(|fault| (fault.size(), fault.present)).collect();
        if sizes.len() < DRAWN {
            continue;
        }
        sizes.sort_by(|a, b| a.0.total_cmp(&b.0));
        let points = sizes.chunks(sizes.len().div_ceil(sizes.len() / POINT)).map(|group| {
            let middle = group.iter().map(|(size, _)| size).sum::<f64>() / group.len() as f64;
            (middle, Rate::of(group, |(_, found)| *found))
        });
        let points: Vec<(f64, Rate)> = points.collect();
        let (least, most) = (sizes[0].0, sizes[sizes.len() - 1].0);
        let x = Axis::new("distance from healthy", &fault.unit).over(wider(least, most).0, wider(least, most).1);
        let share = points.iter().filter_map(|(size, rate)| Some((*size, rate.share?))).collect();
        let mut chart = Chart::new(
            &fault.id,
            x,
            Axis::new("found", "").over(-RIM, 1.0 + RIM),
            vec![Series::line("found", share).styled(0, 0)],
        );
        chart.series.push(
            Series::dots("each case", sizes.iter().map(|(size, found)| (*size, f64::from(u8::from(*found)))).collect())
                .styled(1, 0),
        );
        let spread = points.iter().map(|(size, rate)| (*size, rate.low95, rate.high95)).collect();
        chart.envelopes.push(Envelope { name: "95 % bounds".to_owned(), points: spread, colour: 0 });
        charts.push((chart.high(150.0), Live::new("", format!("fraction of {} found versus its size", fault.id))));
    }
    if charts.is_empty() {
        section.paragraph(format!("No fault was injected {DRAWN} times: more cases draw these curves."));
    } else {
        section.side_by_side(&charts);
    }
    section
}

/// How often the most probable set is right, over its probability.
fn reliability(scores: &Scores) -> Section {
    let mut section = Section::new("Calibration of the probabilities");
    let bins: Vec<_> = scores.reliability.bins.iter().filter(|bin| bin.right.of > 0).collect();
    let point = |bin: &&&crate::campaign::score::Bin| Some((bin.mean_probability?, bin.right.share?));
    let mut chart = Chart::new(
        "Fraction right versus stated probability",
        Axis::new("probability of the best combination", "").over(-RIM, 1.0 + RIM),
        Axis::new("fraction right", "").over(-RIM, 1.0 + RIM),
        vec![
            Series::line("as it should be", vec![(0.0, 0.0), (1.0, 1.0)]).styled(3, 1),
            Series::line("measured", bins.iter().filter_map(|bin| point(&bin)).collect()).styled(0, 0),
            Series::dots("", bins.iter().filter_map(|bin| point(&bin)).collect()).styled(0, 0),
        ],
    );
    let spread = bins.iter().filter_map(|bin| Some((bin.mean_probability?, bin.right.low95, bin.right.high95)));
    chart.envelopes.push(Envelope { name: "95 % bounds".to_owned(), points: spread.collect(), colour: 0 });
    section.chart(&chart.high(240.0), &Live::new("", "fraction right versus stated probability"));
    let rows = bins.iter().map(|bin| {
        let percent = |share: f64| text(rounded(100.0 * share, 4));
        vec![
            format!("{} to {} %", percent(bin.from), percent(bin.to)).into(),
            bin.right.of.to_string().into(),
            number(bin.mean_probability.map(|p| 100.0 * p), " %"),
            words::rate(&bin.right).into(),
        ]
    });
    section.table(Table::new(
        "Probability of the best set",
        vec![
            Column::text("stated"),
            Column::number("cases", ""),
            Column::number("mean", ""),
            Column::number("right", ""),
        ],
        rows.collect(),
    ));
    let error = scores.reliability.expected_calibration_error.map(|error| 100.0 * error);
    section.paragraph(format!("Expected calibration error: {}.", words::number(error, " %")));
    section
}

/// Estimates of the faults that were injected and found, over the truth.
fn estimates(cases: &[Row]) -> Section {
    let mut section = Section::new("Estimated against true");
    let mut charts = Vec::new();
    for (index, fault) in cases.first().map_or(&[][..], |case| &case.faults).iter().enumerate() {
        let own = || {
            let all = cases.iter().filter_map(|case| case.faults.get(index));
            all.filter(|fault| fault.injected).filter_map(|fault| Some((fault.truth, fault.value?, fault.present)))
        };
        let of = |present: bool| own().filter(|one| one.2 == present).map(|one| (one.0, one.1)).collect::<Vec<_>>();
        let truths = || own().map(|one| one.0);
        let (low, high) = (truths().fold(f64::INFINITY, f64::min), truths().fold(f64::NEG_INFINITY, f64::max));
        if low > high {
            continue;
        }
        let (from, to) = wider(low, high);
        let series = vec![
            Series::line("as it should be", vec![(low, low), (high, high)]).styled(3, 1),
            Series::dots("found", of(true)).styled(0, 0),
            Series::dots("not found", of(false)).styled(1, 0),
        ];
        let chart = Chart::new(
            &fault.id,
            Axis::new("true", &fault.unit).over(from, to),
            Axis::new("estimated", &fault.unit),
            series,
        );
        charts.push((chart.high(170.0), Live::new("", format!("estimate of {} over the truth", fault.id))));
    }
    if charts.is_empty() {
        section.paragraph("No fault was injected.");
    } else {
        section.side_by_side(&charts);
    }
    section
}

/// A range with a rim.
fn wider(low: f64, high: f64) -> (f64, f64) {
    let rim = (RIM * (high - low)).max(1e-6 * high.abs());
    (low - rim, high + rim)
}

/// The wrong cases, the surest first, each with the command that runs it again.
fn wrong(finished: &Finished) -> Section {
    let mut section = Section::new("Worst cases");
    let is_wrong = |row: &&Row| if row.is_faulty() { !row.isolated() } else { row.outcome != Outcome::Healthy };
    let mut wrong: Vec<&Row> = finished.cases.iter().filter(is_wrong).collect();
    if wrong.is_empty() {
        section.notice(Tone::Good, "No case went wrong.");
        return section;
    }
    let count = wrong.len();
    wrong.sort_by(|a, b| {
        b.top_probability.unwrap_or(1.0).total_cmp(&a.top_probability.unwrap_or(1.0)).then(a.case.cmp(&b.case))
    });
    let list = |ids: &[&str]| if ids.is_empty() { "nothing".to_owned() } else { ids.join(" + ") };
    let row = |row: &&Row| -> Vec<Cell> {
        let found = match &row.failure {
            Some(failure) => failure.replace('\n', " "),
            None => list(&row.found()),
        };
        vec![
            row.case.to_string().into(),
            words::sizes(row).into(),
            row.outcome.name().into(),
            found.into(),
            number(row.top_probability, ""),
            number(row.truth_probability, ""),
            command(finished, row.case).into(),
        ]
    };
    section.table(Table::new(
        format!(
            "{count} wrong cases, the surest first{}",
            if count > LISTED { format!("; {LISTED} of them") } else { String::new() }
        ),
        vec![
            Column::text("case"),
            Column::text("truth"),
            Column::text("verdict"),
            Column::text("found"),
            Column::number("P(best)", ""),
            Column::number("P(truth)", ""),
            Column::text("again, with its page"),
        ],
        wrong.iter().take(LISTED).map(row).collect(),
    ));
    section
}

/// The command that runs one case again.
fn command(finished: &Finished, case: usize) -> String {
    let options = &finished.options;
    let plain = CampaignOptions::new(options.cases);
    let mut command = format!("borescope campaign {} --cases {} --seed {}", finished.rig, options.cases, options.seed);
    let mut differs = |name: &str, value: String, usual: bool| {
        if !usual {
            command.push_str(&format!(" --{name} {value}"));
        }
    };
    differs("healthy", options.healthy.to_string(), options.healthy == HEALTHY);
    differs("disturbance", options.disturbance.to_string(), options.disturbance == plain.disturbance);
    differs("rigs", options.rigs.to_string(), options.rigs == plain.rigs);
    format!("{command} --case {case} --report case_{case}.html")
}
