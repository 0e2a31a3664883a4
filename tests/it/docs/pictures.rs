//! The pictures of pages that stand in the book.
//!
//! `BLESS=1 cargo test --release --test it -- docs::pictures` draws them anew with a headless browser.

use crate::support::page;

use crate::support::browser;
use crate::support::command;
use crate::support::leaking;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use command::borescope;

const RIG: &str = "fixtures/telescopic/rig.toml";
const TANKS: &str = "fixtures/two_tanks/rig.toml";
const FIGURES: &str = "docs/figures";

/// A picture: its file, the page that it is of, its size in px, whether in the dark, and what is left of the page.
struct Picture {
    file: &'static str,
    page: &'static str,
    size: (u32, u32),
    dark: bool,
    shown: &'static str,
}

/// Keeps some parts of a page; zooms and points as a hand would.
const HELP: &str = "const only = (...kept) => document.body.replaceChildren(...kept.map((one) => document.querySelector(one)));
const fire = (name, share) => { const svg = document.querySelector('svg.live'), box = svg.getBoundingClientRect();
  svg.dispatchEvent(new PointerEvent(name, { bubbles: true, clientX: box.left + share * box.width, clientY: box.top + 20, button: 0, pointerId: 1 })); };
const figure = (name) => `figure[data-name=\"${name}\"]`;
const zoomed = () => { only(figure('p_A'), figure('misfit of p_A'), figure('p_B'));
  fire('pointerdown', 0.005); fire('pointermove', 0.07); fire('pointerup', 0.07); fire('pointermove', 0.44); };
";

const PICTURES: [Picture; 8] = [
    Picture { file: "report-diagnosis.png", page: "diagnose", size: (1000, 1010), dark: false, shown: "" },
    Picture { file: "report-profiles.png", page: "diagnose", size: (1200, 820), dark: false, shown: "only('.beside')" },
    Picture { file: "report-zoom.png", page: "diagnose", size: (1000, 800), dark: false, shown: "zoomed()" },
    Picture { file: "report-phone.png", page: "diagnose", size: (400, 900), dark: true, shown: "zoomed()" },
    Picture { file: "report-compare.png", page: "compare", size: (1200, 330), dark: false, shown: "only('.beside')" },
    Picture { file: "report-missing.png", page: "suggest", size: (1200, 330), dark: false, shown: "only('.beside')" },
    Picture { file: "report-history.png", page: "history", size: (1240, 770), dark: false, shown: "only('main')" },
    Picture { file: "report-campaign.png", page: "campaign", size: (1220, 1060), dark: false, shown: "" },
];

fn ran(call: &str) {
    let ran = borescope(call.split(' '));
    assert_eq!(ran.status, Some(0), "{call}: {}{}", ran.out, ran.err);
}

/// The pages, each under its verb.
fn pages(folder: &Path) -> BTreeMap<&'static str, PathBuf> {
    let path = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    leaking::leaking(folder);
    let tanks = fs::read_to_string(TANKS).unwrap();
    let healthy = "\"upper_outlet.diameter\" = {";
    assert!(tanks.contains(healthy));
    fs::write(path("tanks.toml"), tanks.replace(healthy, &format!("{healthy} limit = \"8.8 mm\","))).unwrap();
    for day in 1..=4 {
        let record = path(&format!("day_{day}.csv"));
        ran(&format!("simulate {TANKS} --set upper_outlet.diameter=8.{day}mm --seed {day} -o {record}"));
        ran(&format!("diagnose {} {record} --store {} --at 2026-05-0{day}", path("tanks.toml"), path("store")));
    }
    let calls = [
        ("diagnose", format!("{RIG} fixtures/telescopic/series_1.csv")),
        ("compare", format!("{RIG} fixtures/telescopic/opening_040.csv")),
        ("suggest", format!("{} {} --check {}", path("rig.toml"), path("fit.csv"), path("check.csv"))),
        ("history", format!("{} --store {}", path("tanks.toml"), path("store"))),
        ("campaign", format!("{TANKS} --cases 20")),
    ];
    let page = |(verb, call): (&'static str, String)| {
        let page = folder.join(format!("{verb}.html"));
        ran(&format!("{verb} {call} --report {}", page.display()));
        (verb, page)
    };
    calls.into_iter().map(page).collect()
}

/// Width and height of a PNG file, px.
fn size(path: &Path) -> (u32, u32) {
    let bytes = fs::read(path).unwrap();
    assert_eq!(&bytes[12..16], b"IHDR", "{}", path.display());
    let number = |at: usize| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap());
    (number(16), number(20))
}

#[test]
fn every_picture_of_a_page_is_drawn_by_this_test() {
    let folder = tempfile::tempdir().unwrap();
    if page::blessed() {
        let browser = browser::browser();
        let pages = pages(folder.path());
        for picture in &PICTURES {
            let html = fs::read_to_string(&pages[picture.page]).unwrap();
            let script = format!("<script>\n{HELP}{};\n</script>\n</body>", picture.shown);
            let page = folder.path().join("shown.html");
            fs::write(&page, html.replace("</body>", &script)).unwrap();
            let file = folder.path().join(picture.file);
            let output = browser::call(browser, folder.path(), picture.size, picture.dark)
                .args(["--hide-scrollbars".to_owned(), format!("--screenshot={}", file.display())])
                .arg(format!("file://{}", page.display()))
                .output()
                .unwrap();
            let said = String::from_utf8_lossy(&output.stderr);
            assert!(file.is_file() && !said.contains("CONSOLE"), "{}: {said}", picture.file);
            fs::copy(&file, Path::new(FIGURES).join(picture.file)).unwrap();
        }
    }
    for picture in &PICTURES {
        assert_eq!(size(&Path::new(FIGURES).join(picture.file)), picture.size, "{}", picture.file);
    }
    let drawn = fs::read_dir(FIGURES).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    // The desk by `cli::desk::in_a_browser`, which works it.
    for file in drawn.filter(|file| file.ends_with(".png") && file != "desk.png") {
        assert!(PICTURES.iter().any(|picture| picture.file == file), "{file} is drawn by no test");
    }
}
