//! The library of effects as a page of cards.

use crate::physics::effect::Effect;
use crate::report::effects::{EffectReport, FREE_HEADS, LibraryReport, free_rows};
use crate::report::html::{Page, Section, Table};

/// The whole library.
pub fn library() -> String {
    let mut page = Page::new("Effects", "Physics beyond that of the components, which a model may be given");
    let effects = LibraryReport::new().effects;
    let mut list = Section::new("Library");
    let rows = effects
        .iter()
        .map(|effect| vec![effect.name.to_owned(), effect.at.replace('`', ""), effect.meaning.to_owned()]);
    list.table(Table::of("Every effect", &[("effect", false), ("where", false), ("meaning", false)], rows.collect()));
    page.section(list);
    for effect in &effects {
        page.section(card_section(effect));
    }
    page.html()
}

/// The cards of one name.
pub fn cards(effects: &[&Effect]) -> String {
    let effects: Vec<EffectReport> = effects.iter().map(|effect| EffectReport::new(effect)).collect();
    let (name, meaning) = effects.first().map_or(("Effects", ""), |effect| (effect.name, effect.meaning));
    let mut page = Page::new(name, meaning);
    for effect in &effects {
        page.section(card_section(effect));
    }
    page.html()
}

fn card_section(effect: &EffectReport) -> Section {
    let mut section = Section::new(effect.title());
    section.paragraph(effect.meaning).preformatted(effect.law);
    section.facts(vec![
        ("where".to_owned(), effect.at.replace('`', "")),
        ("written".to_owned(), effect.written.clone()),
        ("validity".to_owned(), effect.validity.to_owned()),
        ("source".to_owned(), effect.source.to_owned()),
    ]);
    section.table(Table::of("Parameters", &FREE_HEADS, free_rows(effect)));
    section
}
