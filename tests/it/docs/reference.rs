//! The generated parts of the reference say what the cards say. `BLESS=1` writes them anew.

use crate::support::page;

use std::fs;

use borescope::internals::report::reference::{LIBRARY, PageError, Part, RIG_FILE, SETTINGS, refresh};

const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/reference/rig-file.md");
const SETTINGS_PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/reference/settings.md");
const EFFECTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/reference/effects.md");

fn is_fresh(path: &str, parts: &[Part]) {
    let page = fs::read_to_string(path).unwrap();
    let fresh = refresh(&page, parts).unwrap_or_else(|error| panic!("{path}: {error}"));
    if page == fresh {
        return;
    }
    if page::blessed() {
        fs::write(path, fresh).unwrap();
        return;
    }
    let differs = page.lines().zip(fresh.lines()).enumerate().find(|(_, (old, new))| old != new);
    panic!(
        "{path} is stale; run `BLESS=1 cargo test --release --test it -- docs::reference`. First difference: {differs:?}"
    );
}

#[test]
fn the_reference_is_that_of_the_cards() {
    is_fresh(PAGE, RIG_FILE);
}

#[test]
fn the_effects_are_those_of_the_library() {
    is_fresh(EFFECTS, LIBRARY);
}

#[test]
fn the_settings_are_those_of_the_tables() {
    is_fresh(SETTINGS_PAGE, SETTINGS);
}

#[test]
fn a_page_that_lost_a_mark_is_told() {
    let page = fs::read_to_string(PAGE).unwrap();
    let without = page.replacen("<!-- generated: units -->", "", 1);
    assert_eq!(refresh(&without, RIG_FILE), Err(PageError::Unmarked { name: "units" }));
    let unknown = page.replacen("generated: units", "generated: tunits", 1);
    assert_eq!(refresh(&unknown, RIG_FILE), Err(PageError::Unknown { name: "tunits".to_owned() }));
    assert_eq!(
        refresh("<!-- generated: fluid -->", RIG_FILE).unwrap_err().to_string(),
        "`<!-- end -->` is missing behind the mark of `fluid`"
    );
}
