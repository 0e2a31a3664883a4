//! Messages to the user: the place, what is wrong there, and what would be right.

mod excerpt;

use std::fmt;
use std::hash::{Hash, Hasher};
use std::ops::Range;
use std::path::{Path, PathBuf};

use excerpt::Excerpt;

use crate::visible::{visible, visible_lines};

/// What sort of mistake a complaint is about, for programs and tests; people read the text.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kind {
    /// A file or folder does not exist.
    Missing,
    /// A file exists but cannot be read.
    Unreadable,
    /// A file cannot be written.
    Unwritable,
    /// The bytes of a file are not UTF-8 text.
    Encoding,
    /// A file, table or list holds nothing.
    Empty,
    /// A text breaks the rules of its format.
    Syntax,
    /// A name that is not known where it stands.
    UnknownName,
    /// Something that must be given is not.
    MissingEntry,
    /// A name that appears twice.
    Duplicate,
    /// A unit that is not known, or none where one is needed.
    Unit,
    /// A quantity of another dimension than the one asked for.
    Dimension,
    /// A text that is no finite number.
    Number,
    /// A value outside its bounds.
    Bounds,
    /// A row or list of the wrong length.
    Shape,
    /// Rows out of order.
    Order,
    /// A file that another program holds.
    Locked,
    /// Two entries that cannot both hold.
    Contradiction,
    /// A computation that came to no result.
    Computation,
    /// A computation that was cancelled before its end.
    Interrupted,
}

/// A place in a file, written `rig.toml:14:3`. Places are equal that are the same, whether they show their line or not.
#[derive(Debug, Clone)]
pub struct Place {
    /// As the user named it.
    pub file: PathBuf,
    /// Counted from 1.
    pub line: Option<usize>,
    /// Characters from the start of the line, counted from 1.
    pub column: Option<usize>,
    excerpt: Option<Excerpt>,
}

impl Place {
    /// A whole file.
    pub fn file(file: impl Into<PathBuf>) -> Self {
        Self { file: file.into(), line: None, column: None, excerpt: None }
    }

    /// A line of a file, counted from 1.
    pub fn line(file: impl Into<PathBuf>, line: usize) -> Self {
        Self { file: file.into(), line: Some(line), column: None, excerpt: None }
    }

    /// The line and column, both counted from 1, of a byte of `text`, the content of the file.
    pub fn of_byte(file: impl Into<PathBuf>, text: &str, byte: usize) -> Self {
        let before = text.get(..byte).unwrap_or(text);
        let line_start = before.rfind('\n').map_or(0, |at| at + 1);
        let line = before.matches('\n').count() + 1;
        let column = before.chars().count() - before[..line_start].chars().count() + 1;
        let own = text[line_start..].lines().next().unwrap_or_default();
        let at = before.len() - line_start;
        Self::line(file, line).at_column(column).showing(own, at..at + 1)
    }

    /// The same line, at a column counted from 1.
    pub fn at_column(mut self, column: usize) -> Self {
        self.column = Some(column);
        self
    }

    /// The same place, which shows its line of the file with these bytes marked.
    pub fn showing(mut self, line: &str, marked: Range<usize>) -> Self {
        self.excerpt = Some(Excerpt::new(line, marked));
        self
    }

    fn key(&self) -> (&Path, Option<usize>, Option<usize>) {
        (&self.file, self.line, self.column)
    }
}

impl PartialEq for Place {
    fn eq(&self, other: &Self) -> bool {
        self.key() == other.key()
    }
}

impl Eq for Place {}

impl Hash for Place {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.key().hash(state);
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&visible(&self.file.to_string_lossy()))?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
            if let Some(column) = self.column {
                write!(f, ":{column}")?;
            }
        }
        Ok(())
    }
}

/// A message to the user. `Display` writes it with its `error:` and `help:`, without a final line break;
/// [`with_lines`](Self::with_lines) adds the lines that it is about.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Complaint {
    /// What sort of mistake it is.
    pub kind: Kind,
    /// Where; two where two places disagree.
    pub places: Vec<Place>,
    /// What is wrong.
    pub what: String,
    /// What would be right.
    pub help: Option<String>,
}

impl Complaint {
    /// A complaint without place and help; add them with [`at`](Self::at) and [`help`](Self::help).
    pub fn new(kind: Kind, what: impl Into<String>) -> Self {
        Self { kind, places: Vec::new(), what: what.into(), help: None }
    }

    /// Adds a place, behind those already there.
    pub fn at(mut self, place: Place) -> Self {
        self.places.push(place);
        self
    }

    /// Adds a whole file as place.
    pub fn in_file(self, file: &Path) -> Self {
        self.at(Place::file(file))
    }

    /// Says what would be right.
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// The message, and below it the lines of the files that it is about, with carets under the places.
    pub fn with_lines(&self) -> String {
        let mut text = self.to_string();
        let shown = || self.places.iter().filter_map(|place| Some((place, place.line?, place.excerpt.as_ref()?)));
        let width = shown().map(|(_, line, _)| line.to_string().len()).max().unwrap_or(0);
        let several = self.places.windows(2).any(|pair| pair[0].file != pair[1].file);
        for (place, line, excerpt) in shown() {
            if several {
                text.push_str(&format!("\n  {}:", visible(&place.file.to_string_lossy())));
            }
            excerpt.write(line, width, &mut text);
        }
        text
    }
}

impl fmt::Display for Complaint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("error: ")?;
        for (index, place) in self.places.iter().enumerate() {
            if index > 0 {
                f.write_str(" and ")?;
            }
            write!(f, "{place}")?;
        }
        if !self.places.is_empty() {
            f.write_str(": ")?;
        }
        f.write_str(&visible(&self.what))?;
        if let Some(help) = &self.help {
            write!(f, "\n  help: {}", visible_lines(help).replace('\n', "\n        "))?;
        }
        Ok(())
    }
}

impl std::error::Error for Complaint {}

/// The candidate nearest to a mistyped word, the first one of equals; `None` where none is near. Case does not count.
pub fn did_you_mean<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let lower = word.to_lowercase();
    // One slip in a short word, one per three letters in a long one.
    let allowed = (lower.chars().count() / 3).max(1);
    candidates
        .into_iter()
        .map(|candidate| {
            let distance = strsim::osa_distance(&lower, &candidate.to_lowercase());
            (distance, candidate)
        })
        // A slip in a word of one letter leaves nothing of it.
        .filter(|(distance, candidate)| *distance <= allowed && *distance < candidate.chars().count().max(1))
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}

/// Help for a name that is not known: the near miss, if any, and every name there is.
/// `what` names them in the plural, such as `component kinds`.
pub fn help_with_names<'a>(word: &str, what: &str, candidates: impl IntoIterator<Item = &'a str>) -> String {
    let candidates: Vec<&str> = candidates.into_iter().collect();
    help_with_near(did_you_mean(word, candidates.iter().copied()), what, candidates)
}

/// The same where it is known which of the names was meant.
pub fn help_with_near<'a>(near: Option<&str>, what: &str, candidates: impl IntoIterator<Item = &'a str>) -> String {
    let quoted: Vec<String> = candidates.into_iter().map(|name| format!("`{name}`")).collect();
    let all =
        if quoted.is_empty() { format!("there are no {what}") } else { format!("known {what}: {}", quoted.join(", ")) };
    match near {
        Some(near) => format!("did you mean `{near}`? {}", capitalised(&all)),
        None => all,
    }
}

pub(crate) fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
