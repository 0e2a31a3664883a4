//! Where a label has room: what is drawn in a chart, as straight pieces on its grid.

use super::axis::{HIGH, Scale, WIDE};
use super::{Chart, Rule, Shape, pieces};

/// Width of a chart and of one beside others for which labels are placed, px; they stretch with the page.
const WIDTHS: [f64; 2] = [700.0, 250.0];
/// Mean width of a character and height of a line, px.
const CHARACTER: f64 = 7.0;
const LINE: f64 = 15.0;
/// Between a label and the line that it names, px.
const GAP: f64 = 4.0;

type Point = (f64, f64);

/// What stands in the way of labels.
pub(super) struct Room {
    drawn: Vec<[Point; 2]>,
    /// Grid units of a pixel, along and up.
    pixel: Point,
}

/// Where a label stands beside its line, and which of its ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    Left,
    Middle,
    Right,
}

impl Room {
    /// Of a chart so many px high, its axes laid onto the grid; `narrow` where it stands beside others.
    pub fn new(
        chart: &Chart,
        (x, y): (&Scale, &Scale),
        height: &dyn Fn(f64) -> f64,
        (narrow, high): (bool, f64),
    ) -> Self {
        let on_grid = |p: &Point| (x.at(p.0), y.at(height(p.1)));
        let mut drawn: Vec<[Point; 2]> = Vec::new();
        for series in &chart.series {
            for piece in pieces(series) {
                match series.shape {
                    Shape::Line | Shape::Wide | Shape::Pale => {
                        drawn.extend(piece.windows(2).map(|pair| [on_grid(&pair[0]), on_grid(&pair[1])]))
                    }
                    Shape::Dots => drawn.extend(piece.iter().map(|point| [on_grid(point); 2])),
                }
            }
        }
        drawn.extend(chart.rules.iter().filter_map(|rule| match rule {
            Rule::Vertical { x: at, .. } => Some([(x.at(*at), 0.0), (x.at(*at), HIGH)]),
            Rule::Horizontal { .. } => None,
        }));
        Self { drawn, pixel: (WIDE / WIDTHS[usize::from(narrow)], HIGH / high) }
    }

    /// The side at which the label of a horizontal line at this height of the grid is crossed least; the right one before others.
    pub fn along(&self, level: f64, label: &str) -> Side {
        let wide = self.wide(label);
        let (top, bottom) = (level - LINE * self.pixel.1, level - self.pixel.1);
        let crossed = |side: &Side| {
            let left = match side {
                Side::Right => WIDE - wide,
                Side::Middle => 0.5 * (WIDE - wide),
                Side::Left => 0.0,
            };
            self.crossings((left, left + wide), (top, bottom))
        };
        [Side::Right, Side::Middle, Side::Left].into_iter().min_by_key(crossed).unwrap_or(Side::Right)
    }

    /// The side of a vertical line at which the label at its top is crossed least and stays in the chart; the right one before
    /// the left.
    pub fn beside(&self, at: f64, label: &str) -> Side {
        let (wide, gap) = (self.wide(label), GAP * self.pixel.0);
        let crossed = |side: &Side| {
            let (left, right) = match side {
                Side::Left => (at - gap - wide, at - gap),
                _ => (at + gap, at + gap + wide),
            };
            (left < 0.0 || right > WIDE, self.crossings((left, right), (0.0, LINE * self.pixel.1)))
        };
        [Side::Right, Side::Left].into_iter().min_by_key(crossed).unwrap_or(Side::Right)
    }

    fn wide(&self, label: &str) -> f64 {
        CHARACTER * self.pixel.0 * label.chars().count() as f64
    }

    fn crossings(&self, x: Point, y: Point) -> usize {
        self.drawn.iter().filter(|piece| crosses(piece, x, y)).count()
    }
}

/// Whether a straight piece meets a box (clipping after Liang and Barsky, ACM Transactions on Graphics 3 (1984)).
fn crosses([from, to]: &[Point; 2], x: Point, y: Point) -> bool {
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for (start, end, (low, high)) in [(from.0, to.0, x), (from.1, to.1, y)] {
        let way = end - start;
        if way == 0.0 {
            if start < low || start > high {
                return false;
            }
            continue;
        }
        let (first, last) = ((low - start) / way, (high - start) / way);
        enter = enter.max(first.min(last));
        leave = leave.min(first.max(last));
    }
    enter <= leave
}

#[cfg(test)]
mod tests {
    use super::super::{Axis, Series};
    use super::*;

    fn room(points: Vec<Point>, rules: Vec<Rule>) -> Room {
        let (along, up) = (Axis::new("x", "-").over(0.0, 1.0), Axis::new("y", "-").over(0.0, 1.0));
        let x = Scale::new(&along, std::iter::empty(), (0.0, WIDE), WIDE / 4.0, false);
        let y = Scale::new(&up, std::iter::empty(), (HIGH, 0.0), HIGH / 4.0, true);
        let mut chart = Chart::new("t", along, up, vec![Series::line("s", points)]);
        chart.rules = rules;
        Room::new(&chart, (&x, &y), &|value| value, (true, 130.0))
    }

    #[test]
    fn a_label_stands_where_nothing_crosses_it() {
        let level = 0.5 * HIGH;
        assert_eq!(room(vec![(0.0, 0.0), (1.0, 0.0)], Vec::new()).along(level, "95 %"), Side::Right);
        let parabola = |k: i32| (f64::from(k) / 50.0, 0.5 * ((f64::from(k) - 25.0) / 24.0).powi(2));
        assert_eq!(room((0..=50).map(parabola).collect(), Vec::new()).along(level, "95 %"), Side::Middle);
        let falling = vec![(0.0, 0.2), (0.5, 0.2), (0.51, 1.0), (0.9, 1.0), (1.0, 0.0)];
        assert_eq!(room(falling, Vec::new()).along(level, "95 %"), Side::Left);
    }

    #[test]
    fn a_label_stays_in_the_chart_and_off_other_lines() {
        let flat = vec![(0.0, 0.1), (1.0, 0.1)];
        assert_eq!(room(flat.clone(), Vec::new()).beside(0.2 * WIDE, "healthy"), Side::Right);
        assert_eq!(room(flat.clone(), Vec::new()).beside(0.95 * WIDE, "healthy"), Side::Left);
        let other = Rule::Vertical { x: 0.55, label: String::new() };
        assert_eq!(room(flat, vec![other]).beside(0.5 * WIDE, "healthy"), Side::Left);
    }
}
