//! The generated parts of the rig file reference say what the cards say. `BLESS=1` writes them anew.

use std::fs;

use borescope::report::reference::{PageError, refresh};

const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/reference/rig-file.md");

#[test]
fn the_reference_is_that_of_the_cards() {
    let page = fs::read_to_string(PAGE).unwrap();
    let fresh = refresh(&page).unwrap_or_else(|error| panic!("{PAGE}: {error}"));
    if page == fresh {
        return;
    }
    if std::env::var_os("BLESS").is_some() {
        fs::write(PAGE, fresh).unwrap();
        return;
    }
    let differs = page.lines().zip(fresh.lines()).enumerate().find(|(_, (old, new))| old != new);
    panic!("{PAGE} is stale; run `BLESS=1 cargo test --test docs_reference`. First difference: {differs:?}");
}

#[test]
fn a_page_that_lost_a_mark_is_told() {
    let page = fs::read_to_string(PAGE).unwrap();
    let without = page.replacen("<!-- generated: units -->", "", 1);
    assert_eq!(refresh(&without), Err(PageError::Unmarked { name: "units" }));
    let unknown = page.replacen("generated: units", "generated: tunits", 1);
    assert_eq!(refresh(&unknown), Err(PageError::Unknown { name: "tunits".to_owned() }));
    assert_eq!(
        refresh("<!-- generated: fluid -->").unwrap_err().to_string(),
        "`<!-- end -->` is missing behind the mark of `fluid`"
    );
}
