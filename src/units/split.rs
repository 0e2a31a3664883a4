//! The number at the start of a quantity, and the unit behind it.

/// The number and what is written of the unit, if a finite number stands at the start.
pub(super) fn split(text: &str) -> Option<(f64, &str)> {
    let text = text.trim();
    let (number, unit) = text.split_at(number_length(text));
    let value = number.parse::<f64>().ok().filter(|value| value.is_finite())?;
    // `5,5 mm` would otherwise be 5 of the unit `,5 mm`.
    (!unit.starts_with([',', '.'])).then_some((value, unit.trim()))
}

/// Bytes of the decimal number at the start; an `e` belongs to it only with digits behind.
fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let digits = |from: usize| bytes.iter().skip(from).take_while(|byte| byte.is_ascii_digit()).count();
    let sign_at = |at: usize| usize::from(matches!(bytes.get(at), Some(b'+' | b'-')));
    let mut length = sign_at(0);
    length += digits(length);
    if bytes.get(length) == Some(&b'.') {
        length += 1 + digits(length + 1);
    }
    if matches!(bytes.get(length), Some(b'e' | b'E')) {
        let sign = sign_at(length + 1);
        let exponent = digits(length + 1 + sign);
        if exponent > 0 {
            length += 1 + sign + exponent;
        }
    }
    length
}
