//! The files of a folder, however deep.

use std::fs;
use std::path::{Path, PathBuf};

/// Every file with this extension at or below a place, in a fixed order.
pub fn below(place: &Path, extension: &str) -> Vec<PathBuf> {
    if !place.is_dir() {
        let is_one = place.extension().is_some_and(|own| own == extension);
        return is_one.then(|| place.to_owned()).into_iter().collect();
    }
    let entries = fs::read_dir(place).unwrap();
    let mut found: Vec<PathBuf> = entries.flat_map(|entry| below(&entry.unwrap().path(), extension)).collect();
    found.sort();
    found
}
