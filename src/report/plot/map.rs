//! A map: rows of fields along one axis, each as dark as what it stands for is large.

use super::axis::{Scale, WIDE};
use super::live::{self, Live, NARROW, percent, put};
use super::{Axis, TICK_COUNT};
use crate::report::escape;

/// Height of a row, px.
const ROW: f64 = 26.0;

/// One field.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// Row, from 0.
    pub row: usize,
    pub from: f64,
    pub to: f64,
    /// How dark, from 0 to 1.
    pub share: f64,
    /// What it says where one points at it.
    pub text: String,
}

/// Rows of fields along an axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    pub title: String,
    pub x: Axis,
    /// Names of the rows.
    pub rows: Vec<String>,
    pub cells: Vec<Cell>,
}

impl Map {
    /// The map as a `<figure>` of a page; in the group of `live`, zoom and cursor are shared.
    pub fn live(&self, live: &Live) -> String {
        let ends = self.cells.iter().flat_map(|cell| [cell.from, cell.to]);
        let x = Scale::new(&self.x, ends, (0.0, WIDE), WIDE / if live.narrow { NARROW } else { TICK_COUNT }, false);
        let count = self.rows.len().max(1) as f64;
        let mut out = String::new();
        live::open(&mut out, &self.title, &Axis::new("", ""), "", live);
        let (from, to) = x.ends();
        put(
            &mut out,
            format_args!(
                "<svg class=\"live map\" role=\"img\" tabindex=\"0\" height=\"{:.0}\" data-group=\"{}\" data-x=\"{} {}\" \
                 data-y=\"0 {count}\" data-fixed data-rows{} aria-label=\"{}\">\n<g class=\"grid\">",
                ROW * count,
                escape(&live.group),
                live::short(from),
                live::short(to),
                if live.narrow { " data-narrow" } else { "" },
                escape(&live.description)
            ),
        );
        live::along(&mut out, &self.x, &x);
        put(
            &mut out,
            format_args!("</g>\n<svg class=\"plot\" viewBox=\"0 0 {WIDE} {count}\" preserveAspectRatio=\"none\">"),
        );
        for cell in &self.cells {
            let (left, right) = (x.at(cell.from), x.at(cell.to));
            put(
                &mut out,
                format_args!(
                    "<rect class=\"field\" x=\"{left:.0}\" y=\"{}.06\" width=\"{:.0}\" height=\".88\" fill-opacity=\"{:.2}\"><title>{}</title></rect>",
                    cell.row,
                    (right - left).max(1.0),
                    cell.share.clamp(0.0, 1.0),
                    escape(&cell.text)
                ),
            );
        }
        out.push_str("</svg>\n");
        for (row, name) in self.rows.iter().enumerate() {
            let at = percent((row as f64 + 0.5) / count);
            put(&mut out, format_args!("<text class=\"y\" x=\"-7\" y=\"{at}%\" dy=\"4\">{}</text>", escape(name)));
        }
        out.push_str("</svg>\n");
        live::close(&mut out, &self.x);
        out
    }
}
