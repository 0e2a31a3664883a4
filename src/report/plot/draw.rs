//! SVG of a figure. Every length goes out with one decimal.

use std::fmt::Write;

use super::axis::Scale;
use super::{Axis, Chart, DASHES, Figure, PALETTE, Rule, Series, Shape, pieces};
use crate::report::escape;

const LEFT: f64 = 66.0;
const RIGHT: f64 = 20.0;
const TITLE: f64 = 26.0;
const LEGEND_ROW: f64 = 18.0;
const BOTTOM: f64 = 50.0;
/// A panel needs this much for title, legend and axis, and a little to draw in.
const LEAST: f64 = 140.0;
/// Mean width of a character at 12 px; a legend needs an estimate, and this is on the safe side.
const CHARACTER: f64 = 6.9;
const SAMPLE: f64 = 28.0;

pub(super) fn figure(figure: &Figure) -> String {
    let width = figure.width.max(200.0);
    let panel = |chart: &Chart| chart.height.unwrap_or(figure.panel_height).max(LEAST);
    let height: f64 = figure.panels.iter().map(panel).sum();
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" viewBox=\"0 0 {width:.0} {height:.0}\" \
         width=\"{width:.0}\" height=\"{height:.0}\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"12\" \
         fill=\"#222\">\n<title>{}</title>\n<desc>{}</desc>\n\
         <rect width=\"{width:.0}\" height=\"{height:.0}\" fill=\"#fff\"/>\n",
        escape(&figure.title),
        escape(&figure.description)
    );
    let mut top = 0.0;
    for chart in &figure.panels {
        let mut canvas = Canvas { out: String::new() };
        canvas.chart(chart, top, width, panel(chart));
        out.push_str(&canvas.out);
        top += panel(chart);
    }
    out.push_str("</svg>\n");
    out
}

struct Canvas {
    out: String,
}

impl Canvas {
    fn put(&mut self, line: std::fmt::Arguments<'_>) {
        // Writing to a String cannot fail.
        let _ = self.out.write_fmt(line);
        self.out.push('\n');
    }

    fn text(&mut self, x: f64, y: f64, anchor: &str, extra: &str, text: &str) {
        let text = escape(text);
        self.put(format_args!("<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\"{extra}>{text}</text>"));
    }

    fn chart(&mut self, chart: &Chart, top: f64, width: f64, height: f64) {
        self.text(LEFT, top + 18.0, "start", " font-size=\"14\" font-weight=\"bold\"", &chart.title);
        let under_legend = self.legend(chart, top + TITLE, width);
        let (left, right) = (LEFT, width - RIGHT);
        let (upper, lower) = (under_legend + 8.0, top + height - BOTTOM);

        let points = || chart.series.iter().flat_map(|series| &series.points);
        let spread = || chart.envelopes.iter().flat_map(|envelope| &envelope.points);
        let seen_x = points().map(|p| p.0).chain(spread().map(|p| p.0)).chain(chart.markers.iter().map(|m| m.x));
        let seen_y =
            points().map(|p| p.1).chain(spread().flat_map(|p| [p.1, p.2])).chain(chart.markers.iter().map(|m| m.y));
        let across = chart.rules.iter().filter_map(|rule| match rule {
            Rule::Horizontal { y, .. } => Some(*y),
            Rule::Vertical { .. } => None,
        });
        let x = Scale::new(&chart.x, seen_x, (left, right), 70.0, false);
        let y = Scale::new(&chart.y, seen_y.chain(across), (lower, upper), 36.0, true);

        self.grid(chart, &x, &y, (left, upper, right, lower));
        // A nested svg clips without an id, so that several pictures can stand in one page; 3 px let edge lines show whole.
        let (w, h) = (right - left + 6.0, lower - upper + 6.0);
        let corner = (left - 3.0, upper - 3.0);
        self.put(format_args!(
            "<svg x=\"{0:.1}\" y=\"{1:.1}\" width=\"{w:.1}\" height=\"{h:.1}\" viewBox=\"{0:.1} {1:.1} {w:.1} {h:.1}\">",
            corner.0, corner.1
        ));
        for envelope in &chart.envelopes {
            let finite = envelope.points.iter().filter(|p| p.0.is_finite() && p.1.is_finite() && p.2.is_finite());
            let high = finite.clone().map(|p| (x.at(p.0), y.at(p.2)));
            let low = finite.rev().map(|p| (x.at(p.0), y.at(p.1)));
            let outline: Vec<String> = high.chain(low).map(|(px, py)| format!("{px:.1},{py:.1}")).collect();
            let colour = PALETTE[envelope.colour % PALETTE.len()];
            self.put(format_args!(
                "<polygon points=\"{}\" fill=\"{colour}\" fill-opacity=\"0.2\"/>",
                outline.join(" ")
            ));
        }
        for (index, series) in chart.series.iter().enumerate() {
            self.series(series, index, &x, &y);
        }
        self.put(format_args!("</svg>"));
        self.annotations(chart, &x, &y, (left, upper, right, lower));
    }

    fn grid(&mut self, chart: &Chart, x: &Scale, y: &Scale, (left, upper, right, lower): (f64, f64, f64, f64)) {
        for band in &chart.bands {
            let (from, to) = (x.at(band.from).clamp(left, right), x.at(band.to).clamp(left, right));
            self.put(format_args!(
                "<rect x=\"{from:.1}\" y=\"{upper:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"#e9edf2\"/>",
                (to - from).max(0.0),
                lower - upper
            ));
            if to - from > text_width(&band.label) {
                self.text(f64::midpoint(from, to), upper + 14.0, "middle", " fill=\"#555\"", &band.label);
            }
        }
        for &tick in &y.ticks {
            let at = y.at(tick);
            self.put(format_args!("<path d=\"M{left:.1} {at:.1}H{right:.1}\" stroke=\"#d5d5d5\" fill=\"none\"/>"));
            self.text(left - 7.0, at + 4.0, "end", "", &y.number(tick));
        }
        for &tick in &x.ticks {
            let at = x.at(tick);
            self.put(format_args!("<path d=\"M{at:.1} {lower:.1}v5\" stroke=\"#222\" fill=\"none\"/>"));
            self.text(at, lower + 19.0, "middle", "", &x.number(tick));
        }
        self.put(format_args!(
            "<path d=\"M{left:.1} {upper:.1}V{lower:.1}H{right:.1}\" stroke=\"#222\" fill=\"none\"/>"
        ));
        self.text(f64::midpoint(left, right), lower + 38.0, "middle", "", &named(&chart.x));
        let middle = f64::midpoint(upper, lower);
        let turned = format!(" transform=\"rotate(-90 16 {middle:.1})\"");
        self.text(16.0, middle, "middle", &turned, &named(&chart.y));
    }

    /// Rows of samples and names; answers the y beneath them.
    fn legend(&mut self, chart: &Chart, top: f64, width: f64) -> f64 {
        let mut at = (LEFT, top);
        let mut empty = true;
        let series = chart.series.iter().enumerate().filter(|(_, series)| !series.name.is_empty());
        let lines = series.map(|(index, series)| (series.name.as_str(), Some((series, index)), 0));
        let envelopes = chart.envelopes.iter().map(|envelope| (envelope.name.as_str(), None, envelope.colour));
        for (name, series, colour) in lines.chain(envelopes) {
            let needs = SAMPLE + 6.0 + text_width(name) + 14.0;
            if at.0 + needs > width && at.0 > LEFT {
                at = (LEFT, at.1 + LEGEND_ROW);
            }
            let middle = at.1 + 9.0;
            match series {
                Some((series, index)) if series.shape == Shape::Dots => {
                    let fill = style(series, index).0;
                    let x = at.0 + SAMPLE / 2.0;
                    self.put(format_args!("<circle cx=\"{x:.1}\" cy=\"{middle:.1}\" r=\"2.5\" fill=\"{fill}\"/>"));
                }
                Some((series, index)) => {
                    let stroke = stroke(series, index);
                    self.put(format_args!("<path d=\"M{:.1} {middle:.1}h{SAMPLE:.1}\"{stroke}/>", at.0));
                }
                None => {
                    let (x, y, fill) = (at.0, middle - 5.0, PALETTE[colour % PALETTE.len()]);
                    self.put(format_args!(
                        "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{SAMPLE:.1}\" height=\"10\" fill=\"{fill}\" fill-opacity=\"0.2\"/>"
                    ));
                }
            }
            self.text(at.0 + SAMPLE + 6.0, middle + 4.0, "start", "", name);
            at.0 += needs;
            empty = false;
        }
        if empty { top } else { at.1 + LEGEND_ROW }
    }

    fn series(&mut self, series: &Series, index: usize, x: &Scale, y: &Scale) {
        let mut path = String::new();
        for piece in pieces(series) {
            for (row, (px, py)) in thin(&pixels(piece, x, y)).into_iter().enumerate() {
                let _ = match series.shape {
                    // A line of no length with round ends is a dot, in a fifth of the bytes of a circle.
                    Shape::Dots => write!(path, "M{px:.1} {py:.1}h0"),
                    Shape::Line | Shape::Wide | Shape::Pale => {
                        write!(path, "{}{px:.1} {py:.1}", if row == 0 { 'M' } else { 'L' })
                    }
                };
            }
        }
        self.put(format_args!("<path d=\"{path}\"{}/>", stroke(series, index)));
    }

    fn annotations(&mut self, chart: &Chart, x: &Scale, y: &Scale, (left, upper, right, lower): (f64, f64, f64, f64)) {
        const LINE: &str =
            " stroke=\"#555\" stroke-dasharray=\"1 3\" stroke-linecap=\"round\" stroke-width=\"1.5\" fill=\"none\"";
        for rule in &chart.rules {
            match rule {
                Rule::Horizontal { y: value, label } => {
                    let at = y.at(*value).clamp(upper, lower);
                    self.put(format_args!("<path d=\"M{left:.1} {at:.1}H{right:.1}\"{LINE}/>"));
                    self.text(right - 4.0, at - 5.0, "end", HALO, label);
                }
                Rule::Vertical { x: value, label } => {
                    let at = x.at(*value).clamp(left, right);
                    self.put(format_args!("<path d=\"M{at:.1} {upper:.1}V{lower:.1}\"{LINE}/>"));
                    let (dx, anchor) = side(at, right, label);
                    self.text(at + dx, lower - 8.0, anchor, HALO, label);
                }
            }
        }
        for marker in chart.markers.iter().filter(|marker| marker.x.is_finite() && marker.y.is_finite()) {
            let (px, py) = (x.at(marker.x).clamp(left, right), y.at(marker.y).clamp(upper, lower));
            self.put(format_args!(
                "<circle cx=\"{px:.1}\" cy=\"{py:.1}\" r=\"4\" fill=\"#fff\" stroke=\"#000\" stroke-width=\"1.5\"/>"
            ));
            let (dx, anchor) = side(px, right, &marker.label);
            let dy = if lower - py < 24.0 { -9.0 } else { 17.0 };
            self.text(px + dx, py + dy, anchor, HALO, &marker.label);
        }
    }
}

/// A white rim that keeps a label legible over lines.
const HALO: &str = " stroke=\"#fff\" stroke-width=\"3\" paint-order=\"stroke\"";

/// To the right of a point, or to the left where the label would leave the picture.
fn side(at: f64, right: f64, label: &str) -> (f64, &'static str) {
    if at + 6.0 + text_width(label) > right { (-6.0, "end") } else { (6.0, "start") }
}

fn text_width(text: &str) -> f64 {
    text.chars().count() as f64 * CHARACTER
}

fn named(axis: &Axis) -> String {
    if matches!(axis.unit.as_str(), "" | "-") { axis.label.clone() } else { format!("{} in {}", axis.label, axis.unit) }
}

fn style(series: &Series, index: usize) -> (&'static str, &'static str) {
    let dash = if series.shape == Shape::Dots { 0 } else { series.dash.unwrap_or(index) };
    (PALETTE[series.colour.unwrap_or(index) % PALETTE.len()], DASHES[dash % DASHES.len()])
}

fn stroke(series: &Series, index: usize) -> String {
    let (colour, dash) = style(series, index);
    if series.shape == Shape::Dots {
        return format!(" stroke=\"{colour}\" stroke-width=\"4\" stroke-linecap=\"round\" fill=\"none\"");
    }
    let dash = if dash.is_empty() { String::new() } else { format!(" stroke-dasharray=\"{dash}\"") };
    format!(" stroke=\"{colour}\" stroke-width=\"1.8\" stroke-linejoin=\"round\" fill=\"none\"{dash}")
}

fn pixels(piece: &[(f64, f64)], x: &Scale, y: &Scale) -> Vec<(f64, f64)> {
    piece.iter().map(|point| (x.at(point.0), y.at(point.1))).collect()
}

/// Of the points in one pixel column the first, lowest, highest and last, in their order: a spike of one sample stays.
fn thin(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut kept = Vec::new();
    // Only neighbours of one column are joined, so a curve that runs back and forth is drawn right as well.
    for column in points.chunk_by(|a, b| a.0.floor() == b.0.floor()) {
        let by_height = |a: &&usize, b: &&usize| column[**a].1.total_cmp(&column[**b].1);
        let rows: Vec<usize> = (0..column.len()).collect();
        let (low, high) = (rows.iter().min_by(by_height), rows.iter().max_by(by_height));
        let mut chosen: Vec<usize> = [rows.first(), low, high, rows.last()].into_iter().flatten().copied().collect();
        chosen.sort_unstable();
        chosen.dedup();
        kept.extend(chosen.into_iter().map(|row| column[row]));
    }
    kept
}
