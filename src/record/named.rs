//! What the name of a column says of where it was measured.

/// A place of a cylinder circuit that names of columns say.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NamedPlace {
    PumpLine,
    A,
    B,
}

/// Where a pressure or a flow is measured, by the last word of its name that says it.
pub fn named_place(name: &str) -> Option<NamedPlace> {
    let words = name.split(|letter: char| !letter.is_alphanumeric()).filter(|word| !word.is_empty());
    // `pA` is `p_A`: the letter of the quantity goes before.
    let words = words.map(|word| match word.strip_prefix(['p', 'q', 'Q']) {
        Some(rest) if rest.chars().count() == 1 => rest.to_lowercase(),
        _ => word.to_lowercase(),
    });
    let words: Vec<String> = words.collect();
    let several = words.len() > 1;
    words.iter().enumerate().rev().find_map(|(index, word)| match word.as_str() {
        "a" | "cap" | "head" | "kolbenseite" | "bodenseite" => Some(NamedPlace::A),
        "b" | "rod" | "annulus" | "stangenseite" | "ringseite" => Some(NamedPlace::B),
        "pump" | "pumpe" | "supply" | "system" | "versorgung" | "s" => Some(NamedPlace::PumpLine),
        // Alone it is the quantity.
        "p" if several && index > 0 => Some(NamedPlace::PumpLine),
        _ => None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_say_where_a_sensor_sits() {
        for (name, expected) in [
            ("p_A", Some(NamedPlace::A)),
            ("pA", Some(NamedPlace::A)),
            ("Druck B", Some(NamedPlace::B)),
            ("pressure rod side", Some(NamedPlace::B)),
            ("p_pump", Some(NamedPlace::PumpLine)),
            ("Druck Pumpe", Some(NamedPlace::PumpLine)),
            ("p_P", Some(NamedPlace::PumpLine)),
            ("p", None),
            ("pressure 1", None),
        ] {
            assert_eq!(named_place(name), expected, "{name}");
        }
    }
}
