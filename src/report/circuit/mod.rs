//! The hydraulic circuit of a rig as a drawing with symbols after ISO 1219-1.

mod centre;
mod place;
mod symbol;

use std::collections::BTreeMap;
use std::fmt::Write;

use self::place::{Layout, Placed, layout};
use self::symbol::Symbol;
use crate::diagnosis::FaultReport;
use crate::learn::result::EffectParameter;
use crate::number::{rounded, with_unit};
use crate::physics::card::PortKind;
use crate::report::diagnosis_tables::sized;
use crate::report::escape;
use crate::report::suggestion::CURVE;
use crate::rig::{Quantity, Rig, Target};

/// Mean width of a character, px; names and faults are bold.
const CHARACTER: f64 = 6.4;
const BOLD: f64 = 7.4;
/// Room around the drawing, px.
const RIM: f64 = 14.0;

/// What is marked: a part, sensor, node or joined effect, and what is the matter with it.
#[derive(Debug, Clone, PartialEq)]
pub struct Marked {
    /// What it is called where nobody sees the drawing.
    pub id: String,
    /// Such as `cylinder`, `sensor.p_A`, `A` or `external-leakage@A`.
    pub owner: String,
    /// Such as `clearance 0.2 mm`.
    pub text: String,
}

impl Marked {
    /// A parameter with its value and unit: `cylinder.clearance`, `0.2 mm`.
    pub fn of(id: &str, value: &str) -> Self {
        let (owner, parameter) = id.rsplit_once('.').unwrap_or((id, ""));
        Self { id: id.to_owned(), owner: owner.to_owned(), text: format!("{parameter} {value}") }
    }

    /// An effect with its first value, at what it joins or changes, else at its place; `None` without any value.
    pub fn effect(rig: &Rig, effect: &str, parameters: &[EffectParameter]) -> Option<Self> {
        let first = parameters.first()?;
        let size =
            if parameters.len() > CURVE { String::new() } else { with_unit(rounded(first.value, 3), &first.unit) };
        let is_part = |name: &str| rig.components.iter().any(|component| component.name == name);
        let joined = Self::of(&first.id, &size).owner;
        let owner = match effect.split_once('@') {
            Some((_, sensor)) if rig.sensors.iter().any(|one| one.name == sensor) => format!("sensor.{sensor}"),
            Some((_, place)) if !is_part(&joined) => place.to_owned(),
            _ => joined,
        };
        let kind = effect.split('@').next().unwrap_or(effect).replace('-', " ");
        Some(Self { id: effect.to_owned(), owner, text: format!("{kind} {size}").trim_end().to_owned() })
    }

    /// Faults with their sizes.
    pub fn faults(faults: &[&FaultReport]) -> Vec<Self> {
        faults.iter().map(|fault| Self::of(&fault.id, &sized(fault))).collect()
    }
}

struct Drawing<'a> {
    rig: &'a Rig,
    marks: &'a [Marked],
    out: String,
    /// Left, top, right, bottom of what has been drawn.
    ends: (f64, f64, f64, f64),
}

/// The circuit as one `<svg>` element with these marks.
pub fn svg(rig: &Rig, marks: &[Marked]) -> String {
    let ends = (f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY);
    let mut drawing = Drawing { rig, marks, out: String::new(), ends };
    let letters = |component: usize| {
        let name = &rig.components[component].name;
        let texts = drawing.wrong(name);
        texts.iter().chain([name]).map(|text| text.chars().count()).max().unwrap_or(0)
    };
    let layout = layout(rig, &letters);
    drawing.lines(&layout);
    layout.placed.iter().for_each(|placed| drawing.component(placed));
    let (left, top, right, bottom) = drawing.ends;
    if left > right {
        return String::new();
    }
    let (width, height) = (right - left + 2.0 * RIM, bottom - top + 2.0 * RIM);
    let marked: Vec<&str> = marks.iter().map(|mark| mark.id.as_str()).collect();
    let names: Vec<&str> = layout.placed.iter().map(|placed| rig.components[placed.component].name.as_str()).collect();
    let what = format!(
        "hydraulic circuit with {}; {}",
        names.join(", "),
        if marked.is_empty() { "nothing marked".to_owned() } else { format!("marked: {}", marked.join(", ")) }
    );
    format!(
        "<svg class=\"circuit\" role=\"img\" aria-label=\"{}\" viewBox=\"{:.0} {:.0} {width:.0} {height:.0}\" width=\"{width:.0}\" \
         height=\"{height:.0}\">\n{}</svg>\n",
        escape(&what),
        left - RIM,
        top - RIM,
        drawing.out
    )
}

impl Drawing<'_> {
    fn put(&mut self, text: std::fmt::Arguments<'_>) {
        // Writing to a String cannot fail.
        let _ = self.out.write_fmt(text);
        self.out.push('\n');
    }

    fn reach(&mut self, x: (f64, f64), y: (f64, f64)) {
        let (left, top, right, bottom) = self.ends;
        self.ends = (left.min(x.0), top.min(y.0), right.max(x.1), bottom.max(y.1));
    }

    fn text(&mut self, (x, y): (f64, f64), anchor: &str, class: &str, text: &str) {
        if text.is_empty() {
            return;
        }
        let character = if matches!(class, "name" | "wrong") { BOLD } else { CHARACTER };
        let width = text.chars().count() as f64 * character;
        let left = match anchor {
            "end" => x - width,
            "middle" => x - 0.5 * width,
            _ => x,
        };
        self.reach((left, left + width), (y - 11.0, y + 3.0));
        let text = escape(text);
        self.put(format_args!(
            "<text class=\"{class}\" x=\"{x:.0}\" y=\"{y:.0}\" text-anchor=\"{anchor}\">{text}</text>"
        ));
    }

    /// What is wrong with a component or sensor: `clearance 0.2 mm`.
    fn wrong(&self, owner: &str) -> Vec<String> {
        self.marks.iter().filter(|mark| mark.owner == owner).map(|mark| mark.text.clone()).collect()
    }

    /// Sensors of some quantities at a target, one text each, with whether something is wrong with it.
    fn sensors(&self, at: &Target, quantities: &[Quantity]) -> Vec<(String, bool)> {
        let here =
            self.rig.sensors.iter().filter(|sensor| sensor.target == *at && quantities.contains(&sensor.quantity));
        here.map(|sensor| {
            let wrong = self.wrong(&format!("sensor.{}", sensor.name));
            if wrong.is_empty() {
                (sensor.name.clone(), false)
            } else {
                (format!("{}: {}", sensor.name, wrong.join(", ")), true)
            }
        })
        .collect()
    }

    /// The lines of the nodes, with junctions, names and sensors.
    fn lines(&mut self, layout: &Layout) {
        let mut meet: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
        for placed in &layout.placed {
            for &(_, node, x, y) in &placed.ends {
                match layout.lines.get(&node) {
                    None => self.tank(x, y),
                    Some(&line) => {
                        let out = if y > placed.y { 1.0 } else { -1.0 };
                        // Around the symbol where the line lies on its other side.
                        let x = if (line - y) * out < 0.0 {
                            let (beside, off) = (x - 46.0, y + 8.0 * out);
                            self.put(format_args!("<path d=\"M{x:.0} {y:.0}V{off:.0}H{beside:.0}V{line:.0}\"/>"));
                            beside
                        } else {
                            self.put(format_args!("<path d=\"M{x:.0} {y:.0}V{line:.0}\"/>"));
                            x
                        };
                        meet.entry(node).or_default().push(x);
                    }
                }
            }
        }
        for (node, mut places) in meet {
            let y = layout.lines[&node];
            places.sort_by(f64::total_cmp);
            let (Some(&left), Some(&right)) = (places.first(), places.last()) else { continue };
            self.put(format_args!("<path d=\"M{left:.0} {y:.0}H{right:.0}\"/>"));
            self.reach((left, right), (y, y));
            for x in places.iter().filter(|x| **x > left + 1.0 && **x < right - 1.0) {
                self.put(format_args!("<circle class=\"full\" cx=\"{x:.0}\" cy=\"{y:.0}\" r=\"3\"/>"));
            }
            let to_left = left + right < -1.0;
            let (x, anchor) = if to_left { (left - 7.0, "end") } else { (right + 7.0, "start") };
            let sensors = self.sensors(&Target::Node(node), &[Quantity::Pressure, Quantity::Level]);
            let name = self.rig.nodes[node].name.clone();
            self.text((x, y - 2.0), anchor, "line", &name);
            let mut below = y + 11.0;
            for wrong in self.wrong(&name) {
                self.text((x, below), anchor, "wrong", &wrong);
                below += 13.0;
            }
            for (text, wrong) in sensors {
                self.text((x, below), anchor, if wrong { "wrong" } else { "sensor" }, &text);
                below += 13.0;
            }
        }
    }

    /// A tank at the end of a line.
    fn tank(&mut self, x: f64, y: f64) {
        self.put(format_args!("<path d=\"M{x:.0} {y:.0}v9m-10-6v9h20v-9\"/>"));
        self.reach((x - 10.0, x + 10.0), (y, y + 12.0));
    }

    fn component(&mut self, placed: &Placed) {
        let component = &self.rig.components[placed.component];
        let (x, y, symbol) = (placed.x, placed.y, placed.symbol);
        let wrong = self.wrong(&component.name);
        let (wide, high) = (symbol.half_width(), symbol.half_height());
        if !wrong.is_empty() {
            self.put(format_args!(
                "<rect class=\"mark\" x=\"{:.0}\" y=\"{:.0}\" width=\"{:.0}\" height=\"{:.0}\" rx=\"8\"/>",
                x - symbol.left() - 6.0,
                y - high - 3.0,
                wide + symbol.left() + 12.0,
                2.0 * high + 6.0
            ));
        }
        let turn = if placed.turned { " rotate(180)" } else { "" };
        let mut lines = symbol.svg();
        if symbol == Symbol::DirectionalValve {
            lines.push_str(&format!("<path d=\"{}\"/>", centre::path(self.rig, placed.component, symbol.ends())));
        }
        self.put(format_args!("<g transform=\"translate({x:.0} {y:.0}){turn}\">{lines}</g>"));
        self.reach((x - wide - 6.0, x + wide + 6.0), (y - high - 6.0, y + high + 6.0));
        let name = component.name.clone();
        if symbol == Symbol::Cylinder {
            self.text((x - 60.0, y - 30.0), "start", "name", &name);
            let beside = x - 60.0 + (name.chars().count() as f64 + 2.0) * 7.0;
            self.text((beside, y - 30.0), "start", "wrong", &wrong.join(", "));
            self.body(placed);
        } else {
            let x = x + wide + 12.0;
            self.text((x, y + 4.0), "start", "name", &name);
            for (line, wrong) in wrong.iter().enumerate() {
                self.text((x, y + 18.0 + 14.0 * line as f64), "start", "wrong", wrong);
            }
        }
        let mut below = y + 18.0 + 14.0 * wrong.len() as f64;
        for state in 0..component.card.states.len() {
            for (text, wrong) in self.sensors(&Target::State(placed.component, state), &[Quantity::State]) {
                self.text((x + wide + 12.0, below), "start", if wrong { "wrong" } else { "sensor" }, &text);
                below += 13.0;
            }
        }
        for &(port, _, end_x, end_y) in &placed.ends {
            let sensors = self.sensors(&Target::Port(placed.component, port), &[Quantity::Flow]);
            let left = end_x < x;
            for (text, wrong) in sensors {
                let at = (end_x + if left { -5.0 } else { 5.0 }, end_y + if end_y > y { 12.0 } else { -3.0 });
                self.text(at, if left { "end" } else { "start" }, if wrong { "wrong" } else { "sensor" }, &text);
            }
        }
    }

    /// What acts on the rod of a cylinder, and what is measured of it.
    fn body(&mut self, placed: &Placed) {
        let (rig, x, y) = (self.rig, placed.x + 98.0, placed.y);
        let component = &rig.components[placed.component];
        let mut mechanical = component.card.ports.iter().zip(&component.ports);
        let Some((_, &body)) = mechanical.find(|(port, _)| port.kind == PortKind::Mechanical) else { return };
        let mut below = y + 18.0;
        for (index, other) in rig.parts() {
            if index == placed.component || !other.ports.contains(&body) {
                continue;
            }
            if symbol::of(other.card) == Symbol::Force {
                self.put(format_args!("<path class=\"force\" d=\"M{:.0} {y:.0}H{x:.0}m9-5l-9 5 9 5\"/>", x + 38.0));
                self.reach((x, x + 38.0), (y - 5.0, y + 5.0));
            }
            let inputs: Vec<&str> = other.inputs.iter().map(|&input| rig.inputs[input].name.as_str()).collect();
            let text = if inputs.is_empty() { other.name.clone() } else { inputs.join(", ") };
            self.text((x + 10.0, below), "start", "sensor", &text);
            below += 13.0;
            for wrong in self.wrong(&other.name) {
                self.text((x + 10.0, below), "start", "wrong", &wrong);
                below += 13.0;
            }
        }
        for (index, other) in rig.parts().filter(|(_, other)| other.ports.contains(&body)) {
            let ports = other.ports.iter().enumerate().filter(|(_, node)| **node == body);
            let forces = ports.flat_map(|(port, _)| self.sensors(&Target::Port(index, port), &[Quantity::Force]));
            for (text, wrong) in forces.collect::<Vec<_>>() {
                self.text((x + 10.0, below), "start", if wrong { "wrong" } else { "sensor" }, &text);
                below += 13.0;
            }
        }
        let motion = self.sensors(&Target::Node(body), &[Quantity::Position, Quantity::Velocity]);
        for (number, (text, wrong)) in motion.into_iter().enumerate() {
            let at = (x + 10.0, y - 10.0 - 13.0 * number as f64);
            self.text(at, "start", if wrong { "wrong" } else { "sensor" }, &text);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Boxes of the symbols of a rig, as centre and half sizes.
    fn boxes(layout: &Layout) -> Vec<(f64, f64, f64, f64)> {
        let one = |placed: &Placed| (placed.x, placed.y, placed.symbol.half_width(), placed.symbol.half_height());
        layout.placed.iter().map(one).collect()
    }

    #[test]
    fn every_rig_is_drawn_with_nothing_upon_another() {
        for name in ["telescopic", "press", "two_tanks", "cascaded_tanks", "own_filter"] {
            let rig = Rig::read(format!("fixtures/{name}/rig.toml")).unwrap();
            let layout = layout(&rig, &|component| rig.components[component].name.len());
            let shown = rig.components.iter().filter(|component| symbol::of(component.card).has_place()).count();
            assert_eq!(layout.placed.len(), shown, "{name}");
            let boxes = boxes(&layout);
            for (index, a) in boxes.iter().enumerate() {
                for b in &boxes[..index] {
                    let apart = (a.0 - b.0).abs() >= a.2 + b.2 || (a.1 - b.1).abs() >= a.3 + b.3;
                    assert!(apart, "{name}: {a:?} {b:?}");
                }
            }
            let drawn = svg(&rig, &[]);
            for sensor in &rig.sensors {
                assert!(drawn.contains(&format!(">{}</text>", sensor.name)), "{name}: {}", sensor.name);
            }
            assert_eq!(drawn, svg(&rig, &[]));
        }
    }

    #[test]
    fn a_long_name_does_not_reach_the_next_symbol() {
        let mut rig = Rig::read("fixtures/telescopic/rig.toml").unwrap();
        rig.give_effect(&rig.placed("external-leakage@A").unwrap(), &[]).unwrap();
        let layout = layout(&rig, &|component| rig.components[component].name.len());
        for a in layout.placed.iter().filter(|placed| placed.symbol != Symbol::Cylinder) {
            let end = a.x + a.symbol.half_width() + 12.0 + 7.0 * rig.components[a.component].name.len() as f64;
            let next = layout.placed.iter().filter(|b| b.y == a.y && b.x > a.x);
            for b in next {
                let name = &rig.components[a.component].name;
                assert!(end <= b.x - b.symbol.left(), "{name}: {end}, next symbol at {}", b.x);
            }
        }
    }

    #[test]
    fn what_an_effect_joins_is_a_box_and_a_margin_is_not_drawn() {
        let mut rig = Rig::read("fixtures/telescopic/rig.toml").unwrap();
        let shown = |rig: &Rig| layout(rig, &|_| 1).placed.len();
        let before = shown(&rig);
        rig.give_margin("external-leakage@B").unwrap();
        assert_eq!(shown(&rig), before);
        rig.give_effect(&rig.placed("external-leakage@A").unwrap(), &[]).unwrap();
        let with_leak = layout(&rig, &|_| 1);
        assert_eq!(with_leak.placed.iter().filter(|placed| placed.symbol == Symbol::Box).count(), 1);
        assert_eq!(with_leak.placed.len(), before + 1);
    }

    #[test]
    fn what_is_wrong_is_framed_and_named() {
        let rig = Rig::read("fixtures/telescopic/rig.toml").unwrap();
        let fault = |id: &str, unit: &str| FaultReport {
            id: id.to_owned(),
            meaning: String::new(),
            value: 0.2,
            unit: unit.to_owned(),
            healthy: 0.0,
            healthy_sigma: 0.0,
            bounds: [0.0, 1.0],
            limit: None,
            ci95: [None, None],
            change95: None,
            present: true,
            probability: 1.0,
            identifiable: crate::estimation::Identifiable::Bounded,
            remark: None,
            biased: false,
        };
        let (clearance, offset) = (fault("cylinder.clearance", "mm"), fault("sensor.p_A.offset", "bar"));
        let drawn = svg(&rig, &Marked::faults(&[&clearance, &offset]));
        assert_eq!(drawn.matches("class=\"mark\"").count(), 1);
        for text in
            [">clearance 0.2 mm</text>", ">p_A: offset 0.2 bar</text>", "marked: cylinder.clearance, sensor.p_A.offset"]
        {
            assert!(drawn.contains(text), "{text}");
        }
        assert!(!svg(&rig, &[]).contains("class=\"mark\""));
    }
}
