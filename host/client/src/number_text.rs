//! A value beside its limit, as text that shows the difference.

/// A value and its limit with `decimals`, or with as many as it takes for two unequal
/// numbers to have unequal texts.
pub fn beside_limit(value: f32, limit: f32, decimals: usize) -> [String; 2] {
    // Seven significant digits tell most `f32` apart, nine all.
    let text = |decimals: usize| [value, limit].map(|number| format!("{number:.decimals$}"));
    let mut texts = (decimals..=9).map(text);
    texts
        .find(|[value_text, limit_text]| {
            value_text != limit_text || value.to_bits() == limit.to_bits()
        })
        .unwrap_or_else(|| [value, limit].map(|number| format!("{number:e}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unequal_numbers_have_unequal_texts() {
        assert_eq!(beside_limit(1.5, 1.2, 3), ["1.500", "1.200"]);
        assert_eq!(beside_limit(4.0004, 4.0, 3), ["4.0004", "4.0000"]);
        assert_eq!(beside_limit(1.5, 1.5, 3), ["1.500", "1.500"]);
        let next = f32::from_bits(1.5_f32.to_bits() + 1);
        assert_eq!(beside_limit(next, 1.5, 3), ["1.5000001", "1.5000000"]);
    }
}
