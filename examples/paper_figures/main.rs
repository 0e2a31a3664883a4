//! Draws figures 6 to 14 of the paper from `fixtures/telescopic/rig.toml` into `docs/figures`, and prints the table of
//! `docs/paper-figures.md`: `cargo run --release --example paper_figures [DIR]`.

mod figures;
mod strokes;

use std::error::Error;
use std::path::{Path, PathBuf};

use borescope::internals::files::write_atomically;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args_os().nth(1).map_or_else(|| PathBuf::from("docs/figures"), PathBuf::from);
    let results = figures::Results::of(&strokes::Bench::read(Path::new("fixtures/telescopic/rig.toml"))?)?;
    for (number, figure) in results.figures() {
        let svg = figure.svg();
        write_atomically(&folder.join(format!("figure-{number:02}.svg")), |out| out.write_all(svg.as_bytes()))?;
    }
    println!("| quantity | unit | paper | here |\n|---|---|---|---|");
    for row in results.table() {
        println!("| {} | {} | {} | {} |", row.quantity, row.unit, row.paper, row.here);
    }
    Ok(())
}
