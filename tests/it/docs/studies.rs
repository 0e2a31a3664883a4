//! The tables of rates and of the campaign in the book say what the studies wrote last, in `fixtures/studies`.

use borescope::internals::campaign::statistics::{lower, upper};
use borescope::internals::settings::Settings;

use crate::support::page;
use crate::support::study::{Changed, Table};

#[test]
fn the_rates_of_learning_are_those_of_the_study() {
    let table = Table::read("fixtures/studies/rates.csv");
    let mut text = format!("| {} |\n|{}\n", table.columns.join(" | "), "---|".repeat(table.columns.len()));
    let (mut shown, mut found) = (0, 0);
    for (effect, counts) in &table.rows {
        let [cases, alone, class, .., small] = counts[..] else { panic!("{effect}: {counts:?}") };
        assert_eq!(cases, counts[1..].iter().sum::<usize>(), "{effect}");
        (shown, found) = (shown + cases - small, found + alone + class);
        let cells: Vec<String> =
            counts.iter().map(|count| if *count == 0 { String::new() } else { count.to_string() }).collect();
        text += &format!("| `{effect}` | {} |\n", cells.join(" | "));
    }
    let percent = 100.0 * found as f64 / shown as f64;
    let rate = |counts: &[usize]| (counts[1] + counts[2]) as f64 / (counts[0] - counts[7]) as f64;
    let (least, counts) =
        table.rows.iter().min_by(|(_, a), (_, b)| rate(a).total_cmp(&rate(b))).expect("there are effects");
    text += &format!(
        "\nSo of {shown} cases that the records could show {found} were found, {percent:.0} %; the effect that is found least is \
         `{least}`, {} of {}.\n",
        counts[1] + counts[2],
        counts[0] - counts[7]
    );
    page::says("docs/theory/missing-physics.md", "rates", &text);
    let row = format!(
        "| {shown} records that hide one of {} effects, from an independent simulator | {percent:.0} % identified, ",
        table.rows.len()
    );
    assert!(std::fs::read_to_string("README.md").unwrap().contains(&row), "README.md does not have: {row}");
}

#[test]
fn the_scores_of_the_campaign_are_those_of_the_study() {
    let table = Table::read("fixtures/studies/campaign.csv");
    let mut text = String::from("| score | measured | 95 % bounds |\n|---|---|---|\n");
    for (score, counts) in &table.rows {
        let [count, of] = counts[..] else { panic!("{score}: {counts:?}") };
        let share = 100.0 * count as f64 / of as f64;
        let (measured, bounds) = if count == 0 {
            (format!("0 of {of}"), format!("below {:.2} %", 100.0 * upper(count, of, 0.05)))
        } else if count == of {
            (format!("{count} of {of}"), format!("above {:.1} %", 100.0 * lower(count, of, 0.05)))
        } else {
            let [low, high] = [lower(count, of, 0.025), upper(count, of, 0.025)].map(|bound| 100.0 * bound);
            (format!("{count} of {of}, {share:.1} %"), format!("{low:.1} to {high:.1} %"))
        };
        text += &format!("| {score} | {measured} | {bounds} |\n");
    }
    page::says("docs/how-to/run-a-campaign.md", "campaign", &text);
    let readme = std::fs::read_to_string("README.md").unwrap();
    let of = |score: &str| {
        table.rows.iter().find(|(name, _)| name == score).map(|(_, counts)| (counts[0], counts[1])).unwrap()
    };
    let percent = |score: &str| format!("{:.1} %", 100.0 * of(score).0 as f64 / of(score).1 as f64);
    let (healthy, faulty) = (of("false alarms").1, of("true detection rate").1);
    for said in [
        format!("| {healthy} healthy records of "),
        format!("| {faulty} records of these rigs"),
        format!("| {} detected; in {} exactly", percent("true detection rate"), percent("exact isolation of all")),
        format!("; {} of the 95 % intervals hold", percent("coverage of found faults")),
    ] {
        assert!(readme.contains(&said), "README.md does not have: {said}");
    }
}

/// Shifts, in half widths of the 95 % interval, and changes of the effort that count as none.
const SAME: (f64, f64) = (0.1, 0.02);

#[test]
fn the_settings_that_results_depend_on_are_those_of_the_study() {
    let all = Changed::all();
    let of = |id: &str, side: &str| {
        let mut rows = all.iter().filter(|one| one.setting == id && one.side == side);
        rows.next().unwrap_or_else(|| panic!("the study has no row of `{id}` at {side}"))
    };
    let (mut said, mut moved, mut cost, mut none) = (String::new(), String::new(), Vec::new(), Vec::new());
    for setting in Settings::default().each() {
        let sides = ["half", "double"].map(|side| of(setting.id, side));
        let cells = |one: fn(&Changed) -> String| format!("| `{}` | {} |\n", setting.id, sides.map(one).join(" | "));
        if sides.iter().any(|side| !side.otherwise.is_empty()) {
            said += &cells(|side| side.otherwise.join("<br>"));
        } else if sides.iter().any(|side| side.shift > SAME.0) {
            moved += &cells(|side| format!("{:.2} | {:.2}", side.shift, side.effort));
        } else if sides.iter().any(|side| (side.effort - 1.0).abs() > SAME.1) {
            cost.push(cells(|side| format!("{:.2}", side.effort)));
        } else {
            none.push(format!("`{}`", setting.id));
        }
    }
    let text = format!(
        "## Another word\n\nWhat is said of some case is another at half or at double; on the left of each arrow with all settings as \
         they are.\n\n| setting | at half | at double |\n|---|---|---|\n{said}\n\
         ## Another number\n\nThe same words, and a number that moves by more than {} of the half width of its interval.\n\n\
         | setting | at half, half widths | effort | at double, half widths | effort |\n|---|---|---|---|---|\n{moved}\n\
         ## Another effort\n\nThe same words and numbers; the effort, over that with all settings as they are.\n\n\
         | setting | at half | at double |\n|---|---|---|\n{}\n\
         ## Nothing in these cases\n\n{}.\n",
        SAME.0,
        cost.concat(),
        none.join(", ")
    );
    page::says("docs/theory/settings.md", "settings", &text);
}
