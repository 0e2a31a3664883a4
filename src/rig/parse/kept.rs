//! What a rig file adds to the cards, which are constants everywhere else.

/// A text for as long as the program lives, which reads few rig files.
pub(super) fn kept(text: &str) -> &'static str {
    Box::leak(text.to_owned().into_boxed_str())
}

/// A list for as long.
pub(super) fn kept_list<T>(list: Vec<T>) -> &'static [T] {
    Box::leak(list.into_boxed_slice())
}
