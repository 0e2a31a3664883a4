//! Cards: what was found, one thing each, with what follows from it and what to do next.

use super::table::Scale;
use super::{line, prose};
use crate::report::escape;
use crate::report::style::Tone;

/// A card. Texts are plain and escaped where they are written.
#[derive(Debug, Clone, PartialEq)]
pub struct Card {
    pub tone: Tone,
    /// What it is, in plain words.
    pub title: String,
    /// The id that programs and rig files know it by.
    pub id: String,
    /// The one number that counts, with its unit.
    pub size: String,
    /// What stands behind the number: interval, value of a new part, certainty.
    pub about: String,
    /// The number on its scale.
    pub scale: Option<Scale>,
    /// Further facts, each under its name.
    pub facts: Vec<(String, String)>,
    /// What to type next; empty for nothing.
    pub command: String,
}

impl Card {
    pub(super) fn html(&self, out: &mut String) {
        let class = match self.tone {
            Tone::Good => "good",
            Tone::Alert => "alert",
            Tone::Caution => "caution",
        };
        line(out, format_args!("<article class=\"finding {class}\">"));
        line(out, format_args!("<h3>{} <small class=\"id\">{}</small></h3>", prose(&self.title), escape(&self.id)));
        line(
            out,
            format_args!("<p class=\"size\"><b>{}</b> <span>{}</span></p>", escape(&self.size), prose(&self.about)),
        );
        if let Some(scale) = &self.scale {
            out.push_str(&scale.html());
        }
        if !self.facts.is_empty() {
            out.push_str("<dl>\n");
            for (name, fact) in &self.facts {
                line(out, format_args!("<dt>{}</dt><dd>{}</dd>", escape(name), prose(fact)));
            }
            out.push_str("</dl>\n");
        }
        if !self.command.is_empty() {
            line(out, format_args!("<pre class=\"command\">{}</pre>", escape(&self.command)));
        }
        out.push_str("</article>\n");
    }
}
