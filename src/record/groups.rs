//! Records whose columns come whole, as from formats that are no text, each group of them with its own time.

use std::path::Path;

use super::care::{Care, MOST_COLUMNS, Standing};
use super::dialect::counted_from;
use super::field::FAR;
use super::sampling::Sampling;
use super::{Asked, Channel, Origin, Record};
use crate::complaint::{Complaint, Kind};
use crate::units::{Dimension, Unit};
use crate::visible::unusable_name;

/// Stamps that differ by less than this share of the shortest usual interval are one.
const SAME: f64 = 0.01;
/// Most numbers of a record: groups whose stamps never meet have rows of their own.
const MOST_NUMBERS: usize = 1 << 27;

/// A column as the file has it.
pub(super) struct Column {
    pub name: String,
    pub unit: Option<String>,
    /// NaN where there is none.
    pub values: Vec<f64>,
}

/// Columns over one time.
#[derive(Default)]
pub(super) struct Group {
    pub name: String,
    pub time: Vec<f64>,
    pub time_unit: String,
    pub columns: Vec<Column>,
}

/// All of a file.
#[derive(Default)]
pub(super) struct Groups {
    groups: Vec<Group>,
    /// What holds no series, and why.
    left_out: Vec<(String, String)>,
    /// What is to be known of how the file was read.
    remark: Option<&'static str>,
}

/// Whether a column of this name is the time.
pub(super) fn is_time(name: &str) -> bool {
    name.eq_ignore_ascii_case("time") || name.eq_ignore_ascii_case("t")
}

impl Groups {
    pub fn leave(&mut self, name: impl Into<String>, why: impl Into<String>) {
        self.left_out.push((name.into(), why.into()));
    }

    /// Says something about how the file was read, to stand behind its format.
    pub fn remark(&mut self, remark: &'static str) {
        self.remark = Some(remark);
    }

    /// Takes a group; one without a time or without rows is left out.
    pub fn push(&mut self, group: Group) {
        if group.time.is_empty() {
            for column in group.columns {
                self.leave(column.name, "no time with it");
            }
        } else if !group.columns.is_empty() {
            self.groups.push(group);
        }
    }

    /// The record: rows at the stamps of every group that the rig asks for, NaN where a channel has no sample.
    ///
    /// # Errors
    /// No series; columns of another length than their time; too many of them; a time that does not rise, which with one group
    /// alone may also be surveyed.
    pub fn assemble(mut self, path: &Path, care: Care, asked: &Asked) -> Result<Standing, Complaint> {
        let complain = |kind, what: String| Complaint::new(kind, what).in_file(path);
        if self.groups.is_empty() {
            return Err(complain(Kind::Empty, "the file has no series over a time".to_owned())
                .help("a vector `time` with others of its length, or a group of channels with a time"));
        }
        let count = self.groups.iter().map(|group| group.columns.len()).sum::<usize>();
        if count > MOST_COLUMNS {
            return Err(complain(Kind::Bounds, format!("the file has {count} columns"))
                .help(format!("no more than {MOST_COLUMNS} are read; leave away those that the rig does not name")));
        }
        let alone = self.groups.len() == 1;
        let mut refused = None;
        for group in &mut self.groups {
            check_lengths(path, group)?;
            if let Err(complaint) = check_time(path, group) {
                if care == Care::Strict || !alone || group.time.iter().any(|time| !time.is_finite()) {
                    return Err(complaint);
                }
                refused = Some(complaint);
            }
        }
        let wanted: Vec<bool> =
            self.groups.iter().map(|group| group.columns.iter().any(|c| asked.has(&c.name))).collect();
        let making = |index: usize| wanted.get(index) == Some(&true) || !wanted.contains(&true);
        let times: Vec<&[f64]> = self.groups.iter().map(|group| &group.time[..]).collect();
        let (time, rows) = if alone { (times[0].to_vec(), Vec::new()) } else { align(&times, making) };
        if time.len().saturating_mul(count) > MOST_NUMBERS {
            let what = format!("the record has {count} columns at {} times", time.len());
            return Err(
                complain(Kind::Bounds, what).help("split it, or leave away channels that the rig does not name")
            );
        }
        let mut channels: Vec<Channel> = Vec::new();
        for (number, group) in self.groups.into_iter().enumerate() {
            for column in group.columns {
                let unit = match unit(&column, asked) {
                    Ok(unit) => unit,
                    Err(why) => {
                        self.left_out.push((column.name, why));
                        continue;
                    }
                };
                let values =
                    column.values.iter().map(|value| if value.is_finite() { unit.to_si(*value) } else { f64::NAN });
                let values = if alone { values.collect() } else { spread(values, &rows[number], time.len()) };
                let name = unlike(column.name, &group.name, number, &channels);
                channels.push(Channel::new(name, unit, values));
            }
        }
        let begins_at = time.first().copied().filter(|start| start.abs() > FAR);
        let time = time.iter().map(|time| time - begins_at.unwrap_or(0.0)).collect();
        let remark = self.remark.map_or(String::new(), |remark| format!(" {remark}"));
        let read_as = remark + &counted_from(begins_at.map(|start| format!("{start} s")).as_deref());
        let origin = Origin { left_out: self.left_out, read_as, ..Origin::default() };
        // Without decimals there is nothing to say of the rounding of the time.
        let path = path.to_path_buf();
        Ok((Record { path, time, time_decimals: None, channels, header_line: 0, origin }, refused))
    }
}

/// A name that no channel has yet.
fn unlike(name: String, group: &str, number: usize, channels: &[Channel]) -> String {
    let taken = |name: &str| channels.iter().any(|channel| channel.name == name);
    if !taken(&name) {
        return name;
    }
    let within = if group.is_empty() { format!("{name}@{}", number + 1) } else { format!("{group}.{name}") };
    (1..)
        .map(|again| if again == 1 { within.clone() } else { format!("{within}#{again}") })
        .find(|name| !taken(name))
        .unwrap_or(within)
}

/// The unit that the values are in; why the column is of no use where its name or its unit is not.
fn unit(column: &Column, asked: &Asked) -> Result<Unit, String> {
    match unusable_name(&column.name) {
        Some(why) => Err(format!("its name {why}")),
        None => unit_of(column, asked),
    }
}

/// The unit of the file, else that of the rig file; why the column is of no use where neither has one.
fn unit_of(column: &Column, asked: &Asked) -> Result<Unit, String> {
    let told = asked.unit(&column.name).cloned();
    let Some(own) = &column.unit else { return Ok(told.unwrap_or_else(Unit::dimensionless)) };
    Unit::parse(own).or_else(|error| told.ok_or_else(|| error.to_string()))
}

fn check_lengths(path: &Path, group: &Group) -> Result<(), Complaint> {
    let Some(column) = group.columns.iter().find(|column| column.values.len() != group.time.len()) else {
        return Ok(());
    };
    let (found, wanted) = (column.values.len(), group.time.len());
    let what = format!("the column `{}` has {found} values for {wanted} times", column.name);
    Err(Complaint::new(Kind::Shape, what).in_file(path).help("one value for each time"))
}

/// Brings the time into seconds, and looks whether it rises.
fn check_time(path: &Path, group: &mut Group) -> Result<(), Complaint> {
    let complain = |kind, what: String| Complaint::new(kind, what).in_file(path);
    let unit = Unit::parse_as(&group.time_unit, Dimension::TIME)
        .map_err(|error| complain(Kind::Unit, format!("the time: {error}")).help(error.help()))?;
    let written = |row: usize| group.time.get(row).copied().unwrap_or_default();
    let finite = group.time.iter().position(|time| !time.is_finite());
    let falls = group.time.windows(2).position(|pair| pair[1] <= pair[0]);
    let result = match (finite, falls) {
        (Some(row), _) => Err(complain(Kind::Number, format!("the time has no finite number in row {}", row + 1))
            .help("remove the rows without a time")),
        (None, Some(row)) => {
            let what = format!("the time does not rise to {} {unit} in row {}", written(row + 1), row + 2);
            Err(complain(Kind::Order, what).help("remove the repeated rows, or split the record there"))
        }
        (None, None) => Ok(()),
    };
    group.time.iter_mut().for_each(|time| *time = unit.to_si(*time));
    result
}

/// The stamps of the groups that make rows, and for each group the row of each of its samples; no sample is moved by more than
/// the clocks differ, and those of other groups that meet no row have none.
fn align(times: &[&[f64]], making: impl Fn(usize) -> bool) -> (Vec<f64>, Vec<Vec<Option<usize>>>) {
    let usual = |time: &[f64]| Sampling::of(time, None).map_or(f64::INFINITY, |sampling| sampling.interval);
    let intervals: Vec<f64> = times.iter().map(|time| usual(time)).collect();
    let makers = || (0..times.len()).filter(|index| making(*index));
    let shortest = makers().map(|index| intervals[index]).fold(f64::INFINITY, f64::min);
    let same = if shortest.is_finite() { SAME * shortest } else { 0.0 };
    // Samples of the fastest group come first among those of one moment, so that a row has its stamp.
    let mut order: Vec<usize> = makers().collect();
    order.sort_by(|a, b| intervals[*a].total_cmp(&intervals[*b]));
    let mut stamps: Vec<f64> = Vec::new();
    for group in order {
        let fresh = |time: &&f64| nearest(&stamps, **time).is_none_or(|row| (stamps[row] - **time).abs() > same);
        let fresh: Vec<f64> = times[group].iter().filter(fresh).copied().collect();
        stamps.extend(fresh);
        stamps.sort_by(f64::total_cmp);
    }
    let row = |time: &f64| nearest(&stamps, *time).filter(|row| (stamps[*row] - time).abs() <= same);
    let rows = times.iter().map(|time| time.iter().map(row).collect()).collect();
    (stamps, rows)
}

/// Of rising stamps the one nearest to a time.
fn nearest(stamps: &[f64], time: f64) -> Option<usize> {
    let after = stamps.partition_point(|stamp| *stamp < time);
    let near = [after.checked_sub(1), (after < stamps.len()).then_some(after)];
    near.into_iter().flatten().min_by(|a, b| (stamps[*a] - time).abs().total_cmp(&(stamps[*b] - time).abs()))
}

fn spread(values: impl Iterator<Item = f64>, rows: &[Option<usize>], count: usize) -> Vec<f64> {
    let mut out = vec![f64::NAN; count];
    for (value, row) in values.zip(rows) {
        if let Some(slot) = row.and_then(|row| out.get_mut(row)) {
            *slot = value;
        }
    }
    out
}

/// Name and unit of `p_A [bar]`.
pub(super) fn split_name(field: &str) -> (String, Option<String>) {
    match field.trim().strip_suffix(']').and_then(|rest| rest.rsplit_once('[')) {
        Some((name, unit)) => (name.trim().to_owned(), Some(unit.trim().to_owned())),
        None => (field.trim().to_owned(), None),
    }
}
