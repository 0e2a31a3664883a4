//! Figures 6 to 14 of the paper from this project's model, and the numbers that the paper prints.

use std::error::Error;

use borescope::internals::report::plot::{Axis, Band, Chart, Figure, Marker, Rule, Series};

use super::strokes::{Bench, FULL_LOAD, Faults, HEALTHY, OPENS, SERIES, Steady, Stroke, saturates_at, sweep};

/// The stroke ends short of this, mm; the stop gives by micrometres.
const END: f64 = 169.5;

/// A number that the paper prints, and what comes out here.
#[derive(Debug, Clone)]
pub struct Row {
    pub quantity: &'static str,
    pub unit: &'static str,
    pub paper: &'static str,
    pub here: String,
}

/// All that the figures and the table show, solved once.
#[derive(Debug)]
pub struct Results {
    pub healthy: Steady,
    /// Table 2, in its order.
    pub series: [Steady; 3],
    /// 0.2 mm of clearance alone, under the full load and under 4850 N.
    pub leaks: [Steady; 2],
    pub clearance: Sweep,
    pub orifice: Sweep,
    pub opening: Sweep,
    /// Healthy, then table 2: whole outstrokes.
    pub strokes: Vec<Stroke>,
}

/// One fault at many sizes.
#[derive(Debug)]
pub struct Sweep {
    pub size: Vec<f64>,
    pub steady: Vec<Steady>,
}

impl Sweep {
    fn run(bench: &Bench, size: Vec<f64>, faults: impl Fn(f64) -> Faults) -> Result<Self, Box<dyn Error>> {
        let steady = size.iter().map(|&size| bench.steady(faults(size), FULL_LOAD)).collect::<Result<_, _>>()?;
        Ok(Self { size, steady })
    }

    pub fn velocities(&self) -> Vec<f64> {
        self.steady.iter().map(|steady| steady.velocity).collect()
    }

    fn curve(&self, of: impl Fn(&Steady) -> f64) -> Vec<(f64, f64)> {
        self.size.iter().zip(&self.steady).map(|(&size, steady)| (size, of(steady))).collect()
    }
}

impl Results {
    pub fn of(bench: &Bench) -> Result<Self, Box<dyn Error>> {
        let [one, two, three] = SERIES;
        let leak = Faults { clearance: 0.2, ..HEALTHY };
        let strokes = [(HEALTHY, 4.0), (one, 20.0), (two, 9.0), (three, 10.0)];
        Ok(Self {
            healthy: bench.steady(HEALTHY, FULL_LOAD)?,
            series: [bench.steady(one, FULL_LOAD)?, bench.steady(two, FULL_LOAD)?, bench.steady(three, FULL_LOAD)?],
            leaks: [bench.steady(leak, FULL_LOAD)?, bench.steady(leak, 4850.0)?],
            clearance: Sweep::run(bench, sweep(0.0, 0.4, 80), |clearance| Faults { clearance, ..HEALTHY })?,
            // Thinner holes than 0.2 mm pass a hundredth of the pump's flow: the stroke stands.
            orifice: Sweep::run(bench, sweep(0.2, 5.0, 96), |orifice| Faults { orifice, ..HEALTHY })?,
            opening: Sweep::run(bench, sweep(0.0, 1.0, 100), |opening| Faults { opening, ..HEALTHY })?,
            strokes: strokes
                .into_iter()
                .map(|(faults, duration)| bench.stroke(faults, FULL_LOAD, duration))
                .collect::<Result<_, _>>()?,
        })
    }

    /// Series by falling deviation, such as `2 > 1 > 3`.
    pub fn order(&self, of: impl Fn(&Steady) -> f64) -> String {
        let mut order = [0, 1, 2];
        order.sort_by(|&a, &b| of(&self.series[b]).total_cmp(&of(&self.series[a])));
        order.map(|series| (series + 1).to_string()).join(" > ")
    }

    pub fn table(&self) -> Vec<Row> {
        let row = |quantity, unit, paper, here: String| Row { quantity, unit, paper, here };
        let [one, two, three] = &self.series;
        let at = |sweep: &Sweep| format!("{:.2}", saturates_at(&sweep.size, &sweep.velocities()));
        vec![
            row("flow into the healthy cylinder", "L/min", "5.5", format!("{:.2}", self.healthy.flow_a)),
            row("speed of the healthy piston", "m/s", "0.07", format!("{:.4}", self.healthy.velocity)),
            row("orifice from which the speed no longer rises", "mm", "2", at(&self.orifice)),
            row("opening from which the speed no longer rises", "-", "0.5", at(&self.opening)),
            row("leakage, series 1 (0.25 mm)", "L/min", "2.64", format!("{:.2}", one.leakage)),
            row("leakage, series 2 (0.15 mm)", "L/min", "0.55", format!("{:.2}", two.leakage)),
            row("leakage, series 3 (0.2 mm)", "L/min", "not printed", format!("{:.2}", three.leakage)),
            row("leakage at 0.2 mm alone, 5400 N", "L/min", "1.37", format!("{:.2}", self.leaks[0].leakage)),
            row("leakage at 0.2 mm alone, 4850 N", "L/min", "1.37", format!("{:.2}", self.leaks[1].leakage)),
            row("series by opening deviation (20)", "-", "2 > 1 > 3", self.order(|series| series.lost_opening)),
            row("series by blockage deviation (10)", "-", "3 > 1 > 2", self.order(|series| series.blockage)),
            row("series by leakage (4)", "-", "1 > 3 > 2", self.order(|series| series.leakage)),
            row("flow, series 1 beside series 2", "L/min", "more", format!("{:.2} : {:.2}", one.flow_a, two.flow_a)),
            row("speed, series 1 beside series 2", "m/s", "less", format!("{:.4} : {:.4}", one.velocity, two.velocity)),
            row("(4) as printed, series 1", "L/min", "2.64", format!("{:.2}", one.leakage_printed)),
            row("(4) as printed, series 2", "L/min", "0.55", format!("{:.2}", two.leakage_printed)),
        ]
    }

    /// Number and picture of figures 6 to 14.
    pub fn figures(&self) -> Vec<(usize, Figure)> {
        vec![
            (6, self.figure_6()),
            (7, self.figure_7()),
            (8, self.figure_8()),
            (9, self.figure_9()),
            (10, self.figure_10()),
            (11, self.figure_11()),
            (
                12,
                self.over_time("Figure 12: Lost flow of the directional valve, (20)", "lost flow", (0.0, 12.0), |s| {
                    &s.lost_opening
                }),
            ),
            (
                13,
                self.over_time("Figure 13: Lost flow of the flow control valve, (10)", "lost flow", (0.0, 40.0), |s| {
                    &s.blockage
                }),
            ),
            (14, self.figure_14()),
        ]
    }

    fn figure_6(&self) -> Figure {
        let x = || Axis::new("diametral clearance of the piston", "mm").over(0.0, 0.4);
        let sweep = &self.clearance;
        let flows = vec![
            Series::line("into A", sweep.curve(|s| s.flow_a)),
            Series::line("out of B", sweep.curve(|s| s.flow_b)),
        ];
        let differences = vec![
            Series::line("(4) divided by A1 \u{2212} A2", sweep.curve(|s| s.leakage)),
            Series::line("(4) as printed, divided by A1 + A2", sweep.curve(|s| s.leakage_printed)).styled(1, 1),
        ];
        let mut leakage = Chart::new("(b) Leakage by estimator (4)", x(), litres("leakage"), differences);
        leakage.markers = vec![Marker { x: 0.2, y: 1.37, label: "paper: 1.37".into() }];
        let speed = Chart::new("(b) Speed", x(), speed_axis(), vec![Series::line("", sweep.curve(|s| s.velocity))]);
        let flows = Chart::new("(a) Flow at the ports", x(), litres("flow"), flows);
        let text = "Flows at the ports, leakage by (4) and speed of the piston over the clearance: the leakage grows with \
                    the cube of the clearance until the piston stands at 0.31 mm; the printed form reads a seventh.";
        stacked("Figure 6: internal leakage of the cylinder", text, vec![flows, leakage, speed])
    }

    fn figure_7(&self) -> Figure {
        let x = || Axis::new("diameter of the throttle orifice", "mm").over(0.0, 5.0);
        let sweep = &self.orifice;
        let flows = vec![
            Series::line("actual", sweep.curve(|s| s.flow_p)),
            Series::line("healthy valve at the same pressures", sweep.curve(|s| s.healthy_control)),
        ];
        let flows = Chart::new("(a) Flow through the flow control valve", x(), litres("flow"), flows);
        let lost = vec![Series::line("", sweep.curve(|s| s.blockage))];
        let lost = Chart::new("(b) Lost flow, (10)", x(), litres("lost flow"), lost);
        let speed = vec![Series::line("", sweep.curve(|s| s.velocity))];
        let mut speed = Chart::new("(b) Speed", x(), speed_axis(), speed);
        speed.rules = vec![Rule::Vertical { x: 2.0, label: "paper: flat from 2 mm".into() }];
        let text = "Actual and healthy flow, their difference and the speed over the orifice: the speed rises up to 2 mm \
                    and is flat above, where the difference still falls from 14 to 0 L/min.";
        stacked("Figure 7: blockage of the flow control valve", text, vec![flows, lost, speed])
    }

    fn figure_8(&self) -> Figure {
        let x = || Axis::new("opening coefficient", "-").over(0.0, 1.0);
        let sweep = &self.opening;
        let flows = vec![
            Series::line("actual", sweep.curve(|s| s.flow_p)),
            Series::line("healthy valve at the same pressures", sweep.curve(|s| s.healthy_valve)),
        ];
        let flows = Chart::new("(a) Flow from P to A of the directional valve", x(), litres("flow"), flows);
        let lost = vec![Series::line("", sweep.curve(|s| s.lost_opening))];
        let lost = Chart::new("(b) Lost flow, (20)", x(), litres("lost flow"), lost);
        let speed = vec![Series::line("", sweep.curve(|s| s.velocity))];
        let mut speed = Chart::new("(b) Speed", x(), speed_axis(), speed);
        speed.rules = vec![Rule::Vertical { x: 0.5, label: "paper: flat from 0.5".into() }];
        let text = "Actual and healthy flow, their difference and the speed over the opening coefficient: the speed rises \
                    up to 0.47 and is flat above, where the difference still falls to 0.";
        stacked("Figure 8: opening of the directional valve", text, vec![flows, lost, speed])
    }

    fn figure_9(&self) -> Figure {
        let strokes = self.strokes.iter().enumerate();
        let lines = strokes.map(|(index, stroke)| line(index, &stroke.time, &stroke.position, stroke.time.len()));
        let x = Axis::new("time", "s").over(0.0, 20.0);
        let chart = Chart::new("Displacement of the piston", x, Axis::new("displacement", "mm"), lines.collect());
        let text = "Displacement over time: the healthy piston arrives first, then series 2, series 3 and series 1.";
        stacked("Figure 9: displacements", text, vec![chart])
    }

    fn figure_10(&self) -> Figure {
        let text = "Flow into the cylinder until the end of each stroke: 5.5 L/min healthy, less in all series; series 1 \
                    takes more than series 2 although it is slower.";
        let chart = self.panel("Flow into the cylinder", "flow", (0.0, 6.0), true, |stroke| &stroke.flow_a);
        stacked("Figure 10: flow into the cylinder", text, vec![chart])
    }

    fn figure_11(&self) -> Figure {
        let actual = self.panel("Actual", "flow", (0.0, 6.0), true, |stroke| &stroke.flow_p);
        let healthy =
            self.panel("Healthy valve at the same pressures", "flow", (0.0, 14.0), true, |s| &s.healthy_valve);
        let text =
            "Flow into port P of the directional valve, and what the healthy valve would pass at the same pressures.";
        stacked("Figure 11: flow at port P of the directional valve", text, vec![actual, healthy])
    }

    fn figure_14(&self) -> Figure {
        let mut corrected = self.panel("(4) divided by A1 \u{2212} A2", "leakage", (-0.5, 3.5), false, |s| &s.leakage);
        corrected.rules = [(2.64, "paper, series 1: 2.64"), (0.55, "paper, series 2: 0.55")]
            .map(|(y, label)| Rule::Horizontal { y, label: label.into() })
            .into();
        let printed = self.panel("(4) as printed", "leakage", (-0.5, 3.5), false, |s| &s.leakage_printed);
        let text =
            "Leakage of the cylinder by (4): series 1 leaks most, series 2 least; as printed all read a seventh.";
        stacked("Figure 14: leakage of the cylinder", text, vec![corrected, printed])
    }

    fn over_time(&self, title: &str, y: &str, range: (f64, f64), of: impl Fn(&Stroke) -> &[f64]) -> Figure {
        let text = "Deviation of each series until the end of its stroke; a longer line is a slower stroke.";
        let panel = title.split_once(": ").map_or(title, |(_, panel)| panel);
        stacked(title, text, vec![self.panel(panel, y, range, false, of)])
    }

    /// A panel over time with a line per stroke up to its end, the healthy one first where it says something.
    fn panel(&self, title: &str, y: &str, range: (f64, f64), healthy: bool, of: impl Fn(&Stroke) -> &[f64]) -> Chart {
        let strokes = self.strokes.iter().enumerate().skip(usize::from(!healthy));
        let lines = strokes.map(|(index, stroke)| {
            let end = stroke.position.iter().position(|&x| x > END).unwrap_or(stroke.time.len());
            line(index, &stroke.time, of(stroke), end)
        });
        let x = Axis::new("time", "s").over(0.0, 20.0);
        let mut chart = Chart::new(title, x, litres(y).over(range.0, range.1), lines.collect());
        chart.bands = vec![Band { from: 0.0, to: OPENS, label: String::new() }];
        chart
    }
}

fn line(index: usize, time: &[f64], values: &[f64], end: usize) -> Series {
    // The healthy line in black, each series in one colour through all figures.
    let (name, colour) = [("healthy", 3), ("series 1", 0), ("series 2", 1), ("series 3", 2)][index];
    Series::line(name, time.iter().copied().zip(values.iter().copied()).take(end).collect()).styled(colour, index)
}

fn litres(label: &str) -> Axis {
    Axis::new(label, "L/min")
}

fn speed_axis() -> Axis {
    Axis::new("speed", "m/s")
}

fn stacked(title: &str, text: &str, panels: Vec<Chart>) -> Figure {
    let mut figure = Figure::new(title, text, panels);
    figure.panel_height = if figure.panels.len() > 1 { 260.0 } else { 320.0 };
    figure
}
