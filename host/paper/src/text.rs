//! Formatting of numbers in prose and tables.

/// A value with a fixed number of decimals and a typographic minus sign.
pub(crate) fn number(value: f64, decimals: usize) -> String {
    if value.is_nan() {
        return "none".to_owned();
    }
    let text = format!("{value:.decimals$}");
    // A value that rounds to zero has no sign.
    let zero = text.chars().all(|c| matches!(c, '-' | '0' | '.'));
    let text = if zero {
        text.trim_start_matches('-')
    } else {
        &text
    };
    text.replace('-', "−")
}

/// A value with a fixed number of significant digits; very small or large values with a
/// power of ten.
pub(crate) fn digits(value: f64, digits: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return number(value, 0);
    }
    let exponent = value.abs().log10().floor() as i32;
    if (-4..7).contains(&exponent) {
        let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
        return number(value, decimals);
    }
    let mantissa = number(value / 10f64.powi(exponent), digits - 1);
    format!("{mantissa}·10{}", superscript(exponent))
}

/// A value with at most four significant digits, without trailing zeros.
pub(crate) fn plain(value: f64) -> String {
    if value != 0.0 && value.abs() < 1e-4 {
        return digits(value, 1);
    }
    let text = digits(value, 4);
    if !text.contains('.') {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Several values with a fixed number of decimals, separated by commas.
pub(crate) fn list(values: &[f64], decimals: usize) -> String {
    let texts: Vec<_> = values.iter().map(|v| number(*v, decimals)).collect();
    texts.join(", ")
}

fn superscript(exponent: i32) -> String {
    exponent
        .to_string()
        .chars()
        .map(|c| match c {
            '-' => '⁻',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            '0' | '4'..='9' => {
                // U+2070 and U+2074 to U+2079.
                char::from_u32(0x2070 + c.to_digit(10).unwrap_or(0)).unwrap_or(c)
            }
            other => other,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_as_in_print() {
        assert_eq!(number(-0.3924, 4), "−0.3924");
        assert_eq!(number(-0.0004, 2), "0.00");
        assert_eq!(digits(3.4707e-12, 2), "3.5·10⁻¹²");
        assert_eq!(digits(0.83550566, 7), "0.8355057");
        assert_eq!(digits(-43.2, 3), "−43.2");
        assert_eq!(plain(0.002), "0.002");
        assert_eq!(plain(-0.35240000000000005), "−0.3524");
        assert_eq!(plain(2.0 / 3.0), "0.6667");
        assert_eq!(plain(1000.0), "1000");
        assert_eq!(plain(1e-9), "1·10⁻⁹");
        assert_eq!(list(&[0.6, 0.75], 2), "0.60, 0.75");
    }
}
