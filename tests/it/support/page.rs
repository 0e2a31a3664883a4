//! Generated parts of committed pages, between `<!-- NAME -->` and `<!-- end -->`.

use std::fs;
use std::sync::Mutex;

/// Whether committed pages, tables and messages are to be written instead of compared: `BLESS=1`.
pub fn blessed() -> bool {
    std::env::var_os("BLESS").is_some()
}

/// Tests run at the same time, and two of them may write one page.
static WRITING: Mutex<()> = Mutex::new(());

/// The text before, in and after the part.
fn split<'a>(page: &str, text: &'a str, name: &str) -> [&'a str; 3] {
    let mark = format!("<!-- {name} -->\n");
    let (before, rest) = text.split_once(&mark).unwrap_or_else(|| panic!("{page} has no {mark}"));
    let (part, after) = rest.split_once("<!-- end -->").unwrap_or_else(|| panic!("{page}: {mark} has no end"));
    [before, part, after]
}

pub fn part(page: &str, name: &str) -> String {
    let text = fs::read_to_string(page).unwrap_or_else(|error| panic!("{page}: {error}"));
    split(page, &text, name)[1].to_owned()
}

pub fn write(page: &str, name: &str, now: &str) {
    let _writing = WRITING.lock().unwrap();
    let text = fs::read_to_string(page).unwrap_or_else(|error| panic!("{page}: {error}"));
    let [before, _, after] = split(page, &text, name);
    fs::write(page, format!("{before}<!-- {name} -->\n{now}<!-- end -->{after}")).unwrap();
}

/// The part is this to the letter; blessed, it becomes it.
pub fn says(page: &str, name: &str, now: &str) {
    if blessed() {
        write(page, name, now);
    }
    let old = part(page, name);
    assert!(old == now, "{page}, {name} is stale (BLESS=1 writes it):\n{now}");
}
