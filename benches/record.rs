//! Times reading a long record: `cargo bench --bench record`.

mod timing;

use std::fmt::Write as _;

use borescope::Record;
use timing::{line, time};

const RECORD: &str = "fixtures/telescopic/healthy_1.csv";
const ROWS: usize = 250_000;

/// The rows of a bundled record, over and over, with a time that goes on.
fn long() -> String {
    let text = std::fs::read_to_string(RECORD).expect("the record is there");
    let (header, rows) = text.split_once('\n').expect("a header");
    let rows: Vec<&str> = rows.lines().filter_map(|row| row.split_once(',')).map(|(_, rest)| rest).collect();
    let mut out = format!("{header}\n");
    for (row, rest) in rows.iter().cycle().take(ROWS).enumerate() {
        writeln!(out, "{:.3},{rest}", row as f64 * 0.004).expect("written");
    }
    out
}

fn main() {
    let text = long();
    let file = tempfile::Builder::new().suffix(".csv").tempfile().expect("a file");
    std::fs::write(file.path(), &text).expect("written");
    let timed = time(5, || {
        let record = Record::read(file.path()).expect("read");
        assert_eq!(record.time.len(), ROWS);
    });
    let megabytes = text.len() as f64 / 1e6;
    let remark = format!("{megabytes:.0} MB, {:.0} MB/s", megabytes / timed.least * 1e3);
    line(&format!("reading {ROWS} rows"), "borescope", timed, &remark);
}
