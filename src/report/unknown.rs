//! A curve without a formula in words: where it rises, how high and how wide, or how it grows, and a formula of that shape for the rig file.

use super::brief::wrapped;
use crate::estimation::profile::QUANTILE;
use crate::learn::evaluated::Conclusion;
use crate::learn::fitted_model::FittedModel;
use crate::learn::suggest::Suggestion;
use crate::number::{in_unit, rounded, text};
use crate::physics::effect::spline::{Curve, HEIGHTS};
use crate::rig::{InstalledEffect, Rig};
use crate::units::Unit;

/// Places of the curve that are looked at.
const PLACES: usize = 400;
/// A rise is told where it is so many times what the curve is elsewhere.
const RISE: f64 = 3.0;
/// A bell falls to half its height at this many of its widths `w` of `exp(-((x - x0) / w)^2)`.
const HALF: f64 = 0.832_554_611_157_697_8;

/// Exponents that a flow is tried to grow with; below 1 the library has its laws, and a formula no slope at its beginning.
const EXPONENTS: [f64; 4] = [1.0, 1.5, 2.0, 3.0];
/// Share of the curve, weighed by what is known of it, that a power has to describe, and by how much a later beginning has to be better.
const DESCRIBED: f64 = 0.9;
const LATER: f64 = 0.5;

/// The law that a curve without a formula describes, with first values.
#[derive(Debug, Clone, PartialEq)]
pub struct Rise {
    form: Form,
    /// Node at which it acts.
    node: String,
    /// A name for the law, and those of its parameters, that nothing of the rig has.
    name: String,
    names: [String; 3],
    /// The whole curve: mm and N, or bar and L/min.
    pub points: Vec<(f64, f64)>,
}

#[derive(Debug, Clone, PartialEq)]
enum Form {
    /// `height exp(-((x - middle) / width)^2)`, N and mm, of `friction` or `force`.
    Bell { what: &'static str, height: f64, middle: f64, width: f64 },
    /// `flow (max(p - from, 0) / (at - from))^exponent`, L/min and bar.
    Power { flow: f64, at: f64, from: f64, exponent: f64 },
}

impl Rise {
    /// That of the curve which comes nearest where no effect of the library explains the misfit; `None` where there is none.
    pub fn of_suggestion(suggestion: &Suggestion) -> Option<Self> {
        let is_unknown = suggestion.conclusion == Conclusion::UnknownEffect;
        let best = suggestion.judged.first().filter(|best| is_unknown && best.supported)?;
        Self::of(&best.trial)
    }

    /// The law that the curves of a fitted model describe; `None` where none is described so.
    pub fn of(trial: &FittedModel) -> Option<Self> {
        trial.rig.effects.iter().rev().find_map(|effect| Self::of_effect(trial, effect))
    }

    fn of_effect(trial: &FittedModel, effect: &InstalledEffect) -> Option<Self> {
        let rig = &trial.rig;
        let (kind, place) = effect.id.split_once('@')?;
        let heights: Vec<f64> = effect.parameters.iter().take(HEIGHTS).map(|&index| trial.values[index]).collect();
        let reach = effect.parameters.first()? + HEIGHTS;
        let reach = trial.values.get(reach).copied().filter(|reach| heights.len() == HEIGHTS && *reach > 0.0)?;
        let sigmas = effect.parameters.iter().take(HEIGHTS);
        let sigmas: Vec<f64> = sigmas.map(|index| trial.sigmas.get(index).copied().unwrap_or(0.0)).collect();
        let curve = Curve::new(&heights);
        let all: Vec<f64> = (0..=PLACES).map(|at| curve.at(at as f64 / PLACES as f64)).collect();
        let (form, node, units) = match kind {
            "empirical-friction" | "empirical-load" => {
                let what = if kind == "empirical-friction" { "friction" } else { "force" };
                let cylinder = rig.components.iter().find(|component| component.name == place)?;
                let rod = cylinder.card.ports.iter().position(|port| port.name == "rod")?;
                (bell(what, &all, &sigmas, reach)?, rig.nodes.get(*cylinder.ports.get(rod)?)?.name.clone(), ["mm", "N"])
            }
            "empirical-leakage" => (power(&all, &sigmas, reach)?, place.to_owned(), ["bar", "L/min"]),
            _ => return None,
        };
        let [along, size] = units.map(|unit| Unit::parse(unit).ok());
        let (along, size) = (along?, size?);
        let names = match form {
            Form::Bell { .. } => ["F", "x0", "w"],
            Form::Power { .. } => ["q_r", "p_0", ""],
        };
        let point = |(at, one): (usize, &f64)| {
            (in_unit(at as f64 / PLACES as f64 * reach, &along), rounded(size.difference_from_si(*one), 5))
        };
        let name = match &form {
            Form::Bell { what, .. } => format!("extra-{what}"),
            Form::Power { .. } => "extra-leakage".to_owned(),
        };
        Some(Self {
            points: all.iter().enumerate().map(point).collect(),
            form,
            node,
            name: numbered(rig, &name),
            names: names.map(|name| free(rig, name)),
        })
    }

    /// What it is, in a sentence.
    pub fn sentence(&self) -> String {
        match &self.form {
            Form::Bell { what, height, middle, width } => format!(
                "The curve says: extra {what} of {} N around {} mm, {} mm wide.",
                text(*height),
                text(*middle),
                text(*width)
            ),
            Form::Power { flow, at, from, exponent } => {
                let begins = if *from > 0.0 { format!(" from {} bar on", text(*from)) } else { String::new() };
                format!(
                    "The curve says: {} L/min to the tank at {} bar, growing{begins} with the power {} of the pressure.",
                    text(*flow),
                    text(*at),
                    text(*exponent)
                )
            }
        }
    }

    /// The formula in lines of a text; `rig` is the file that lacks it.
    pub fn lines(&self, rig: &str) -> Vec<String> {
        let mut lines = wrapped(&format!("As a law, to be put into {rig}:"), "  ");
        lines.extend(self.formula().lines().map(|line| format!("  {line}")));
        lines
    }

    /// A formula of that shape with first values, for the rig file: the text of `[own_effects]`.
    pub fn formula(&self) -> String {
        let Self { node, name, names: [size, place, width], .. } = self;
        match &self.form {
            Form::Bell { what, height, middle, width: wide } => {
                let motion = if *what == "friction" { format!(" * tanh({node}.v / [1 mm/s])") } else { String::new() };
                format!(
                    "[own_effects.{name}]\nmeaning = \"Extra {what} at one place of the stroke.\"\nat = \"{node}\"\n\
                     force = \"-{size} * exp(-(({node}.x - {place}) / {width})^2){motion}\"\n\
                     parameters.{size} = {{ neutral = \"0 N\", first = \"{height} N\" }}\n\
                     parameters.{place} = {{ first = \"{middle} mm\", bounds = [\"{} mm\", \"{} mm\"] }}\n\
                     parameters.{width} = {{ first = \"{wide} mm\", bounds = [\"{} mm\", \"{} mm\"] }}\n",
                    text(rounded(middle - 2.0 * wide, 3)),
                    text(rounded(middle + 2.0 * wide, 3)),
                    text(rounded(wide / 5.0, 2)),
                    text(rounded(wide * 5.0, 2))
                )
            }
            Form::Power { flow, at, from, exponent } => {
                let (reference, top) =
                    (text(rounded(at - from, 3)), text(rounded((0.9 * at).max(0.5 * (from + at)), 3)));
                format!(
                    "[own_effects.{name}]\nmeaning = \"Extra flow to the tank that grows with the pressure.\"\nat = \"{node}\"\n\
                     flow = \"{size} * (max({node}.p - {place}, [0 bar]) / [{reference} bar])^{exponent}\"\n\
                     parameters.{size} = {{ neutral = \"0 L/min\", first = \"{flow} L/min\" }}\n\
                     parameters.{place} = {{ first = \"{from} bar\", bounds = [\"0 bar\", \"{top} bar\"] }}\n"
                )
            }
        }
    }
}

/// Standard deviations of the heights that make the curve at one of its places, the largest of them; 0 where the record says nothing of one.
fn spread(sigmas: &[f64], at: usize) -> f64 {
    let first = (at as f64 / PLACES as f64 * (HEIGHTS - 3) as f64) as usize;
    let around = &sigmas[first.min(HEIGHTS - 4)..=(first + 3).min(HEIGHTS - 1)];
    if around.contains(&0.0) { 0.0 } else { around.iter().copied().fold(0.0, f64::max) }
}

/// The single rise of a curve over position, `sigmas` the standard deviations of its heights, N; `way` in m.
fn bell(what: &'static str, all: &[f64], sigmas: &[f64], way: f64) -> Option<Form> {
    let is_known = |at: usize| spread(sigmas, at) > 0.0;
    let mut sorted: Vec<f64> = (0..=PLACES).filter(|&at| is_known(at)).map(|at| all[at]).collect();
    sorted.sort_by(f64::total_cmp);
    let base = *sorted.get(sorted.len() / 2)?;
    let above: Vec<f64> = all.iter().map(|one| one - base).collect();
    // Where the record hardly was, a curve may be anything: no more of it counts than is certain.
    let certain = |at: usize| if is_known(at) { above[at].abs() - QUANTILE * spread(sigmas, at) } else { 0.0 };
    let top = (0..=PLACES).max_by(|&a, &b| certain(a).total_cmp(&certain(b)))?;
    let size = |at: usize| above[at] * above[top].signum();
    let height = size(top);
    let left = (0..top).rev().find(|&at| size(at) < 0.5 * height)?;
    let right = (top..=PLACES).find(|&at| size(at) < 0.5 * height)?;
    // What is as high elsewhere is no single rise.
    let (from, to) = (top.saturating_sub(2 * (top - left)), top + 2 * (right - top));
    let elsewhere = (0..=PLACES).filter(|at| *at < from || *at > to).map(certain).fold(0.0, f64::max);
    let millimetre = Unit::parse("mm").ok()?;
    let along = |places: f64| in_unit(places / PLACES as f64 * way, &millimetre);
    (certain(top) > 0.0 && certain(top) >= RISE * elsewhere).then(|| Form::Bell {
        what,
        height: rounded(above[top], 2),
        middle: rounded(along(top as f64), 3),
        width: rounded(along((right - left) as f64) / (2.0 * HALF), 2),
    })
}

/// The power of the pressure with which a curve grows, `sigmas` the standard deviations of its heights, m3/s, 0 where the record says
/// nothing of them; `reach` in Pa.
fn power(all: &[f64], sigmas: &[f64], reach: f64) -> Option<Form> {
    let weight = |at: usize| match spread(sigmas, at) {
        0.0 => 0.0,
        sigma => sigma.powi(-2),
    };
    let shown: Vec<(f64, f64, f64)> =
        (0..=PLACES).map(|at| (at as f64 / PLACES as f64, all[at], weight(at))).filter(|one| one.2 > 0.0).collect();
    let top = shown.last()?.0;
    let whole: f64 = shown.iter().map(|one| one.2 * one.1 * one.1).sum();
    let fitted = |from: f64, exponent: f64| {
        let form = |share: f64| ((share - from).max(0.0) / (top - from)).powf(exponent);
        let sum = |of: &dyn Fn(&(f64, f64, f64)) -> f64| shown.iter().map(of).sum::<f64>();
        let flow = sum(&|one| one.2 * one.1 * form(one.0)) / sum(&|one| one.2 * form(one.0).powi(2));
        (sum(&|one| one.2 * (one.1 - flow * form(one.0)).powi(2)), flow, from, exponent)
    };
    let best = |from: f64| {
        let tried = EXPONENTS.into_iter().map(|exponent| fitted(from, exponent));
        tried.filter(|one| one.0.is_finite()).min_by(|a, b| a.0.total_cmp(&b.0))
    };
    let at_once = best(0.0)?;
    let steps = (0..PLACES).map(|at| at as f64 / PLACES as f64).take_while(|from| *from < 0.9 * top);
    let later = steps.filter_map(best).min_by(|a, b| a.0.total_cmp(&b.0))?;
    let (left, flow, from, exponent) = if later.0 < LATER * at_once.0 { later } else { at_once };
    let (bar, litres) = (Unit::parse("bar").ok()?, Unit::parse("L/min").ok()?);
    (flow > 0.0 && left <= (1.0 - DESCRIBED) * whole).then(|| Form::Power {
        flow: rounded(litres.difference_from_si(flow), 2),
        at: rounded(bar.difference_from_si(top * reach), 3),
        from: rounded(bar.difference_from_si(from * reach), 3),
        exponent,
    })
}

/// The name of a law, with a number behind it where the rig has one of that name already.
fn numbered(rig: &Rig, name: &str) -> String {
    let taken = |name: &str| rig.own_effects.iter().any(|own| own.name == name);
    let mut names = std::iter::once(name.to_owned()).chain((2..).map(|number| format!("{name}-{number}")));
    names.find(|name| !taken(name)).unwrap_or_default()
}

/// A name, or one like it where a formula sees something of that name already: an input, a node, a component.
fn free(rig: &Rig, name: &str) -> String {
    let inputs = rig.inputs.iter().map(|input| input.column.as_str());
    let nodes = rig.nodes.iter().map(|node| node.name.as_str());
    let mut all = inputs.chain(nodes).chain(rig.components.iter().map(|component| component.name.as_str()));
    if all.any(|one| one == name) { format!("{name}_extra") } else { name.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_formula_is_one_that_a_rig_file_takes() {
        let form = Form::Bell { what: "friction", height: 900.0, middle: 100.0, width: 12.0 };
        let names = ["F", "x0", "w"].map(str::to_owned);
        let (node, name) = ("piston".to_owned(), "extra-friction".to_owned());
        let rise = Rise { form, node, name, names, points: Vec::new() };
        assert_eq!(rise.sentence(), "The curve says: extra friction of 900 N around 100 mm, 12 mm wide.");
        let path = "fixtures/telescopic/rig.toml";
        let read = |path: &str, law: &str| {
            Rig::parse(std::path::Path::new(path), std::fs::read_to_string(path).unwrap() + "\n" + law)
        };
        let rig = read(path, &rise.formula()).unwrap();
        let places = rig.effect_places();
        assert!(places.iter().any(|placed| rig.effect_id(placed) == "extra-friction@piston"));
        // A second law of that kind.
        assert_eq!(numbered(&rig, "extra-friction"), "extra-friction-2");
        // The press has an input `F`.
        let path = "fixtures/press/rig.toml";
        let press = read(path, "").unwrap();
        let names = ["F", "x0", "w"].map(|name| free(&press, name));
        assert_eq!(names, ["F_extra", "x0", "w"]);
        let law = Rise { node: "ram".to_owned(), names, ..rise }.formula();
        assert!(read(path, &law).is_ok(), "{law}");
    }

    #[test]
    fn what_a_curve_does_where_the_record_hardly_was_is_no_second_rise() {
        let share = |at: usize| at as f64 / PLACES as f64;
        let rise = |at: usize| 4000.0 * (-((share(at) - 0.6) / 0.04).powi(2)).exp();
        let end = |at: usize| if at < PLACES / 5 { 5000.0 } else { 0.0 };
        let all: Vec<f64> = (0..=PLACES).map(|at| rise(at) + end(at)).collect();
        let known: Vec<f64> = (0..HEIGHTS).map(|height| if height < 7 { 3000.0 } else { 50.0 }).collect();
        let form = bell("friction", &all, &known, 0.56).unwrap();
        let Form::Bell { height, middle, width, .. } = form else { panic!("{form:?}") };
        assert_eq!((height, middle), (4000.0, 336.0));
        approx::assert_relative_eq!(width, 0.04 * 560.0, max_relative = 0.1);
        // Two rises that are both certain are not one.
        assert_eq!(bell("friction", &all, &[50.0; HEIGHTS], 0.56), None);
    }

    #[test]
    fn a_flow_that_grows_with_the_pressure_gives_its_power_and_where_it_begins() {
        // 2 L/min at 150 bar with the square of what is above 50 bar; nothing is known beyond.
        let litres = 1e-3 / 60.0;
        let flow = |bar: f64| 2.0 * litres * ((bar - 50.0).max(0.0) / 100.0).powi(2);
        let all: Vec<f64> = (0..=PLACES).map(|at| flow(200.0 * at as f64 / PLACES as f64)).collect();
        let sigmas: Vec<f64> = (0..HEIGHTS).map(|height| if height < 15 { 0.01 * litres } else { 0.0 }).collect();
        let form = power(&all, &sigmas, 200e5).unwrap();
        let Form::Power { flow, at, from, exponent } = form else { panic!("{form:?}") };
        approx::assert_relative_eq!(flow, 2.0 * ((at - 50.0) / 100.0).powi(2), max_relative = 0.03);
        approx::assert_relative_eq!(from, 50.0, max_relative = 0.02);
        assert_eq!(exponent, 2.0);
        let (node, name) = ("A".to_owned(), "extra-leakage".to_owned());
        let law = Rise { form, node, name, names: ["q_r", "p_0", ""].map(str::to_owned), points: Vec::new() };
        let path = std::path::Path::new("fixtures/telescopic/rig.toml");
        let text = std::fs::read_to_string(path).unwrap() + "\n" + &law.formula();
        let rig = Rig::parse(path, text).unwrap();
        assert!(rig.effect_places().iter().any(|placed| rig.effect_id(placed) == "extra-leakage@A"));
        // A curve that falls is no leak that grows.
        let falls: Vec<f64> = all.iter().map(|one| 3.0 * litres - one).collect();
        assert_eq!(power(&falls, &[0.01 * litres; HEIGHTS], 200e5), None);
    }
}
