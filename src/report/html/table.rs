//! Tables of a page: words, numbers, shaded fields and small bars on a scale.

use std::fmt::Write;

use super::{line, prose};
use crate::report::escape;
use crate::report::table::Head;

/// A column of a table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    pub name: String,
    /// Unit of its numbers, shown in the head; empty for none.
    pub unit: String,
    /// Numbers are set to the right.
    pub numeric: bool,
}

impl Column {
    /// A column of words.
    pub fn text(name: impl Into<String>) -> Self {
        Self { name: name.into(), unit: String::new(), numeric: false }
    }

    /// A column of numbers in a unit; an empty unit for none.
    pub fn number(name: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { name: name.into(), unit: unit.into(), numeric: true }
    }
}

/// What stands in a field.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    Text(String),
    /// A text on a shade from 0 (paper) to 1.
    Shade(String, f64),
    /// What a scale shows.
    Scale(Scale),
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

/// Marks on a line from one value to another; what lies outside is drawn at its end.
#[derive(Debug, Clone, PartialEq)]
pub struct Scale {
    pub from: f64,
    pub to: f64,
    pub marks: Vec<Mark>,
    /// What is shown, for those who do not see it.
    pub text: String,
}

/// A mark on a scale.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Mark {
    /// A bar from one value to another; an end that is not known fades out.
    Bar(Option<f64>, Option<f64>),
    /// A narrow bar from one value to another, upon the wide one: what is known afterwards.
    Interval(f64, f64),
    /// A full bar from the start.
    Length(f64),
    /// A stroke: what should be.
    Stroke(f64),
    /// A dashed stroke: what must not be passed.
    Limit(f64),
    /// A point: what is.
    Point(f64),
}

impl Scale {
    pub(super) fn html(&self) -> String {
        let span = self.to - self.from;
        let at = |value: f64| {
            let share = if span > 0.0 { ((value - self.from) / span).clamp(0.0, 1.0) } else { 0.5 };
            crate::number::rounded(100.0 * share, 4)
        };
        let mut out = format!(
            "<svg class=\"scale\" role=\"img\" aria-label=\"{}\"><line class=\"axis\" x2=\"100%\" y1=\"9\" y2=\"9\"/>",
            escape(&self.text)
        );
        for mark in &self.marks {
            let _ = match *mark {
                Mark::Bar(low, high) => {
                    let (left, right) = (at(low.unwrap_or(self.from)), at(high.unwrap_or(self.to)));
                    let class = if low.is_none() || high.is_none() { "bar open" } else { "bar" };
                    write!(out, "<line class=\"{class}\" x1=\"{left}%\" x2=\"{right}%\" y1=\"9\" y2=\"9\"/>")
                }
                Mark::Interval(low, high) => {
                    let (left, right) = (at(low), at(high));
                    write!(out, "<line class=\"interval\" x1=\"{left}%\" x2=\"{right}%\" y1=\"9\" y2=\"9\"/>")
                }
                Mark::Length(value) => {
                    write!(out, "<rect class=\"length\" width=\"{}%\" y=\"4\" height=\"10\"/>", at(value))
                }
                Mark::Stroke(value) => {
                    write!(out, "<line class=\"stroke\" x1=\"{0}%\" x2=\"{0}%\" y1=\"1\" y2=\"17\"/>", at(value))
                }
                Mark::Limit(value) => {
                    write!(out, "<line class=\"limit\" x1=\"{0}%\" x2=\"{0}%\" y2=\"18\"/>", at(value))
                }
                Mark::Point(value) => write!(out, "<circle class=\"point\" cx=\"{}%\" cy=\"9\" r=\"4\"/>", at(value)),
            };
        }
        out + "</svg>"
    }
}

/// A table; a row shorter than the columns ends in empty fields, what goes beyond them is dropped.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    pub caption: String,
    pub columns: Vec<Column>,
    pub rows: Vec<Vec<Cell>>,
    /// Whether the heads stand upright, as many narrow columns ask for.
    pub upright: bool,
    /// The column whose words can be chosen from, in a table that can be searched.
    pub choice: Option<usize>,
}

impl Table {
    /// A table of words and numbers.
    pub fn new(caption: impl Into<String>, columns: Vec<Column>, rows: Vec<Vec<Cell>>) -> Self {
        Self { caption: caption.into(), columns, rows, upright: false, choice: None }
    }

    /// What stands as a text elsewhere, as a table.
    pub fn of(caption: &str, heads: &[Head], rows: Vec<Vec<String>>) -> Self {
        let column = |&(name, numeric): &Head| if numeric { Column::number(name, "") } else { Column::text(name) };
        let rows = rows.into_iter().map(|row| row.into_iter().map(Cell::from).collect()).collect();
        Self::new(caption, heads.iter().map(column).collect(), rows)
    }

    /// The same, to be searched, and filtered by the words of one column.
    #[must_use]
    pub fn searchable(mut self, choice: usize) -> Self {
        self.choice = Some(choice);
        self
    }

    /// The same with another column behind the one with this index.
    #[must_use]
    pub fn with(mut self, behind: usize, column: Column, cells: Vec<Cell>) -> Self {
        let place = (behind + 1).min(self.columns.len());
        self.columns.insert(place, column);
        for (row, cell) in self.rows.iter_mut().zip(cells) {
            let place = place.min(row.len());
            row.insert(place, cell);
        }
        self
    }

    pub(super) fn html(&self, out: &mut String) {
        let class = if self.upright { " class=\"upright\"" } else { "" };
        let choice = self.choice.map_or_else(String::new, |column| format!(" data-choice=\"{column}\""));
        line(
            out,
            format_args!(
                "<div class=\"head\"><p class=\"caption\">{}</p><span class=\"tools\"></span></div>\n\
                 <div class=\"wide\"><table{class}{choice} aria-label=\"{}\">\n<thead><tr>",
                prose(&self.caption),
                escape(&self.caption)
            ),
        );
        let class = |column: &Column| if column.numeric { " class=\"number\"" } else { "" };
        for column in &self.columns {
            let unit = if column.unit.is_empty() {
                String::new()
            } else {
                format!(" <small>{}</small>", escape(&column.unit))
            };
            line(
                out,
                format_args!("<th scope=\"col\"{}><span>{}{unit}</span></th>", class(column), escape(&column.name)),
            );
        }
        out.push_str("</tr></thead>\n<tbody>\n");
        for row in &self.rows {
            out.push_str("<tr>");
            for (index, column) in self.columns.iter().enumerate() {
                let _ = match row.get(index) {
                    None => write!(out, "<td{}></td>", class(column)),
                    Some(Cell::Text(text)) => write!(out, "<td{}>{}</td>", class(column), prose(text)),
                    Some(Cell::Shade(text, share)) => {
                        let share = share.clamp(0.0, 1.0);
                        let ink = if share > 0.55 { " dark" } else { "" };
                        write!(out, "<td class=\"shade{ink}\" style=\"--s:{share:.2}\">{}</td>", escape(text))
                    }
                    Some(Cell::Scale(scale)) => write!(out, "<td class=\"picture\">{}</td>", scale.html()),
                };
            }
            out.push_str("</tr>\n");
        }
        out.push_str("</tbody>\n</table></div>\n");
    }
}
