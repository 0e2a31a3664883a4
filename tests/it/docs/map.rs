//! The map of the code is true: its table of modules has every room, and what each knows is what its files use.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// What all rooms may use, and the map does not repeat.
const EVERYBODY: [&str; 2] = ["complaint", "units"];
/// Files beside the rooms: the face of the crate, the program, and what its tests see.
const FACE: [&str; 4] = ["lib", "main", "results", "internals"];

fn words(text: &str) -> BTreeSet<String> {
    // What stands in parentheses says of which part of a room, or where.
    let (mut plain, mut depth) = (String::new(), 0);
    for letter in text.chars() {
        match letter {
            '(' => depth += 1,
            ')' => depth -= 1,
            _ if depth == 0 => plain.push(letter),
            _ => {}
        }
    }
    plain.split(',').map(|word| word.trim().to_owned()).filter(|word| !matches!(word.as_str(), "" | "nothing")).collect()
}

/// What each room knows by the map.
fn stated() -> BTreeMap<String, BTreeSet<String>> {
    let map = fs::read_to_string("docs/map.md").unwrap();
    let rows =
        map.lines().skip_while(|line| !line.starts_with("| module")).skip(2).take_while(|line| line.starts_with('|'));
    rows.map(|row| {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        (cells[1].trim_matches('`').to_owned(), words(cells[3]))
    })
    .collect()
}

fn files(path: &Path, found: &mut Vec<String>) {
    if path.is_dir() {
        fs::read_dir(path).unwrap().for_each(|entry| files(&entry.unwrap().path(), found));
    } else if path.extension().is_some_and(|end| end == "rs") {
        found.push(fs::read_to_string(path).unwrap());
    }
}

/// What each room uses by its files, tests apart.
fn used() -> BTreeMap<String, BTreeSet<String>> {
    let mut rooms: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for entry in fs::read_dir("src").unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
        if !FACE.contains(&name.as_str()) {
            files(&path, rooms.entry(name).or_default());
        }
    }
    let names: BTreeSet<String> = rooms.keys().cloned().collect();
    let uses = |own: &str, files: &[String]| {
        let code = files.iter().map(|file| file.split("#[cfg(test)]\nmod tests").next().unwrap());
        let lines = code.flat_map(str::lines).filter(|line| !line.trim_start().starts_with("//"));
        let after: Vec<&str> = lines.flat_map(|line| line.split("crate::").skip(1)).collect();
        let room = |text: &&str| text.split(|c: char| !c.is_ascii_lowercase() && c != '_').next().unwrap().to_owned();
        let used: BTreeSet<String> = after.iter().map(room).collect();
        used.into_iter()
            .filter(|room| names.contains(room) && room != own && !EVERYBODY.contains(&room.as_str()))
            .collect::<BTreeSet<String>>()
    };
    rooms.iter().map(|(own, files)| (own.clone(), uses(own, files))).collect()
}

#[test]
fn what_each_room_knows_is_what_its_files_use() {
    let (stated, used) = (stated(), used());
    let mut wrong = Vec::new();
    for (room, knows) in &used {
        match stated.get(room) {
            None => wrong.push(format!("docs/map.md has no row `{room}`; it knows {}", list(knows))),
            // These know whatever they need.
            Some(said) if said.iter().any(|word| word == "everything it needs") => {}
            Some(said) if said != knows => {
                let (more, less): (BTreeSet<_>, BTreeSet<_>) =
                    (knows.difference(said).cloned().collect(), said.difference(knows).cloned().collect());
                wrong.push(format!("`{room}` also knows {}; does not know {}", list(&more), list(&less)));
            }
            Some(_) => {}
        }
    }
    wrong.extend(
        stated.keys().filter(|room| !used.contains_key(*room)).map(|room| format!("there is no room `{room}`")),
    );
    assert!(wrong.is_empty(), "docs/map.md:\n{}", wrong.join("\n"));
}

fn list(rooms: &BTreeSet<String>) -> String {
    if rooms.is_empty() { "nothing".to_owned() } else { rooms.iter().cloned().collect::<Vec<_>>().join(", ") }
}
