//! Line charts as SVG, the same bytes for the same numbers: pictures that stand alone ([`Figure::svg`]), and charts of a
//! page that follow its width and colours and can be zoomed ([`Chart::live`]).
//!
//! Own code: kuva is 70,000 lines with a breaking release every month, poloto has no bands, charts-rs draws categories;
//! none thins out spike-safe or writes title and description.

mod axis;
#[cfg(feature = "internals")]
mod draw;
mod live;
mod map;
mod room;
mod thin;

pub use live::Live;
pub use map::{Cell, Map};

/// Colours of Okabe and Ito (2008), distinct to colour-blind readers; their yellow is left out, it fades on paper.
pub const PALETTE: [&str; 7] = ["#0072b2", "#d55e00", "#009e73", "#000000", "#cc79a7", "#56b4e9", "#a06a00"];

/// Dash patterns, so that lines stay apart in black and white.
pub const DASHES: [&str; 4] = ["", "8 3", "2.5 2.5", "9 3 2 3"];

/// Ticks that the x axis of a chart in a page aims at.
const TICK_COUNT: f64 = 7.0;

/// An axis: what it shows and in which unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// What is shown, in words.
    pub label: String,
    /// Unit of the numbers; `-` for none.
    pub unit: String,
    /// From, to, in this unit; `None` takes in all that is drawn.
    pub range: Option<(f64, f64)>,
    /// Names of 0, 1 and so on, in place of numbers; only in pages.
    pub names: Vec<String>,
    /// Whether equal distances are equal ratios; only in pages.
    pub logarithmic: bool,
}

impl Axis {
    /// An axis whose range follows what is drawn.
    pub fn new(label: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { label: label.into(), unit: unit.into(), range: None, names: Vec::new(), logarithmic: false }
    }

    /// The same axis over a given range, in its unit. What lies outside is cut off.
    #[must_use]
    pub fn over(mut self, from: f64, to: f64) -> Self {
        self.range = Some((from, to));
        self
    }
}

/// How the points of a series are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    Line,
    /// A wide, pale line, on which the lines of models stay visible: what was measured.
    Wide,
    /// A thin, pale line: samples around their mean.
    Pale,
    /// Single points, such as measured samples.
    Dots,
}

/// One curve. A point that is not finite breaks the line.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// In the legend; an empty name stays out of it.
    pub name: String,
    /// x and y in the units of the axes.
    pub points: Vec<(f64, f64)>,
    pub shape: Shape,
    /// Index into [`PALETTE`]; `None` takes the series' place in the panel.
    pub colour: Option<usize>,
    /// Index into [`DASHES`]; `None` takes the series' place in the panel.
    pub dash: Option<usize>,
}

impl Series {
    /// A line through points.
    pub fn line(name: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Self { name: name.into(), points, shape: Shape::Line, colour: None, dash: None }
    }

    /// What was measured: wide and pale, in the colour that it has on every page.
    pub fn measured(points: Vec<(f64, f64)>) -> Self {
        Self { shape: Shape::Wide, ..Self::line("measured", points) }.styled(3, 0)
    }

    /// A thin, pale line through samples.
    pub fn pale(name: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Self { shape: Shape::Pale, ..Self::line(name, points) }
    }

    /// Single points.
    pub fn dots(name: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Self { shape: Shape::Dots, ..Self::line(name, points) }
    }

    /// The same in a colour and with a dash of one's own, as indices into [`PALETTE`] and [`DASHES`].
    #[must_use]
    pub fn styled(mut self, colour: usize, dash: usize) -> Self {
        (self.colour, self.dash) = (Some(colour), Some(dash));
        self
    }
}

/// A shaded region between two curves, such as a confidence interval. A point that is not finite breaks it.
#[derive(Debug, Clone, PartialEq)]
pub struct Envelope {
    /// In the legend.
    pub name: String,
    /// x, low, high in the units of the axes.
    pub points: Vec<(f64, f64, f64)>,
    /// Index into [`PALETTE`].
    pub colour: usize,
}

/// A shaded interval of x over the whole height, such as an operating phase.
#[derive(Debug, Clone, PartialEq)]
pub struct Band {
    pub from: f64,
    pub to: f64,
    /// At the top of the band; left out where it is wider than the band.
    pub label: String,
}

/// A point that is marked and named.
#[derive(Debug, Clone, PartialEq)]
pub struct Marker {
    pub x: f64,
    pub y: f64,
    pub label: String,
}

/// A straight line across the panel.
#[derive(Debug, Clone, PartialEq)]
pub enum Rule {
    /// At one y: a limit, a printed value.
    Horizontal { y: f64, label: String },
    /// At one x: the moment of a detection.
    Vertical { x: f64, label: String },
}

impl Rule {
    /// Its name; empty for none.
    pub fn label(&self) -> &str {
        let (Self::Horizontal { label, .. } | Self::Vertical { label, .. }) = self;
        label
    }
}

/// One panel.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    pub title: String,
    pub x: Axis,
    pub y: Axis,
    pub series: Vec<Series>,
    pub envelopes: Vec<Envelope>,
    pub bands: Vec<Band>,
    pub markers: Vec<Marker>,
    pub rules: Vec<Rule>,
    /// Height in px, legend and axis included; `None` takes that of the figure.
    pub height: Option<f64>,
}

impl Chart {
    /// A panel with these curves and nothing else; the other fields may be filled afterwards.
    pub fn new(title: impl Into<String>, x: Axis, y: Axis, series: Vec<Series>) -> Self {
        let (envelopes, bands, markers, rules) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { title: title.into(), x, y, series, envelopes, bands, markers, rules, height: None }
    }

    /// The same panel in a height of its own, in px.
    #[must_use]
    pub fn high(mut self, height: f64) -> Self {
        self.height = Some(height);
        self
    }
}

/// A picture: panels under each other.
#[cfg(feature = "internals")]
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Name of the picture for those who do not see it.
    pub title: String,
    /// What the picture shows, for those who do not see it.
    pub description: String,
    pub panels: Vec<Chart>,
    /// Width in px.
    pub width: f64,
    /// Height of a panel that has none of its own, in px, legend and axis included.
    pub panel_height: f64,
}

#[cfg(feature = "internals")]
impl Figure {
    /// A picture 760 px wide, its panels 300 px high.
    pub fn new(title: impl Into<String>, description: impl Into<String>, panels: Vec<Chart>) -> Self {
        Self { title: title.into(), description: description.into(), panels, width: 760.0, panel_height: 300.0 }
    }

    /// The picture as one `<svg>` element, which stands alone as a file and inside a page.
    pub fn svg(&self) -> String {
        draw::figure(self)
    }
}

/// The stretches of a series between points that are not finite.
fn pieces(series: &Series) -> impl Iterator<Item = &[(f64, f64)]> {
    series.points.split(|(x, y)| !x.is_finite() || !y.is_finite()).filter(|piece| !piece.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn panel(points: Vec<(f64, f64)>) -> Chart {
        Chart::new("a < b & c", Axis::new("time", "s"), Axis::new("pressure", "bar"), vec![Series::line("p_A", points)])
    }

    #[test]
    fn a_spike_of_one_sample_survives_a_hundred_thousand_points() {
        let spike = 54_321;
        let points = (0..100_000).map(|row| (f64::from(row), if row == spike { 9.0 } else { 1.0 })).collect();
        let mut chart = panel(points);
        chart.y.range = Some((0.0, 10.0));
        let svg = Figure::new("t", "d", vec![chart.clone()]).svg();
        assert!(svg.len() < 60_000, "{} bytes", svg.len());
        let heights = |svg: &str| {
            let path = svg
                .split("<path d=\"")
                .map(|rest| rest.split('"').next().unwrap())
                .find(|d| d.contains('L'))
                .unwrap()
                .to_owned();
            let y = |pair: &str| pair.split(' ').nth(1).unwrap().parse::<f64>().unwrap();
            path.split(['M', 'L']).filter(|pair| !pair.trim().is_empty()).map(y).fold(f64::INFINITY, f64::min)
        };
        let top = heights(&svg);
        chart.series[0].points = vec![(0.0, 1.0), (1.0, 9.0)];
        assert_eq!(top, heights(&Figure::new("t", "d", vec![chart]).svg()));
    }

    #[test]
    fn text_is_escaped_and_the_picture_named() {
        let svg = Figure::new("5 > 4", "what \"it\" shows", vec![panel(vec![(0.0, 1.0), (1.0, 2.0)])]).svg();
        for part in ["role=\"img\"", "<title>5 &gt; 4</title>", "<desc>what &quot;it&quot;", "a &lt; b &amp; c", "bar"]
        {
            assert!(svg.contains(part), "{part} is missing");
        }
        assert_eq!(svg, Figure::new("5 > 4", "what \"it\" shows", vec![panel(vec![(0.0, 1.0), (1.0, 2.0)])]).svg());
    }

    #[test]
    fn nothing_to_draw_and_broken_numbers_still_give_a_picture() {
        let hole = vec![(0.0, 1.0), (1.0, f64::NAN), (2.0, 1.0), (f64::INFINITY, 3.0)];
        for points in [vec![], vec![(f64::NAN, f64::NAN)], vec![(3.0, 3.0)], hole, vec![(0.0, 1e300), (1.0, -1e300)]] {
            let mut chart = panel(points.clone());
            chart.series.push(Series::dots("s", points));
            let svg = Figure::new("t", "d", vec![chart]).svg();
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        }
    }
}
