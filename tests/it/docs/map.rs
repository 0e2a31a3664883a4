//! The map of the code is true: its table of modules has every room, and what each knows is what its files use. Those know each other
//! in no circle.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use crate::support::below::below;

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
    plain
        .split(',')
        .map(|word| word.trim().to_owned())
        .filter(|word| !matches!(word.as_str(), "" | "nothing"))
        .collect()
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

/// What each room uses by its files, tests apart.
fn used() -> BTreeMap<String, BTreeSet<String>> {
    let mut rooms: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for entry in fs::read_dir("src").unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
        if !FACE.contains(&name.as_str()) {
            let texts = below(&path, "rs").into_iter().map(|path| fs::read_to_string(path).unwrap());
            rooms.entry(name).or_default().extend(texts);
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

/// A file, as the path of its module: `record`, `groups`.
type Module = Vec<String>;

/// Every file beneath a folder with its code, tests and comments apart.
fn modules(folder: &Path) -> BTreeMap<Module, String> {
    let module = |path: &Path| {
        let inside = path.strip_prefix(folder).unwrap().with_extension("");
        let mut own: Module = inside.iter().map(|name| name.to_str().unwrap().to_owned()).collect();
        own.pop_if(|name| name == "mod");
        own
    };
    let one = |path: PathBuf| (module(&path), code(&fs::read_to_string(&path).unwrap()));
    below(folder, "rs").into_iter().map(one).collect()
}

fn code(text: &str) -> String {
    let code = text.split("#[cfg(test)]\nmod tests").next().unwrap();
    code.lines().map(|line| line.split("//").next().unwrap()).collect::<Vec<_>>().join("\n")
}

fn is_of_name(letter: char) -> bool {
    letter.is_alphanumeric() || letter == '_'
}

/// What stands behind each occurrence of a word.
fn behind<'a>(code: &'a str, word: &'a str) -> impl Iterator<Item = &'a str> {
    code.match_indices(word)
        .filter(|(at, _)| !code[..*at].ends_with(|letter| is_of_name(letter) || letter == ':'))
        .map(|(at, _)| &code[at + word.len()..])
}

/// The paths of a tree: `super::{Asked, table::Row}` are two.
fn paths(tree: &str, before: &str, found: &mut Vec<String>) {
    let tree = tree.trim();
    let Some((start, branches)) = tree.strip_suffix('}').and_then(|tree| tree.split_once('{')) else {
        let name = tree.split(" as ").next().unwrap();
        found.extend((!name.is_empty()).then(|| format!("{before}{name}")));
        return;
    };
    let (before, mut depth, mut begun) = (format!("{before}{start}"), 0, 0);
    for (at, letter) in branches.char_indices().chain([(branches.len(), ',')]) {
        match letter {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                paths(&branches[begun..at], &before, found);
                begun = at + 1;
            }
            _ => {}
        }
    }
}

/// A path as seen from the root: in `record/read`, `super::table::Row` is `record/table/Row`.
fn from_root(module: &[String], path: &str) -> Module {
    let mut names = path.split("::").filter(|name| *name != "self").peekable();
    let mut at = if names.next_if_eq(&"crate").is_some() { Vec::new() } else { module.to_vec() };
    while names.next_if_eq(&"super").is_some() {
        at.pop();
    }
    at.extend(names.map(str::to_owned));
    at
}

/// What the `use` lines of a file name.
fn named(module: &[String], code: &str) -> Vec<Module> {
    let mut found = Vec::new();
    for tree in behind(code, "use ") {
        paths(tree.split(';').next().unwrap(), "", &mut found);
    }
    found.iter().map(|path| from_root(module, path)).collect()
}

/// How often a name is handed on at most, from room to room.
const HANDED_ON: usize = 4;

/// The files that one file uses, but for those that it is made of and those that it is a part of. What a room calls by a name of its own
/// is of the file that has it.
fn known(
    module: &[String],
    code: &str,
    files: &BTreeMap<Module, String>,
    own_names: &BTreeMap<Module, Module>,
) -> BTreeSet<Module> {
    let mut found = named(module, code);
    for word in ["super::", "crate::"] {
        let path = |rest: &str| rest.split(|letter| !is_of_name(letter) && letter != ':').next().unwrap().to_owned();
        found.extend(behind(code, word).map(|rest| from_root(module, &(word.to_owned() + &path(rest)))));
    }
    // The longest beginning that is a file; what is behind it are its items.
    let file = |at: &[String]| (1..=at.len()).rev().find(|length| files.contains_key(&at[..*length]));
    let of = |mut at: Module| {
        let mut length = file(&at)?;
        for _ in 0..HANDED_ON {
            let Some(meant) = at.get(..=length).and_then(|name| own_names.get(name)) else { break };
            at = meant.iter().chain(&at[length + 1..]).cloned().collect();
            length = file(&at)?;
        }
        at.truncate(length);
        (!at.starts_with(module) && !module.starts_with(&at)).then_some(at)
    };
    found.into_iter().filter_map(of).collect()
}

/// What the files call by names of their own, such as a room what it shows of its files: `record/Asked` is `record/asked/Asked`.
fn own_names(files: &BTreeMap<Module, String>) -> BTreeMap<Module, Module> {
    let of = |(module, code): (&Module, &String)| {
        let name = |path: Module| Some(([&module[..], &path[path.len() - 1..]].concat(), path));
        named(module, code).into_iter().filter(|path| path.len() > 1).filter_map(name).collect::<Vec<_>>()
    };
    files.iter().flat_map(of).filter(|(name, path)| name != path && !files.contains_key(name)).collect()
}

/// Files that know each other in a circle, each circle once.
fn circles(files: &BTreeMap<Module, String>) -> Vec<String> {
    let names = own_names(files);
    let known: BTreeMap<&Module, BTreeSet<Module>> =
        files.iter().map(|(module, code)| (module, known(module, code, files, &names))).collect();
    let mut reached: BTreeMap<&Module, BTreeSet<&Module>> = BTreeMap::new();
    for from in known.keys() {
        let (mut open, of_this) = (vec![*from], reached.entry(from).or_default());
        while let Some(module) = open.pop() {
            open.extend(known[module].iter().filter(|next| of_this.insert(*next)));
        }
    }
    let circle = |(module, all): (&&Module, &BTreeSet<&Module>)| {
        let back = all.iter().filter(|other| reached[**other].contains(*module));
        let names: Vec<String> = back.map(|other| other.join("/")).collect();
        (!names.is_empty()).then(|| names.join(", "))
    };
    reached.iter().filter_map(circle).collect::<BTreeSet<_>>().into_iter().collect()
}

#[test]
fn files_know_each_other_in_no_circle() {
    let found = modules(Path::new("src"));
    let circles = circles(&found);
    assert!(circles.is_empty(), "move what several of these need into a file of its own:\n{}", circles.join("\n"));
}

#[test]
fn a_circle_is_found_however_its_files_are_named() {
    let found = |files: &[(&str, &str)]| {
        let module = |name: &str| name.split('/').map(str::to_owned).collect::<Module>();
        circles(&files.iter().map(|(name, text)| (module(name), code(text))).collect())
    };
    let table = ("record/table", "use super::{Asked, read::{self, Care}};");
    assert_eq!(
        found(&[("record", ""), table, ("record/read", "let row = super::table::Row::new();")]),
        ["record/read, record/table"]
    );
    let third = ("rig", "use std::fmt;\npub(crate) use crate::record::table::Row as One;");
    let through = [table, ("record/read", "fn read(rig: &crate::rig::Rig) {}"), third];
    assert_eq!(found(&through), ["record/read, record/table, rig"]);
    // Not even through what the room shows of its files.
    let (room, asked) = (("record", "mod asked;\npub use asked::Asked;"), ("record/asked", "use super::read::read;"));
    assert_eq!(found(&[room, asked, ("record/read", "use super::Asked;")]), ["record/asked, record/read"]);
    // A room and its own files are one; tests and comments know whom they like.
    let inside = ("record", "mod table;\nuse table::Row;");
    assert!(found(&[inside, ("record/table", "use super::Asked;")]).is_empty());
    let apart =
        "// as in super::table\nfn read() {}\n\n#[cfg(test)]\nmod tests {\n    use super::super::table::Row;\n}";
    assert!(found(&[("record", ""), table, ("record/read", apart)]).is_empty());
}

/// The compiler says nothing of a component whose line is missing in `components!`, nor of tests whose line is missing in `main.rs`.
#[test]
fn no_file_is_left_out_of_the_program_or_of_its_tests() {
    for root in ["src", "tests/it"] {
        let all = below(Path::new(root), "rs");
        assert!(all.len() > 60, "{root}: {}", all.len());
        for path in &all {
            let name = path.file_stem().unwrap().to_str().unwrap();
            if ["mod", "main", "lib"].contains(&name) {
                continue;
            }
            let folder = path.parent().unwrap();
            let root = Path::new(root);
            let parents =
                [folder.join("mod.rs"), folder.with_extension("rs"), root.join("main.rs"), root.join("lib.rs")];
            let texts = parents.iter().filter_map(|parent| fs::read_to_string(parent).ok());
            let named = |text: String| {
                let lines = || text.lines().map(str::trim_start);
                lines().any(|line| {
                    line.ends_with(&format!("mod {name};"))
                        || line.starts_with(&format!("{name}::"))
                        || line == format!("{name},")
                })
            };
            assert!(texts.into_iter().any(named), "{} is in no `mod` and no list of its folder", path.display());
        }
    }
}
