//! The rig file as the desk leaves it, beside the one that it began with.

use std::fs;
use std::path::{Path, PathBuf};

use super::state::Desk;
use crate::complaint::{Complaint, Kind};
use crate::files::{Outputs, write_atomically};

/// Longest name, in characters.
const LONGEST: usize = 100;

impl Desk {
    /// Writes the rig file under a plain name into the folder of the one that it began with, and returns where.
    ///
    /// # Errors
    /// A name that is a path or not that of a rig file; an input; without `replace` a file that is there; everything that goes wrong in
    /// writing.
    pub(super) fn save(&mut self, name: &str, replace: bool) -> Result<PathBuf, Complaint> {
        check_name(name)?;
        let path = folder(&self.rig.path).join(name);
        if fs::symlink_metadata(&path).is_ok_and(|there| !there.is_file()) {
            return Err(Complaint::new(Kind::Unwritable, "this is a link or a folder, not a file")
                .in_file(&path)
                .help("give another name"));
        }
        let inputs =
            [Some(&self.rig.path), Some(&self.fit.record.path), self.check.as_ref().map(|one| &one.record.path)];
        Outputs::new(replace).reading(inputs.into_iter().flatten()).writing(&path)?;
        let text = self.current_text()?;
        write_atomically(&path, |file| file.write_all(text.as_bytes()))?;
        self.say(format!("saved as {}", path.display()));
        Ok(path)
    }
}

fn folder(path: &Path) -> PathBuf {
    path.parent().map(Path::to_path_buf).unwrap_or_default()
}

/// Refuses all but plain names of files: no folder, nothing hidden, nothing that a system takes for a device.
fn check_name(name: &str) -> Result<(), Complaint> {
    let plain = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_' | '.' | ' ' | '+');
    let good = name.ends_with(".toml")
        && name.chars().count() <= LONGEST
        && name.chars().all(plain)
        && name.starts_with(|first: char| first.is_alphanumeric() || first == '_');
    if good {
        return Ok(());
    }
    Err(Complaint::new(Kind::Syntax, format!("`{}` is no plain name of a rig file", name.escape_debug()))
        .help("write letters, digits, `-`, `_` and `.toml` at the end; the file goes into the folder of your rig file"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_plain_names_of_rig_files_are_taken() {
        for good in ["better.toml", "rig_2-a.toml", "Prüfstand 3.toml"] {
            assert!(check_name(good).is_ok(), "{good}");
        }
        for bad in
            ["", ".toml", "../x.toml", "a/b.toml", "a\\b.toml", "c:x.toml", "x.csv", "-x.toml", "x\0.toml", "/x.toml"]
        {
            assert!(check_name(bad).is_err(), "{bad}");
        }
    }
}
