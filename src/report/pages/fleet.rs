//! The page of a fleet: how many rigs are in which state, which limits are reached next, every rig with its last run.

use crate::fleet::{Fleet, Next, Standing, State};
use crate::report::fleet as words;
use crate::report::html::{Page, Section, Table};
use crate::report::style::Tone;

/// Limits that are listed first of all.
const NEXT: usize = 20;

/// The page.
pub fn html<'a>(fleet: &'a Fleet) -> String {
    let mut page = Page::new("Fleet", words::headline(fleet));
    let mut first = Section::new("State");
    let count = |state: State| fleet.states.get(&state).copied().unwrap_or(0);
    let tone = if count(State::LimitReached) + count(State::Faulty) > 0 {
        Tone::Alert
    } else if count(State::Healthy) < fleet.rigs.len() {
        Tone::Caution
    } else {
        Tone::Good
    };
    first.notice(tone, words::counts(fleet));
    page.section(first);
    let ahead = |rig: &'a Standing| rig.next.as_ref().filter(|next| !next.is_reached()).map(|next| (rig, next));
    let mut ahead: Vec<_> = fleet.rigs.iter().filter_map(ahead).collect();
    ahead.sort_by_key(|(_, next)| next.reached_at.clone());
    if !ahead.is_empty() {
        let mut limits = Section::new("Limits reached next");
        let row = |(rig, next): &(&Standing, &Next)| {
            let end = |moment: &Option<String>, open: &str| {
                moment.as_ref().map_or_else(|| open.to_owned(), |moment| moment.get(..10).unwrap_or(moment).to_owned())
            };
            let between = format!("{} to {}", end(&next.ci95[0], "unknown"), end(&next.ci95[1], "never"));
            vec![rig.rig.clone(), words::next(next), between]
        };
        let heads = [("rig", false), ("limit", false), ("95 %", false)];
        limits.table(Table::of("Soonest first", &heads, ahead.iter().take(NEXT).map(row).collect()));
        if ahead.len() > NEXT {
            limits.paragraph(format!("{} more are in the table of all rigs.", ahead.len() - NEXT));
        }
        page.section(limits);
    }
    let mut rigs = Section::new("Rigs");
    rigs.paragraph(
        "The worst first. The course shows the last values of the fault of the next limit, or of the first fault found; its scale includes the \
         healthy value and the limit.",
    );
    let rows = fleet.rigs.iter().map(words::row).collect();
    rigs.table(Table::of("Every rig", &words::HEADS, rows).searchable(1));
    page.section(rigs);
    page.html()
}
