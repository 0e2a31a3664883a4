//! Studies: how large they are, and the tables that they leave.

use std::fs;
use std::str::FromStr;

use borescope::internals::campaign::statistics::{lower, upper};

/// A number that the environment gives a study, such as `CASES`.
pub fn number<T: FromStr>(name: &str, otherwise: T) -> T {
    match std::env::var(name) {
        Ok(text) => text.parse().unwrap_or_else(|_| panic!("{name}={text} is no number that this study takes")),
        Err(_) => otherwise,
    }
}

/// Probability beyond each bound of a rate that a test holds.
pub const TAIL: f64 = 5e-4;

/// A rate may be `claimed`: neither too few nor too many for chance (Clopper and Pearson).
pub fn may_be(what: &str, (count, of): (usize, usize), claimed: f64) {
    let (low, high) = (lower(count, of, TAIL), upper(count, of, TAIL));
    assert!(low <= claimed && claimed <= high, "{what}: {count} of {of} is not {claimed} ({low:.4} to {high:.4})");
}

/// Two rates may be one: the chance of a difference as large between equal rates is not below [`TAIL`] on either side.
///
/// Fisher's exact test: given the sum of both counts, either one is hypergeometric.
pub fn may_be_equal(what: &str, (a, n): (usize, usize), (b, m): (usize, usize)) {
    let logs: Vec<f64> = std::iter::once(0.0)
        .chain((1..=n + m).scan(0.0, |sum, k| {
            *sum += (k as f64).ln();
            Some(*sum)
        }))
        .collect();
    let choose = |n: usize, k: usize| logs[n] - logs[k] - logs[n - k];
    let total = a + b;
    let probability = |k: usize| (choose(n, k) + choose(m, total - k) - choose(n + m, total)).exp();
    let (least, most) = (total.saturating_sub(m), total.min(n));
    let fewer: f64 = (least..=a).map(probability).sum();
    let more: f64 = (a..=most).map(probability).sum();
    assert!(fewer >= TAIL && more >= TAIL, "{what}: {a} of {n}, and {b} of {m} when the table was written");
}

/// A table of counts, a row by its first cell: what a study wrote last.
#[derive(Debug, Clone)]
pub struct Table {
    path: &'static str,
    pub columns: Vec<String>,
    pub rows: Vec<(String, Vec<usize>)>,
}

impl Table {
    pub fn read(path: &'static str) -> Self {
        let mut reader = csv::Reader::from_path(path).unwrap_or_else(|error| panic!("{path}: {error}"));
        let columns = reader.headers().unwrap().iter().map(str::to_owned).collect();
        let row = |record: csv::StringRecord| {
            let counts =
                record.iter().skip(1).map(|cell| cell.parse().unwrap_or_else(|_| panic!("{path}: {record:?}")));
            (record[0].to_owned(), counts.collect())
        };
        Self { path, columns, rows: reader.records().map(|record| row(record.unwrap())).collect() }
    }

    pub fn row(&self, name: &str) -> Option<&[usize]> {
        self.rows.iter().find(|(other, _)| other == name).map(|(_, counts)| counts.as_slice())
    }

    /// Puts a row in the place of the one of that name, or last.
    pub fn set(&mut self, name: &str, counts: Vec<usize>) {
        assert_eq!(counts.len() + 1, self.columns.len(), "{name}");
        match self.rows.iter_mut().find(|(other, _)| other == name) {
            Some((_, old)) => *old = counts,
            None => self.rows.push((name.to_owned(), counts)),
        }
    }

    pub fn write(&self) {
        let line = |cells: Vec<String>| cells.join(",") + "\n";
        let row = |(name, counts): &(String, Vec<usize>)| {
            line(std::iter::once(name.clone()).chain(counts.iter().map(usize::to_string)).collect())
        };
        let text = line(self.columns.clone()) + &self.rows.iter().map(row).collect::<String>();
        fs::write(self.path, text).unwrap();
    }
}

/// What a setting at another value changes: a row of `fixtures/studies/settings.csv`.
#[derive(Debug, Clone, PartialEq)]
pub struct Changed {
    pub setting: String,
    /// `half` or `double`.
    pub side: String,
    pub value: f64,
    /// Largest change of a number, in half widths of its interval, where the words stay.
    pub shift: f64,
    /// Effort, over that with all settings as they are.
    pub effort: f64,
    /// Cases of which other words are said, with both.
    pub otherwise: Vec<String>,
}

impl Changed {
    const PATH: &str = "fixtures/studies/settings.csv";

    pub fn all() -> Vec<Self> {
        let Ok(mut reader) = csv::Reader::from_path(Self::PATH) else { return Vec::new() };
        let row = |row: csv::StringRecord| Self {
            setting: row[0].to_owned(),
            side: row[1].to_owned(),
            value: row[2].parse().unwrap(),
            shift: row[3].parse().unwrap(),
            effort: row[4].parse().unwrap(),
            otherwise: row[5].split(" | ").filter(|one| !one.is_empty()).map(str::to_owned).collect(),
        };
        reader.records().map(|one| row(one.unwrap())).collect()
    }

    fn is_of(&self, other: &Self) -> bool {
        (&self.setting, &self.side) == (&other.setting, &other.side)
    }

    /// Puts the row in the place of the one of its setting and side, or last.
    pub fn write(self) {
        let mut all = Self::all();
        match all.iter_mut().find(|one| one.is_of(&self)) {
            Some(old) => *old = self,
            None => all.push(self),
        }
        let mut writer = csv::Writer::from_path(Self::PATH).unwrap();
        writer.write_record(["setting", "side", "value", "shift", "effort", "otherwise"]).unwrap();
        for one in all {
            let numbers = [format!("{}", one.value), format!("{:.3}", one.shift), format!("{:.3}", one.effort)];
            let [value, shift, effort] = numbers;
            writer.write_record([one.setting, one.side, value, shift, effort, one.otherwise.join(" | ")]).unwrap();
        }
        writer.flush().unwrap();
    }

    /// It is what the study last wrote: the same cases otherwise, and the rest about as much.
    pub fn is_as_written(&self) {
        let all = Self::all();
        let old = all.iter().find(|one| one.is_of(self)).unwrap_or_else(|| panic!("no row of {self:?}"));
        let near = (self.shift - old.shift).abs() <= 0.1 + 0.2 * old.shift && (self.effort - old.effort).abs() < 0.1;
        assert!(self.otherwise == old.otherwise && near, "{self:?}\nwas written as {old:?}");
    }
}

#[test]
fn equal_rates_may_be_equal_and_unequal_ones_may_not() {
    may_be_equal("the same", (18, 20), (19, 20));
    let differs = || may_be_equal("half", (10, 20), (20, 20));
    assert!(std::panic::catch_unwind(differs).is_err());
    // 2 of 4 beside 0 of 4: with 2 of 8 in all, both on one side has 6 of 28 ways.
    may_be_equal("few", (2, 4), (0, 4));
    let (few, many) = ((90, 100), (99, 100));
    may_be("nine in ten", few, 0.9);
    assert!(std::panic::catch_unwind(|| may_be("nine in ten", many, 0.9)).is_err());
}
