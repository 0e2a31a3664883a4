//! The settings as tables of the reference.

use std::fmt::{self, Write};

use crate::number::text;
use crate::settings::{Setting, Settings};

/// A table for each group.
pub(super) fn markdown(out: &mut String) -> fmt::Result {
    let all: Vec<Setting> = Settings::default().each().collect();
    let group = |setting: &Setting| setting.id.split('.').next().unwrap_or_default().to_owned();
    for group in all.chunk_by(|a, b| group(a) == group(b)) {
        let name = group[0].id.split('.').next().unwrap_or_default();
        writeln!(out, "\n## {name}\n\n| setting | value | unit | meaning | derivation |\n|---|---|---|---|---|")?;
        for Setting { id, value, unit, meaning, derivation, .. } in group {
            writeln!(out, "| `{id}` | {} | {unit} | {meaning} | {derivation} |", text(*value))?;
        }
    }
    Ok(())
}
