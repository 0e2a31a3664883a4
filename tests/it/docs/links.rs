//! What the pages promise: links that lead somewhere, rigs that parse, commands that run.
//!
//! - Relative links of every page in `docs/` and of `README.md` lead to a file, and `#anchors` to a heading of it.
//! - A block marked ```` ```toml rig ```` is a whole rig file that parses.
//! - In a block marked ```` ```console ```` each command `$ borescope check ...`, `simulate` or `campaign` runs from
//!   the root of the repository and ends with exit status 0; with 2 where the block is marked ```` ```console fails ````.
//!   The lines below a command must all occur in what it prints, in this order; a line that ends in `...` stands for
//!   every one that begins so, blank ones are passed over. What a command writes with `-o` or `--report` goes to a temporary
//!   folder, where later commands of the
//!   same page find it.

use crate::support::below::below;
use crate::support::command;

use std::fs;
use std::path::{Path, PathBuf};

use borescope::Rig;
use command::borescope;

/// Options behind which stands a file that is written.
const WRITTEN: [&str; 2] = ["-o", "--report"];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Every page and its text, in a fixed order.
fn pages() -> Vec<(PathBuf, String)> {
    let mut found = below(&root().join("docs"), "md");
    found.push(root().join("README.md"));
    found.sort();
    found
        .into_iter()
        .filter(|path| path.exists())
        .map(|path| (path.clone(), fs::read_to_string(path).unwrap()))
        .collect()
}

/// The text outside fenced blocks, and the blocks with their marks and first lines.
fn split(text: &str) -> (String, Vec<(String, String, usize)>) {
    let (mut prose, mut blocks) = (String::new(), Vec::new());
    let mut open: Option<(String, String, usize)> = None;
    for (number, line) in text.lines().enumerate() {
        if let Some(mark) = line.trim_start().strip_prefix("```") {
            match open.take() {
                Some(block) => blocks.push(block),
                None => open = Some((mark.trim().to_owned(), String::new(), number + 2)),
            }
            continue;
        }
        let target = open.as_mut().map_or(&mut prose, |block| &mut block.1);
        target.push_str(line);
        target.push('\n');
    }
    assert!(open.is_none(), "a fenced block does not close");
    (prose, blocks)
}

/// Headings as a code host turns them into anchors.
fn anchors(text: &str) -> Vec<String> {
    let (prose, _) = split(text);
    let heading = |line: &str| {
        let title = line.strip_prefix('#')?.trim_start_matches('#').strip_prefix(' ')?.to_lowercase();
        let kept = title.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
        Some(kept.map(|c| if c == ' ' { '-' } else { c }).collect())
    };
    prose.lines().filter_map(heading).collect()
}

/// Targets of `[text](target)`; text in backquotes is no link.
fn links(prose: &str) -> Vec<String> {
    let plain: String = prose.split('`').step_by(2).collect();
    let targets = plain.split("](").skip(1).filter_map(|rest| rest.split_once(')'));
    targets.map(|(target, _)| target.to_owned()).collect()
}

#[test]
fn links_lead_somewhere() {
    let mut lost = Vec::new();
    let mut count = 0;
    for (path, text) in pages() {
        for link in links(&split(&text).0) {
            if link.contains("://") {
                continue;
            }
            count += 1;
            let (file, anchor) = link.split_once('#').unwrap_or((&link, ""));
            let target = if file.is_empty() { path.clone() } else { path.parent().unwrap().join(file) };
            // The tutorial is listed before it is written.
            if file == "tutorial.md" && !target.exists() {
                continue;
            }
            let found = target.exists()
                && (anchor.is_empty()
                    || fs::read_to_string(&target)
                        .is_ok_and(|text| anchors(&text).iter().any(|known| known == anchor)));
            if !found {
                lost.push(format!("{}: {link}", path.strip_prefix(root()).unwrap().display()));
            }
        }
    }
    println!("{count} links");
    assert!(lost.is_empty(), "{}", lost.join("\n"));
}

#[test]
fn the_summary_lists_every_page() {
    let summary = fs::read_to_string(root().join("docs/SUMMARY.md")).unwrap();
    let listed = links(&summary);
    for (path, _) in pages() {
        let Ok(page) = path.strip_prefix(root().join("docs")) else { continue };
        let page = page.display().to_string();
        assert!(page == "SUMMARY.md" || listed.contains(&page), "docs/SUMMARY.md does not list {page}");
    }
}

#[test]
fn rigs_parse() {
    let mut count = 0;
    for (path, text) in pages() {
        for (mark, block, line) in split(&text).1 {
            if mark != "toml rig" {
                continue;
            }
            count += 1;
            let name = format!("{}, block at line {line}", path.display());
            if let Err(complaint) = Rig::parse(name, block) {
                panic!("{complaint}");
            }
        }
    }
    println!("{count} rigs");
    assert!(count > 0);
}

#[test]
fn commands_run_and_print_what_is_shown() {
    let mut count = 0;
    for (path, text) in pages() {
        let around = tempfile::tempdir().unwrap();
        // A page may write beside the project.
        let folder = around.path().join("project");
        fs::create_dir(&folder).unwrap();
        let mut written: Vec<String> = Vec::new();
        for (mark, block, line) in split(&text).1 {
            let expected = match mark.as_str() {
                "console" => Some(0),
                "console fails" => Some(2),
                _ => continue,
            };
            let mut shown: Vec<(&str, Vec<&str>)> = Vec::new();
            for text in block.lines() {
                match (text.strip_prefix("$ "), shown.last_mut()) {
                    (Some(command), _) => shown.push((command, Vec::new())),
                    (None, Some((_, lines))) => lines.push(text),
                    (None, None) => {}
                }
            }
            for (command, lines) in shown {
                let words: Vec<&str> = command.split_whitespace().collect();
                let (Some(&"borescope"), Some(&("check" | "simulate" | "campaign" | "add"))) =
                    (words.first(), words.get(1))
                else {
                    continue;
                };
                count += 1;
                let place = |(index, word): (usize, &&str)| {
                    if WRITTEN.contains(&words[index - 1]) || written.iter().any(|known| known == word) {
                        let path = folder.join(word);
                        fs::create_dir_all(path.parent().unwrap()).unwrap();
                        path.display().to_string()
                    } else {
                        (*word).to_owned()
                    }
                };
                let arguments: Vec<String> = words.iter().enumerate().skip(1).map(place).collect();
                written
                    .extend(words.windows(2).filter(|pair| WRITTEN.contains(&pair[0])).map(|pair| pair[1].to_owned()));
                let ran = borescope(&arguments);
                let name = format!("{}, block at line {line}: {command}", path.display());
                assert_eq!(ran.status, expected, "{name}\n{}", ran.err);
                let told = format!("{}{}", ran.out, ran.err).replace(&format!("{}/", folder.display()), "");
                // Where a command goes on in the next line depends on the length of the folder.
                let [told, wanted] = [told, lines.join("\n")].map(|text| text.replace(" \\\n      ", " "));
                let mut rest = told.lines();
                for wanted in wanted.lines().filter(|line| !line.trim().is_empty()) {
                    let fits = |line: &str| match wanted.strip_suffix("...") {
                        Some(begin) => line.starts_with(begin),
                        None => line == wanted,
                    };
                    assert!(rest.any(fits), "{name}: not printed here:\n{wanted}\nbut\n{told}");
                }
            }
        }
    }
    println!("{count} commands");
    assert!(count > 0);
}
