//! A page that needs nothing but itself: no fonts, styles or scripts from elsewhere, fit for a phone, for the dark and for
//! print. Without its one script everything is seen all the same, only not zoomed.

mod card;
mod table;

use std::fmt::Write;

use super::escape;
use super::plot::{Chart, Live, Map};
use super::style::Tone;
use crate::report::provenance::Provenance;

pub use card::Card;
pub use table::{Cell, Column, Mark, Scale, Table};

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");
/// Forbids the page to load anything.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data: blob:";

#[derive(Debug, Clone, PartialEq)]
enum Block {
    Paragraph(String),
    Notice(Tone, String),
    List(Vec<String>),
    Facts(Vec<(String, String)>),
    Preformatted(String),
    Table(Table),
    Subheading(String),
    Cards(Vec<Card>),
    /// What is read only when it is asked for, with its title; open from the start or not.
    Fold(String, bool, Vec<Block>),
    /// Markup that this crate made.
    Made(String),
}

/// A heading with what stands under it, in the order in which it was added. All texts are plain and escaped here.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    heading: String,
    blocks: Vec<Block>,
    /// Whether what stands under the heading is shown only when it is asked for.
    folded: bool,
}

impl Section {
    /// Adds a paragraph.
    pub fn paragraph(&mut self, text: impl Into<String>) -> &mut Self {
        self.add(Block::Paragraph(text.into()))
    }

    /// Adds a framed sentence, such as the verdict.
    pub fn notice(&mut self, tone: Tone, text: impl Into<String>) -> &mut Self {
        self.add(Block::Notice(tone, text.into()))
    }

    /// Adds a list of points.
    pub fn list(&mut self, points: Vec<String>) -> &mut Self {
        self.add(Block::List(points))
    }

    /// Adds pairs of a name and what it is.
    pub fn facts(&mut self, facts: Vec<(String, String)>) -> &mut Self {
        self.add(Block::Facts(facts))
    }

    /// Adds a text whose lines and blanks stay as they are.
    pub fn preformatted(&mut self, text: impl Into<String>) -> &mut Self {
        self.add(Block::Preformatted(text.into()))
    }

    /// Adds a table.
    pub fn table(&mut self, table: Table) -> &mut Self {
        self.add(Block::Table(table))
    }

    /// Adds a heading of what follows within the section.
    pub fn subheading(&mut self, text: impl Into<String>) -> &mut Self {
        self.add(Block::Subheading(text.into()))
    }

    /// Adds cards that stand beside each other where there is room.
    pub fn cards(&mut self, cards: Vec<Card>) -> &mut Self {
        self.add(Block::Cards(cards))
    }

    /// Adds what another section holds under a title, shown when it is asked for, or from the start.
    pub fn fold(&mut self, title: impl Into<String>, open: bool, section: Self) -> &mut Self {
        self.add(Block::Fold(title.into(), open, section.blocks))
    }

    /// Adds a chart that can be zoomed and read.
    pub fn chart(&mut self, chart: &Chart, live: &Live) -> &mut Self {
        self.add(Block::Made(chart.live(live)))
    }

    /// Adds charts that stand beside each other where there is room.
    pub fn side_by_side(&mut self, charts: &[(Chart, Live)]) -> &mut Self {
        let charts: String = charts.iter().map(|(chart, live)| chart.live(&live.clone().narrow())).collect();
        self.add(Block::Made(format!("<div class=\"beside\">\n{charts}</div>\n")))
    }

    /// Adds a map of fields along an axis.
    pub fn map(&mut self, map: &Map, live: &Live) -> &mut Self {
        self.add(Block::Made(map.live(live)))
    }

    /// Adds maps that stand beside each other where there is room.
    pub fn maps(&mut self, maps: &[(Map, Live)]) -> &mut Self {
        let maps: String = maps.iter().map(|(map, live)| map.live(&live.clone().narrow())).collect();
        self.add(Block::Made(format!("<div class=\"beside two\">\n{maps}</div>\n")))
    }

    /// Adds a drawing, an `<svg>` element made by this crate, with a caption.
    pub fn drawing(&mut self, name: &str, svg: &str, caption: &str) -> &mut Self {
        let (name, caption) = (escape(name), prose(caption));
        self.add(Block::Made(format!(
            "<figure class=\"drawing\" data-name=\"{name}\">\n<div class=\"head\"><span class=\"tools\"></span></div>\n{svg}\
             <figcaption>{caption}</figcaption>\n</figure>\n"
        )))
    }

    fn add(&mut self, block: Block) -> &mut Self {
        self.blocks.push(block);
        self
    }
}

/// A page.
#[derive(Debug, Clone, PartialEq)]
pub struct Page {
    title: String,
    lead: String,
    sections: Vec<Section>,
    /// From what the page was made, in the foot.
    provenance: Option<Provenance>,
}

impl Page {
    /// A page with a title and, under it, one sentence that says what it is about; empty for none.
    pub fn new(title: impl Into<String>, lead: impl Into<String>) -> Self {
        Self { title: title.into(), lead: lead.into(), sections: Vec::new(), provenance: None }
    }

    /// Says in the foot from what the page was made.
    pub fn provenance(&mut self, provenance: Provenance) -> &mut Self {
        self.provenance = Some(provenance);
        self
    }

    /// Adds a section.
    pub fn section(&mut self, section: Section) -> &mut Self {
        self.sections.push(section);
        self
    }

    /// Adds sections that may be none.
    pub fn sections(&mut self, sections: impl IntoIterator<Item = Section>) -> &mut Self {
        self.sections.extend(sections);
        self
    }

    /// The whole page as one HTML text.
    pub fn html(&self) -> String {
        let title = escape(&self.title);
        let mut out = format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <meta name=\"color-scheme\" content=\"light dark\">\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\">\n<title>{title}</title>\n<style>\n{STYLE}</style>\n\
             </head>\n<body>\n<header>\n<h1>{title}</h1>\n"
        );
        if !self.lead.is_empty() {
            line(&mut out, format_args!("<p class=\"lead\">{}</p>", prose(&self.lead)));
        }
        out.push_str("</header>\n");
        if self.sections.len() > 2 {
            out.push_str("<nav aria-label=\"Sections\"><ul>\n");
            for (index, section) in self.sections.iter().enumerate() {
                line(&mut out, format_args!("<li><a href=\"#s{index}\">{}</a></li>", escape(&section.heading)));
            }
            out.push_str("</ul></nav>\n");
        }
        out.push_str("<main>\n");
        for (index, section) in self.sections.iter().enumerate() {
            let heading = escape(&section.heading);
            if section.folded {
                line(
                    &mut out,
                    format_args!(
                        "<section aria-labelledby=\"s{index}\">\n<details class=\"part\">\n<summary><h2 id=\"s{index}\">{heading}</h2></summary>"
                    ),
                );
            } else {
                line(
                    &mut out,
                    format_args!("<section aria-labelledby=\"s{index}\">\n<h2 id=\"s{index}\">{heading}</h2>"),
                );
            }
            for block in &section.blocks {
                block.html(&mut out);
            }
            out.push_str(if section.folded { "</details>\n</section>\n" } else { "</section>\n" });
        }
        out.push_str("</main>\n");
        if let Some(provenance) = &self.provenance {
            line(&mut out, format_args!("<footer>{}</footer>", escape(&provenance.to_string())));
        }
        line(&mut out, format_args!("<script>\n{SCRIPT}</script>\n</body>\n</html>"));
        out
    }
}

impl Section {
    /// An empty section.
    pub fn new(heading: impl Into<String>) -> Self {
        Self { heading: heading.into(), blocks: Vec::new(), folded: false }
    }

    /// An empty section that is shown when it is asked for.
    pub fn folded(heading: impl Into<String>) -> Self {
        Self { folded: true, ..Self::new(heading) }
    }

    /// Whether nothing stands in it.
    pub fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }
}

impl Block {
    fn html(&self, out: &mut String) {
        match self {
            Self::Paragraph(text) => line(out, format_args!("<p>{}</p>", prose(text))),
            Self::Notice(tone, text) => {
                let class = match tone {
                    Tone::Good => "good",
                    Tone::Alert => "alert",
                    Tone::Caution => "caution",
                };
                line(out, format_args!("<p class=\"notice {class}\">{}</p>", prose(text)));
            }
            Self::List(points) => {
                out.push_str("<ul>\n");
                points.iter().for_each(|point| line(out, format_args!("<li>{}</li>", prose(point))));
                out.push_str("</ul>\n");
            }
            Self::Facts(facts) => {
                out.push_str("<dl>\n");
                for (name, fact) in facts {
                    line(out, format_args!("<dt>{}</dt><dd>{}</dd>", escape(name), prose(fact)));
                }
                out.push_str("</dl>\n");
            }
            Self::Preformatted(text) => line(out, format_args!("<pre>{}</pre>", escape(text))),
            Self::Table(table) => table.html(out),
            Self::Subheading(text) => line(out, format_args!("<h3>{}</h3>", escape(text))),
            Self::Cards(cards) => {
                out.push_str("<div class=\"findings\">\n");
                cards.iter().for_each(|card| card.html(out));
                out.push_str("</div>\n");
            }
            Self::Fold(title, open, blocks) => {
                let open = if *open { " open" } else { "" };
                line(out, format_args!("<details{open}>\n<summary>{}</summary>", prose(title)));
                blocks.iter().for_each(|block| block.html(out));
                out.push_str("</details>\n");
            }
            Self::Made(markup) => out.push_str(markup),
        }
    }
}

/// A text escaped, with what stands between backticks, as in messages and rig files, set as code.
fn prose(text: &str) -> String {
    let parts: Vec<&str> = text.split('`').collect();
    if parts.len().is_multiple_of(2) {
        // A backtick without its partner is a character like any other.
        return escape(text);
    }
    let one = |(index, part): (usize, &&str)| match index % 2 {
        0 => escape(part),
        _ => format!("<code>{}</code>", escape(part)),
    };
    parts.iter().enumerate().map(one).collect()
}

fn line(out: &mut String, text: std::fmt::Arguments<'_>) {
    // Writing to a String cannot fail.
    let _ = out.write_fmt(text);
    out.push('\n');
}

#[cfg(test)]
mod tests {
    use super::super::plot::{Axis, Chart, Series};
    use super::*;

    #[test]
    fn what_stands_between_backticks_is_code() {
        let mut section = Section::new("One");
        section.paragraph("see `check <rig>` & `--all`").table(Table::new(
            "of `x`",
            vec![Column::text("what")],
            vec![vec!["a `b` c".into()]],
        ));
        let page = Page::new("T", "").section(section).html();
        for part in [
            "see <code>check &lt;rig&gt;</code> &amp; <code>--all</code>",
            ">of <code>x</code></p>",
            "<td>a <code>b</code> c</td>",
        ] {
            assert!(page.contains(part), "{part} is missing in {page}");
        }
        assert!(page.contains("aria-label=\"of `x`\""), "a label has no elements");
        assert_eq!(prose("5` of"), "5` of");
    }

    #[test]
    fn a_page_is_escaped_closed_and_alone() {
        let mut faults = Section::new("Faults & <sizes>");
        faults
            .notice(Tone::Alert, "cylinder leaks <b>")
            .table(Table::new(
                "Faults",
                vec![Column::text("id"), Column::number("value", "mm")],
                vec![vec!["cylinder.clearance".into(), "0.20".into()], vec!["\u{1}\"x\"".into()]],
            ))
            .facts(vec![("record".into(), "a&b.csv".into())])
            .list(vec!["one".into()])
            .preformatted("a  <b");
        let chart =
            Chart::new("p", Axis::new("t", "s"), Axis::new("p", "bar"), vec![Series::line("s", vec![(0.0, 1.0)])]);
        faults.paragraph("text");
        faults.chart(&chart, &Live::new("time", "p <over> t"));
        let page = Page::new("Diagnosis of <x>", "lead").section(faults).clone().html();
        for part in [
            "Faults &amp; &lt;sizes&gt;",
            "leaks &lt;b&gt;",
            "\u{fffd}&quot;x&quot;",
            "a&amp;b.csv",
            "a  &lt;b",
            "<td class=\"number\"></td>",
        ] {
            assert!(page.contains(part), "{part} is missing in {page}");
        }
        for foreign in ["<script src", "<link", "http://cdn", "https://", "@import", "url("] {
            assert!(!page.contains(foreign), "{foreign}");
        }
        for tag in
            ["section", "table", "thead", "tbody", "figure", "svg", "script", "ul", "dl", "main", "body", "html", "div"]
        {
            let opened = page.matches(&format!("<{tag}>")).count() + page.matches(&format!("<{tag} ")).count();
            assert_eq!(opened, page.matches(&format!("</{tag}>")).count(), "{tag}");
        }
    }
}
