//! A curve without a formula in words: where it rises, how high and how wide, and a formula of that shape for the rig file.

use super::brief::wrapped;
use crate::learn::evaluated::Conclusion;
use crate::learn::fitted_model::FittedModel;
use crate::learn::suggest::Suggestion;
use crate::number::{in_unit, rounded, text};
use crate::physics::effect::spline::{Curve, HEIGHTS};
use crate::rig::{InstalledEffect, Rig};

/// Places of the curve that are looked at.
const PLACES: usize = 400;
/// A rise is told where it is so many times what the curve is elsewhere.
const RISE: f64 = 3.0;
/// A bell falls to half its height at this many of its widths `w` of `exp(-((x - x0) / w)^2)`.
const HALF: f64 = 0.832_554_611_157_697_8;

/// A rise of a curve versus position.
#[derive(Debug, Clone, PartialEq)]
pub struct Rise {
    /// What rises, in words: `friction`, `force`.
    what: &'static str,
    /// N, mm, mm: height, middle, width `w` of the bell.
    height: f64,
    middle: f64,
    width: f64,
    /// Node of the body.
    body: String,
    /// Names of height, middle and width that nothing of the rig has.
    names: [String; 3],
    /// The whole curve: mm, N.
    pub points: Vec<(f64, f64)>,
}

impl Rise {
    /// That of the curve which comes nearest where no effect of the library explains the misfit; `None` where there is none.
    pub fn of_suggestion(suggestion: &Suggestion) -> Option<Self> {
        let is_unknown = suggestion.conclusion == Conclusion::UnknownEffect;
        let best = suggestion.judged.first().filter(|best| is_unknown && best.supported)?;
        Self::of(&best.trial)
    }

    /// The rise that the curves of a fitted model describe; `None` where none is described so.
    pub fn of(trial: &FittedModel) -> Option<Self> {
        trial.rig.effects.iter().rev().find_map(|effect| Self::of_effect(trial, effect))
    }

    fn of_effect(trial: &FittedModel, effect: &InstalledEffect) -> Option<Self> {
        let rig = &trial.rig;
        let (kind, place) = effect.id.split_once('@')?;
        let what = match kind {
            "empirical-friction" => "friction",
            "empirical-load" => "force",
            _ => return None,
        };
        let heights: Vec<f64> = effect.parameters.iter().take(HEIGHTS).map(|&index| trial.values[index]).collect();
        let way = effect.parameters.first()? + HEIGHTS;
        let way = trial.values.get(way).copied().filter(|way| heights.len() == HEIGHTS && *way > 0.0)?;
        let cylinder = rig.components.iter().find(|component| component.name == place)?;
        let rod = cylinder.card.ports.iter().position(|port| port.name == "rod")?;
        let body = rig.nodes.get(*cylinder.ports.get(rod)?)?.name.clone();
        let curve = Curve::new(&heights);
        let all: Vec<f64> = (0..=PLACES).map(|at| curve.at(at as f64 / PLACES as f64)).collect();
        let mut sorted = all.clone();
        sorted.sort_by(f64::total_cmp);
        let base = sorted[PLACES / 2];
        let above: Vec<f64> = all.iter().map(|one| one - base).collect();
        let top = (0..=PLACES).max_by(|&a, &b| above[a].abs().total_cmp(&above[b].abs()))?;
        let size = |at: usize| above[at] * above[top].signum();
        let height = size(top);
        let left = (0..top).rev().find(|&at| size(at) < 0.5 * height)?;
        let right = (top..=PLACES).find(|&at| size(at) < 0.5 * height)?;
        // What is as high elsewhere is no single rise.
        let (from, to) = (top.saturating_sub(2 * (top - left)), top + 2 * (right - top));
        let elsewhere = (0..=PLACES).filter(|at| *at < from || *at > to).map(|at| above[at].abs()).fold(0.0, f64::max);
        let millimetre = crate::units::Unit::parse("mm").ok()?;
        let along = |places: f64| in_unit(places / PLACES as f64 * way, &millimetre);
        (height >= RISE * elsewhere).then(|| Self {
            what,
            height: rounded(above[top], 2),
            middle: rounded(along(top as f64), 3),
            width: rounded(along((right - left) as f64) / (2.0 * HALF), 2),
            body,
            names: ["F", "x0", "w"].map(|name| free(rig, name)),
            points: all.iter().enumerate().map(|(at, one)| (along(at as f64), rounded(*one, 5))).collect(),
        })
    }

    /// What it is, in a sentence.
    pub fn sentence(&self) -> String {
        format!(
            "The curve says: extra {} of {} N around {} mm, {} mm wide.",
            self.what,
            text(self.height),
            text(self.middle),
            text(self.width)
        )
    }

    /// Sentence and formula in lines of a text.
    pub fn lines(&self) -> Vec<String> {
        let mut lines = wrapped(&self.sentence(), "  ");
        lines.push("As a law, for the rig file; `suggest` judges it like any other effect:".to_owned());
        lines.extend(self.formula().lines().map(|line| format!("  {line}")));
        lines
    }

    /// A formula of that shape with first values, for the rig file: the text of `[own_effects]`.
    pub fn formula(&self) -> String {
        let Self { what, height, middle, width, body, names: [force, x0, w], .. } = self;
        let motion = if *what == "friction" { format!(" * tanh({body}.v / [1 mm/s])") } else { String::new() };
        format!(
            "[own_effects.extra-{what}]\nmeaning = \"Extra {what} at one place of the stroke.\"\nat = \"{body}\"\n\
             force = \"-{force} * exp(-(({body}.x - {x0}) / {w})^2){motion}\"\n\
             parameters.{force} = {{ neutral = \"0 N\", first = \"{height} N\" }}\n\
             parameters.{x0} = {{ first = \"{middle} mm\", bounds = [\"{} mm\", \"{} mm\"] }}\n\
             parameters.{w} = {{ first = \"{width} mm\", bounds = [\"{} mm\", \"{} mm\"] }}\n",
            text(rounded(middle - 2.0 * width, 3)),
            text(rounded(middle + 2.0 * width, 3)),
            text(rounded(width / 5.0, 2)),
            text(rounded(width * 5.0, 2))
        )
    }
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
        let (body, points) = ("piston".to_owned(), Vec::new());
        let names = ["F", "x0", "w"].map(str::to_owned);
        let rise = Rise { what: "friction", height: 900.0, middle: 100.0, width: 12.0, body, names, points };
        assert_eq!(rise.sentence(), "The curve says: extra friction of 900 N around 100 mm, 12 mm wide.");
        let path = "fixtures/telescopic/rig.toml";
        let with_formula = std::fs::read_to_string(path).unwrap() + "\n" + &rise.formula();
        let rig = crate::rig::Rig::parse(std::path::Path::new(path), with_formula).unwrap();
        let places = rig.effect_places();
        assert!(places.iter().any(|placed| rig.effect_id(placed) == "extra-friction@piston"));
        // The press has an input `F`.
        let path = "fixtures/press/rig.toml";
        let text = std::fs::read_to_string(path).unwrap();
        let press = Rig::parse(std::path::Path::new(path), text.clone()).unwrap();
        let names = ["F", "x0", "w"].map(|name| free(&press, name));
        assert_eq!(names, ["F_extra", "x0", "w"]);
        let law = Rise { body: "ram".to_owned(), names, ..rise }.formula();
        assert!(Rig::parse(std::path::Path::new(path), text + "\n" + &law).is_ok(), "{law}");
    }
}
