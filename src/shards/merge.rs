//! All shards of one work, put together.

use std::fs;
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::share::PREFIX;
use super::{DONE, Done, Form, JOURNAL, Journal, Numbered, Share, put_in_order};
use crate::complaint::{Complaint, Kind, Place};

/// Puts the shards in a folder together: what the work was, as the first shard says it, and every row once, by number.
///
/// # Errors
/// A folder without shards; one that is missing, not done, damaged, or of other work; then nothing is left out quietly.
pub fn merge<W, R>(work: &Path, form: &Form) -> Result<(W, Vec<R>), Complaint>
where
    W: Clone + Serialize + DeserializeOwned,
    R: Numbered,
{
    let mut found: Vec<(PathBuf, Done<W>)> = Vec::new();
    for folder in folders(work)? {
        if let Some(done) = Done::read(&folder, form)? {
            if done.shard.folder(work) != folder {
                let what = format!("the folder is not named as its shard {}", done.shard);
                let name = done.shard.folder(work);
                return Err(Complaint::new(Kind::Contradiction, what)
                    .at(Place::file(folder.join(DONE)))
                    .help(format!("rename it to `{}`", name.file_name().unwrap_or_default().display())));
            }
            found.push((folder, done));
        }
    }
    let Some((first, reference)) = found.first() else {
        let what = format!("there are no shards of {} that are done", form.whole);
        return Err(Complaint::new(Kind::Missing, what)
            .in_file(work)
            .help(format!("name the folder that `--shard` has filled; a shard is done when it has a `{DONE}`")));
    };
    let of = reference.shard.of;
    if let Some((other, done)) = found.iter().find(|(_, done)| !is_one(reference, done)) {
        return Err(stranger(form, (first, reference), (other, done)));
    }
    let missing: Vec<usize> =
        (1..=of).filter(|&index| found.iter().all(|(_, done)| done.shard.index != index)).collect();
    if !missing.is_empty() {
        return Err(incomplete(work, &missing, of));
    }
    let mut rows: Vec<R> = Vec::new();
    for (folder, done) in &found {
        let mut own: Vec<R> = Journal::read(folder, form, &done.digest)?;
        put_in_order(&mut own);
        let [from, to] = done.range;
        if !own.iter().map(R::number).eq(from..to) {
            let what = format!("the journal does not hold each {} from {from} to {to} (not included) once", form.row);
            return Err(Complaint::new(Kind::Contradiction, what)
                .at(Place::file(folder.join(JOURNAL)))
                .help("delete the folder of the shard, and do the shard again"));
        }
        rows.append(&mut own);
    }
    rows.sort_by_key(R::number);
    Ok((reference.work.clone(), rows))
}

/// Folders that are named as those of shards, in their order.
fn folders(work: &Path) -> Result<Vec<PathBuf>, Complaint> {
    let unreadable = |error: &std::io::Error| {
        Complaint::new(Kind::Unreadable, format!("the folder cannot be read: {error}"))
            .in_file(work)
            .help("name the folder that `--shard` has filled")
    };
    let mut folders = Vec::new();
    for entry in fs::read_dir(work).map_err(|error| unreadable(&error))? {
        let entry = entry.map_err(|error| unreadable(&error))?;
        if entry.file_name().to_string_lossy().starts_with(PREFIX) && entry.path().is_dir() {
            folders.push(entry.path());
        }
    }
    folders.sort();
    Ok(folders)
}

fn is_one<W>(one: &Done<W>, other: &Done<W>) -> bool {
    one.digest == other.digest && one.version == other.version && one.shard.of == other.shard.of
}

fn stranger<W>(form: &Form, one: (&Path, &Done<W>), other: (&Path, &Done<W>)) -> Complaint {
    let (a, b) = (one.1, other.1);
    let why = if a.version != b.version {
        format!("versions {} and {} of the program", a.version, b.version)
    } else if a.shard.of != b.shard.of {
        format!("one of {} shards and one of {}", a.shard.of, b.shard.of)
    } else {
        "other options or other files".to_owned()
    };
    Complaint::new(
        Kind::Contradiction,
        format!("these shards are not of one and the same work ({}): {why}", form.whole),
    )
    .at(Place::file(one.0.join(DONE)))
    .at(Place::file(other.0.join(DONE)))
    .help("do all shards with the same command and files, each work in a folder of its own")
}

fn incomplete(work: &Path, missing: &[usize], of: usize) -> Complaint {
    let begun = missing.iter().filter(|&&index| Share { index, of }.folder(work).is_dir()).count();
    let (plural, verb) = if missing.len() == 1 { ("", "is") } else { ("s", "are") };
    let begun = if begun == 0 { String::new() } else { format!("; {begun} of them begun") };
    let what = format!("shard{plural} {} of {of} {verb} not done{begun}", ranges(missing));
    Complaint::new(Kind::MissingEntry, what)
        .in_file(work)
        .help(format!("run the command of each again, such as `--shard {}/{of}`, then merge", missing[0]))
}

/// Numbers that rise, those that follow each other as `7 to 9`.
fn ranges(numbers: &[usize]) -> String {
    let runs = numbers.chunk_by(|a, b| a + 1 == *b);
    let words = runs.map(|run| match run {
        [one] => one.to_string(),
        [one, other] => format!("{one}, {other}"),
        [first, .., last] => format!("{first} to {last}"),
        [] => String::new(),
    });
    words.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::ranges;

    #[test]
    fn numbers_that_follow_each_other_are_a_range() {
        assert_eq!(ranges(&[3, 7, 8, 9, 11, 12]), "3, 7 to 9, 11, 12");
        assert_eq!(ranges(&[1]), "1");
    }
}
