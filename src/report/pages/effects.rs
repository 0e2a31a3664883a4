//! The library of effects as a page of cards.

use crate::physics::effect::{EFFECTS, Effect};
use crate::report::effects::{EffectReport, FREE_HEADS, free_rows};
use crate::report::html::{Page, Section, Table};

/// The whole library.
pub fn library() -> String {
    let mut page = Page::new("Effects", "Physics beyond that of the components, which a model may be given");
    let effects: Vec<EffectReport> = EFFECTS.iter().map(|effect| EffectReport::new(effect)).collect();
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

/// One card.
pub fn card(effect: &Effect) -> String {
    let effect = EffectReport::new(effect);
    let mut page = Page::new(effect.name, effect.meaning);
    page.section(card_section(&effect));
    page.html()
}

fn card_section(effect: &EffectReport) -> Section {
    let mut section = Section::new(effect.name);
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
