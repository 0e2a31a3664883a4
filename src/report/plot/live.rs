//! A chart of a page: as wide as the page, in its colours; `page.js` lets it be zoomed and read.
//!
//! Curves lie on a grid of whole numbers inside a nested picture that stretches, lines keep their width; ticks and labels stand
//! at percentages. So the text stays readable on a phone, nothing needs a script to be seen, and a zoom is another `viewBox`.

use std::fmt::Write;

use super::axis::{HIGH, Scale, WIDE};
use super::room::{Room, Side};
use super::thin::thin;
use super::{Axis, Chart, DASHES, PALETTE, Rule, Series, Shape, pieces};
use crate::number::rounded;
use crate::report::escape;

/// Ticks that an axis aims at.
const TICKS: (f64, f64) = (super::TICK_COUNT, 4.0);
/// Ticks of the x axis of a narrow one; `page.js` aims at as many.
pub(super) const NARROW: f64 = 4.0;
/// Height of a chart that has none of its own, px.
const HEIGHT: f64 = 200.0;

/// How a chart behaves in a page.
#[derive(Debug, Clone, PartialEq)]
pub struct Live {
    /// Charts of one group share zoom and cursor; the name of their x.
    pub group: String,
    /// Most points of a curve.
    pub points: usize,
    /// Whether it stands beside others, with room for few numbers under it.
    pub narrow: bool,
    /// What the chart shows, for those who do not see it.
    pub description: String,
}

impl Live {
    /// A chart of a group with curves in full.
    pub fn new(group: impl Into<String>, description: impl Into<String>) -> Self {
        Self { group: group.into(), points: 5_000, narrow: false, description: description.into() }
    }

    /// The same in a part of the width.
    #[must_use]
    pub fn narrow(mut self) -> Self {
        self.narrow = true;
        self
    }

    /// The same with so many points in a curve at most.
    #[must_use]
    pub fn points(mut self, points: usize) -> Self {
        self.points = points;
        self
    }
}

impl Chart {
    /// The chart as a `<figure>` of a page.
    pub fn live(&self, live: &Live) -> String {
        let log = self.y.logarithmic;
        let height = |value: f64| if log { value.max(f64::MIN_POSITIVE).log10() } else { value };
        let (x, y) = self.scales(&height, if live.narrow { NARROW } else { TICKS.0 });
        let mut out = String::new();
        open(&mut out, &self.title, &self.y, &self.key(), live);
        let (from, to) = x.ends();
        let (low, high) = y.ends();
        let fixed = if self.envelopes.is_empty() && self.y.range.is_none() { "" } else { " data-fixed" };
        let scale = if log { " data-log" } else { "" };
        let still = if self.x.names.is_empty() { "" } else { " data-still" };
        let narrow = if live.narrow { " data-narrow" } else { "" };
        let size = self.height.unwrap_or(HEIGHT);
        put(
            &mut out,
            format_args!(
                "<svg class=\"live\" role=\"img\" tabindex=\"0\" height=\"{size:.0}\" data-group=\"{}\" data-x=\"{} {}\" \
                 data-y=\"{} {}\"{fixed}{scale}{still}{narrow} aria-label=\"{}\">\n<g class=\"grid\">",
                escape(&live.group),
                short(from),
                short(to),
                short(low),
                short(high),
                escape(&live.description)
            ),
        );
        grid(&mut out, &self.x, &x, &y, log);
        put(
            &mut out,
            format_args!("</g>\n<svg class=\"plot\" viewBox=\"0 0 {WIDE} {HIGH}\" preserveAspectRatio=\"none\">"),
        );
        self.curves(&mut out, &x, &y, &height, live.points);
        out.push_str("</svg>\n");
        let room = Room::new(self, (&x, &y), &height, (live.narrow, size));
        self.labels(&mut out, &x, &y, &height, &room);
        out.push_str("</svg>\n");
        close(&mut out, &self.x);
        out
    }

    fn scales(&self, height: &dyn Fn(f64) -> f64, ticks: f64) -> (Scale, Scale) {
        let points = || self.series.iter().flat_map(|series| &series.points);
        let spread = || self.envelopes.iter().flat_map(|envelope| &envelope.points);
        let marks = || self.markers.iter();
        let seen_x = points().map(|p| p.0).chain(spread().map(|p| p.0)).chain(marks().map(|m| m.x));
        let seen_y = points().map(|p| p.1).chain(spread().flat_map(|p| [p.1, p.2])).chain(marks().map(|m| m.y));
        let across = self.rules.iter().filter_map(|rule| match rule {
            Rule::Horizontal { y, .. } => Some(*y),
            Rule::Vertical { .. } => None,
        });
        let mut along = self.x.clone();
        if let (false, count) = (self.x.names.is_empty(), self.x.names.len()) {
            along.range = Some((-0.5, count as f64 - 0.5));
        }
        let x = Scale::new(&along, seen_x, (0.0, WIDE), WIDE / ticks, false);
        let y = Scale::new(&self.y, seen_y.chain(across).map(height), (HIGH, 0.0), HIGH / TICKS.1, true);
        (x, y)
    }

    /// Samples and names of the curves, each with room for the value at the cursor.
    fn key(&self) -> String {
        let mut out = String::new();
        let named = self.series.iter().enumerate().filter(|(_, series)| !series.name.is_empty());
        for (index, series) in named {
            let sample = match series.shape {
                Shape::Dots => format!("<path class=\"dots {}\" d=\"M12 6h0\"/>", colour(series, index)),
                Shape::Line | Shape::Wide | Shape::Pale => format!(
                    "<path class=\"{}{}\"{} d=\"M0 6h24\"/>",
                    shape(series),
                    colour(series, index),
                    dashes(series, index)
                ),
            };
            put(
                &mut out,
                format_args!(
                    "<li><svg class=\"sample\" aria-hidden=\"true\">{sample}</svg>{} <output data-curve=\"{index}\"></output></li>",
                    escape(&series.name)
                ),
            );
        }
        for envelope in self.envelopes.iter().filter(|envelope| !envelope.name.is_empty()) {
            put(
                &mut out,
                format_args!(
                    "<li><svg class=\"sample\" aria-hidden=\"true\"><rect class=\"area k{}\" width=\"24\" height=\"12\"/></svg>{}</li>",
                    envelope.colour % PALETTE.len(),
                    escape(&envelope.name)
                ),
            );
        }
        out
    }

    fn curves(&self, out: &mut String, x: &Scale, y: &Scale, height: &dyn Fn(f64) -> f64, points: usize) {
        for band in &self.bands {
            let (from, to) = (x.at(band.from), x.at(band.to));
            put(
                out,
                format_args!(
                    "<rect class=\"band\" x=\"{from:.0}\" y=\"-{HIGH}\" width=\"{:.0}\" height=\"{}\"><title>{}</title></rect>",
                    (to - from).max(0.0),
                    3.0 * HIGH,
                    escape(&band.label)
                ),
            );
        }
        for envelope in &self.envelopes {
            let outline = |piece: &[(f64, f64, f64)]| {
                let mut outline: Vec<(i64, i64)> = piece.iter().map(|p| grid_point(x, y, (p.0, height(p.2)))).collect();
                outline.extend(piece.iter().rev().map(|p| grid_point(x, y, (p.0, height(p.1)))));
                path(&outline) + "z"
            };
            let pieces = envelope.points.split(|p| !(p.0.is_finite() && p.1.is_finite() && p.2.is_finite()));
            let outlines: String = pieces.filter(|piece| !piece.is_empty()).map(outline).collect();
            let class = envelope.colour % PALETTE.len();
            put(out, format_args!("<path class=\"area k{class}\" d=\"{outlines}\"/>"));
        }
        for rule in &self.rules {
            match rule {
                Rule::Horizontal { y: level, .. } => {
                    put(
                        out,
                        format_args!(
                            "<path class=\"rule\" d=\"M-{WIDE} {:.0}H{}\"/>",
                            y.at(height(*level)),
                            2.0 * WIDE
                        ),
                    );
                }
                Rule::Vertical { x: at, .. } => {
                    put(out, format_args!("<path class=\"rule\" d=\"M{:.0} -{HIGH}V{}\"/>", x.at(*at), 2.0 * HIGH));
                }
            }
        }
        for (index, series) in self.series.iter().enumerate() {
            let mut line = String::new();
            let count = pieces(series).count().max(1);
            for piece in pieces(series) {
                let on_grid: Vec<(f64, f64)> = piece.iter().map(|p| (x.at(p.0), y.at(height(p.1)))).collect();
                match series.shape {
                    Shape::Line | Shape::Wide | Shape::Pale => {
                        line.push_str(&path(&thin(&on_grid, (points / count).max(50), WIDE)))
                    }
                    Shape::Dots => on_grid.iter().for_each(|(px, py)| {
                        let _ = write!(line, "M{px:.0} {py:.0}h0");
                    }),
                }
            }
            let class = shape(series);
            put(
                out,
                format_args!(
                    "<path class=\"{class}{}\"{} data-curve=\"{index}\" d=\"{line}\"/>",
                    colour(series, index),
                    dashes(series, index)
                ),
            );
        }
        for marker in self.markers.iter().filter(|marker| marker.x.is_finite() && marker.y.is_finite()) {
            let at = grid_point(x, y, (marker.x, height(marker.y)));
            put(out, format_args!("<path class=\"dots marker\" d=\"M{} {}h0\"/>", at.0, at.1));
        }
    }

    /// Texts at places; the script moves them with a zoom.
    fn labels(&self, out: &mut String, x: &Scale, y: &Scale, height: &dyn Fn(f64) -> f64, room: &Room) {
        for rule in self.rules.iter().filter(|rule| !rule.label().is_empty()) {
            match rule {
                Rule::Horizontal { y: level, label } => put(
                    out,
                    format_args!(
                        "<text class=\"note\" data-level=\"{}\" {} y=\"{}%\" dy=\"-4\">{}</text>",
                        short(height(*level)),
                        match room.along(y.at(height(*level)), label) {
                            Side::Left => "x=\"0.5%\"",
                            Side::Middle => "x=\"50%\" text-anchor=\"middle\"",
                            Side::Right => "x=\"99.5%\" text-anchor=\"end\"",
                        },
                        percent(y.at(height(*level)) / HIGH),
                        escape(label)
                    ),
                ),
                Rule::Vertical { x: at, label } => put(
                    out,
                    format_args!(
                        "<text class=\"note\" data-at=\"{}\" x=\"{}%\" y=\"12\" {}>{}</text>",
                        short(*at),
                        percent(x.at(*at) / WIDE),
                        match room.beside(x.at(*at), label) {
                            Side::Left => "dx=\"-4\" text-anchor=\"end\"",
                            _ => "dx=\"4\"",
                        },
                        escape(label)
                    ),
                ),
            }
        }
        for marker in self.markers.iter().filter(|marker| marker.x.is_finite() && marker.y.is_finite()) {
            put(
                out,
                format_args!(
                    "<text class=\"note\" data-at=\"{}\" data-level=\"{}\" x=\"{}%\" y=\"{}%\" dx=\"6\" dy=\"-6\">{}</text>",
                    short(marker.x),
                    short(height(marker.y)),
                    percent(x.at(marker.x) / WIDE),
                    percent(y.at(height(marker.y)) / HIGH),
                    escape(&marker.label)
                ),
            );
        }
    }
}

/// Heading, key and room for the buttons.
pub(super) fn open(out: &mut String, title: &str, y: &Axis, key: &str, live: &Live) {
    let unit = if matches!(y.unit.as_str(), "" | "-") { String::new() } else { format!(" in {}", escape(&y.unit)) };
    let label = if y.label.is_empty() || y.label == title { unit } else { format!(" {}{unit}", escape(&y.label)) };
    let title = escape(title);
    put(
        out,
        format_args!(
            "<figure class=\"chart\" data-name=\"{title}\" data-of=\"{}\">\n<div class=\"head\"><h3>{title}<small>{label}</small></h3>\
             <ul class=\"key\">{key}</ul><span class=\"tools\"></span></div>\n<div class=\"frame\">",
            escape(&live.group)
        ),
    );
}

pub(super) fn close(out: &mut String, x: &Axis) {
    let unit = if matches!(x.unit.as_str(), "" | "-") { String::new() } else { format!(" in {}", x.unit) };
    put(out, format_args!("</div>\n<figcaption>{}</figcaption>\n</figure>", escape(&format!("{}{unit}", x.label))));
}

/// Lines and numbers of the ticks.
pub(super) fn grid(out: &mut String, axis: &Axis, x: &Scale, y: &Scale, log: bool) {
    let (low, high) = y.ends();
    for (at, text) in if log { decades(low, high) } else { y.ticks.iter().map(|&t| (t, y.number(t))).collect() } {
        let at = percent(y.at(at) / HIGH);
        put(
            out,
            format_args!(
                "<line x2=\"100%\" y1=\"{at}%\" y2=\"{at}%\"/><text class=\"y\" x=\"-7\" y=\"{at}%\" dy=\"4\">{text}</text>"
            ),
        );
    }
    along(out, axis, x);
}

/// Numbers, or names, under the chart.
pub(super) fn along(out: &mut String, axis: &Axis, x: &Scale) {
    if axis.names.is_empty() {
        for &tick in &x.ticks {
            let at = percent(x.at(tick) / WIDE);
            put(
                out,
                format_args!(
                    "<line class=\"x\" x1=\"{at}%\" x2=\"{at}%\" y2=\"100%\"/><text class=\"x\" x=\"{at}%\" y=\"100%\" dy=\"16\">{}</text>",
                    x.number(tick)
                ),
            );
        }
    }
    for (index, name) in axis.names.iter().enumerate() {
        let at = percent(x.at(index as f64) / WIDE);
        put(out, format_args!("<text class=\"x\" x=\"{at}%\" y=\"100%\" dy=\"16\">{}</text>", escape(name)));
    }
}

/// Ticks of a logarithmic axis: 1, 2 and 5 of each decade, or every decade where there are many.
fn decades(low: f64, high: f64) -> Vec<(f64, String)> {
    let factors: &[f64] = if high - low > 2.5 { &[1.0] } else { &[1.0, 2.0, 5.0] };
    (low.floor() as i32..=high.ceil() as i32)
        .flat_map(|power| factors.iter().map(move |factor| factor * 10_f64.powi(power)))
        .filter(|value| (low - 1e-9..=high + 1e-9).contains(&value.log10()))
        .map(|value| (value.log10(), crate::number::text(rounded(value, 3))))
        .collect()
}

fn colour(series: &Series, index: usize) -> String {
    format!("k{}", series.colour.unwrap_or(index) % PALETTE.len())
}

/// How the style calls the shape.
fn shape(series: &Series) -> &'static str {
    match series.shape {
        Shape::Line => "",
        Shape::Wide => "wide-line ",
        Shape::Pale => "pale ",
        Shape::Dots => "dots ",
    }
}

fn dashes(series: &Series, index: usize) -> String {
    let dash = DASHES[series.dash.unwrap_or(index) % DASHES.len()];
    if dash.is_empty() || series.shape == Shape::Dots { String::new() } else { format!(" stroke-dasharray=\"{dash}\"") }
}

fn grid_point(x: &Scale, y: &Scale, point: (f64, f64)) -> (i64, i64) {
    (x.at(point.0).round() as i64, y.at(point.1).round() as i64)
}

/// A path through points; steps are shorter than places.
fn path(points: &[(i64, i64)]) -> String {
    let mut out = String::new();
    let mut before = (0, 0);
    for (index, &(x, y)) in points.iter().enumerate() {
        let (dx, dy) = (x - before.0, y - before.1);
        let _ = match index {
            0 => write!(out, "M{x} {y}"),
            1 => write!(out, "l{dx}{}{dy}", if dy < 0 { "" } else { " " }),
            _ => write!(out, "{}{dx}{}{dy}", if dx < 0 { "" } else { " " }, if dy < 0 { "" } else { " " }),
        };
        before = (x, y);
    }
    out
}

/// A number for the script.
pub(super) fn short(value: f64) -> String {
    rounded(value, 9).to_string()
}

/// A share as a percentage, without needless digits.
pub(super) fn percent(share: f64) -> String {
    rounded(100.0 * share, 5).to_string()
}

pub(super) fn put(out: &mut String, line: std::fmt::Arguments<'_>) {
    // Writing to a String cannot fail.
    let _ = out.write_fmt(line);
    out.push('\n');
}
