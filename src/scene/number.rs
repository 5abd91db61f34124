//! Decimal numbers: the format's grammar, and the nearest `f32` or `f64`.
//!
//! The grammar is `[+-]?(digits[.digits*] | .digits)([eE][+-]?digits)?`, narrower than what Rust's own
//! parser accepts (no `inf`, no `nan`). One scan checks it and gathers the digits, so the numbers that
//! scenes are full of (up to about 15 digits) need one multiplication or division more, which halves the time
//! that a scene takes to read; all others go to the standard library, which rounds correctly whatever the
//! length.

/// Powers of ten that `f64` holds exactly.
const EXACT_POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

/// Integers up to this one are exact in `f64`.
const MAX_EXACT_INTEGER: u64 = 1 << 53;

/// Digits that always fit a `u64`.
const MAX_DIGITS: u32 = 19;

/// Exponents in a file stop growing here; far outside of `f64` either way.
const MAX_EXPONENT: i32 = 1_000_000;

/// A number that follows the grammar: `±mantissa·10^exponent`, and the text it came from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Decimal<'t> {
    text: &'t [u8],
    negative: bool,
    mantissa: u64,
    exponent: i32,
    /// Digits without leading zeros; beyond [`MAX_DIGITS`] they do not fit `mantissa`.
    significant: u32,
}

impl<'t> Decimal<'t> {
    /// The longest beginning of `bytes` that follows the grammar.
    #[inline]
    pub(super) fn scan(bytes: &'t [u8]) -> Option<Decimal<'t>> {
        let mut digits = Digits::default();
        let negative = bytes.first() == Some(&b'-');
        let mut len = usize::from(negative || bytes.first() == Some(&b'+'));
        let start = len;
        len = digits.take(bytes, len);
        let mut count = len - start;
        let mut exponent = 0;
        if bytes.get(len) == Some(&b'.') {
            let end = digits.take(bytes, len + 1);
            let decimals = end - (len + 1);
            count += decimals;
            exponent = -i32::try_from(decimals).unwrap_or(MAX_EXPONENT);
            len = end;
        }
        if count == 0 {
            return None;
        }
        if matches!(bytes.get(len), Some(b'e' | b'E'))
            && let Some((written, end)) = scan_exponent(bytes, len + 1)
        {
            exponent = exponent.saturating_add(written);
            len = end;
        }
        Some(Decimal {
            text: &bytes[..len],
            negative,
            mantissa: digits.value,
            exponent,
            significant: digits.significant,
        })
    }

    /// How many bytes the number takes.
    pub(super) fn len(&self) -> usize {
        self.text.len()
    }

    /// True for nothing but zeros, as written: 1e-999 is not.
    pub(super) fn is_zero(&self) -> bool {
        self.significant == 0
    }

    /// The nearest `f32`, ties to even; infinite beyond its range, possibly zero.
    #[inline]
    pub(super) fn to_f32(self) -> f32 {
        if let Some(value) = self.exact_product() {
            // Rounding twice (to f64, then to f32) is safe unless the first one ended on a tie of the
            // second. No smaller or larger value than 2^53·10^±22 comes here: all are normal in f32.
            let tie = value.to_bits() & 0x1fff_ffff == 0x1000_0000;
            if !tie {
                return value as f32;
            }
        }
        self.str().parse().unwrap_or(f32::NAN)
    }

    /// The nearest `f64`, ties to even; infinite beyond its range, possibly zero.
    pub(super) fn to_f64(self) -> f64 {
        self.exact_product()
            .unwrap_or_else(|| self.str().parse().unwrap_or(f64::NAN))
    }

    /// The nearest `f64`, when one operation on exact operands gives it (Clinger's fast path).
    #[inline]
    fn exact_product(self) -> Option<f64> {
        if self.significant > MAX_DIGITS || self.mantissa > MAX_EXACT_INTEGER {
            return None;
        }
        let power = *EXACT_POWERS.get(self.exponent.unsigned_abs() as usize)?;
        // Exact: no more than 2^53.
        let mantissa = self.mantissa as f64;
        let value = if self.exponent < 0 {
            mantissa / power
        } else {
            mantissa * power
        };
        Some(if self.negative { -value } else { value })
    }

    fn str(self) -> &'t str {
        std::str::from_utf8(self.text).expect("the grammar allows ASCII only")
    }
}

/// Decimal digits on their way into an integer.
#[derive(Default)]
struct Digits {
    value: u64,
    /// Digits without leading zeros; `value` is right while this is at most [`MAX_DIGITS`].
    significant: u32,
}

impl Digits {
    /// Takes the digits from `at` on; returns where they end.
    #[inline]
    fn take(&mut self, bytes: &[u8], at: usize) -> usize {
        let mut end = at;
        while let Some(digit) = bytes.get(end).and_then(|b| digit(*b)) {
            self.value = self.value.wrapping_mul(10).wrapping_add(u64::from(digit));
            self.significant = self
                .significant
                .saturating_add(u32::from(self.value != 0 || self.significant != 0));
            end += 1;
        }
        end
    }
}

#[inline]
fn digit(byte: u8) -> Option<u8> {
    let digit = byte.wrapping_sub(b'0');
    (digit < 10).then_some(digit)
}

/// `[+-]?digits` at `at`: the value, limited to [`MAX_EXPONENT`], and where it ends.
fn scan_exponent(bytes: &[u8], at: usize) -> Option<(i32, usize)> {
    let negative = bytes.get(at) == Some(&b'-');
    let start = at + usize::from(negative || bytes.get(at) == Some(&b'+'));
    let mut end = start;
    let mut value = 0;
    while let Some(digit) = bytes.get(end).and_then(|b| digit(*b)) {
        value = (value * 10 + i32::from(digit)).min(MAX_EXPONENT);
        end += 1;
    }
    (end > start).then_some((if negative { -value } else { value }, end))
}

/// What a word of digits only says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Whole {
    /// Its value.
    Value(u64),
    /// More than a `u64` holds.
    TooLarge,
}

/// The whole number that `word` is, or `None` when it is anything but digits.
pub(super) fn whole(word: &[u8]) -> Option<Whole> {
    if word.is_empty() || !word.iter().all(u8::is_ascii_digit) {
        return None;
    }
    let value = word.iter().try_fold(0u64, |value, byte| {
        value
            .checked_mul(10)?
            .checked_add(u64::from(byte.wrapping_sub(b'0')))
    });
    Some(value.map_or(Whole::TooLarge, Whole::Value))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Random;

    /// The whole of `text` as a number.
    fn scan(text: &str) -> Option<Decimal<'_>> {
        Decimal::scan(text.as_bytes()).filter(|d| d.len() == text.len())
    }

    #[test]
    fn grammar_accepts_what_the_format_says_and_no_more() {
        for good in [
            "0", "1", "-1", "+1", "1.", "1.5", ".5", "-.5", "1e3", "1E+3", "1.e-3", "007", "1e0001",
        ] {
            assert!(scan(good).is_some(), "{good}");
        }
        for bad in [
            "", ".", "-", "+", "e5", "1e", "1e+", "--1", "inf", "nan", "0x1", "1,5", "1_0",
            "1.2.3", "1f", ".e1",
        ] {
            assert!(scan(bad).is_none(), "{bad}");
        }
    }

    #[test]
    fn hard_cases_round_as_the_standard_library_does() {
        for text in [
            "0.1",
            "16777217",
            "16777219",
            "9007199254740993",
            "1.00000017881393432617187499",
            "1.00000017881393432617187500",
            "1.00000017881393432617187501",
            "3.4028235e38",
            "3.4028236e38",
            "1e-45",
            "7.006492321624085e-46",
            "7.006492321624086e-46",
            "1e-400",
            "1e400",
            "-0",
            "-0.0e5",
            "1e999999999999999999999",
            "0.000000000000000000000000000000000000000000001",
            "340282350000000000000000000000000000000",
            "18446744073709551616",
            "99999999999999999999e-20",
            "0e999999999999999999999",
        ] {
            assert_same_as_std(text);
        }
    }

    fn assert_same_as_std(text: &str) {
        let d = scan(text).unwrap_or_else(|| panic!("{text} is a number"));
        assert_eq!(
            d.to_f32().to_bits(),
            text.parse::<f32>().unwrap().to_bits(),
            "{text}"
        );
        assert_eq!(
            d.to_f64().to_bits(),
            text.parse::<f64>().unwrap().to_bits(),
            "{text}"
        );
    }

    #[test]
    fn random_decimals_round_as_the_standard_library_does() {
        let mut rng = Random::new(7);
        for _ in 0..100_000 {
            let mantissa = rng.bits() >> rng.below(64);
            let text = match rng.below(4) {
                0 => format!("{mantissa}e{}", i64::from(rng.below(100)) - 50),
                1 => format!("-{}.{mantissa}", rng.below(1000)),
                2 => format!("{}", f32::from_bits(mantissa as u32 & 0x7f7f_ffff)),
                // Half way between two neighbours in f32, exactly or nearly.
                _ => format!(
                    "{}",
                    (1u64 << 25) + (mantissa & 0xff_ffff) * 2 + 1 + (mantissa >> 40 & 1)
                ),
            };
            assert_same_as_std(&text);
        }
    }

    #[test]
    fn whole_numbers_are_digits_only() {
        assert_eq!(whole(b"0255"), Some(Whole::Value(255)));
        assert_eq!(whole(b"18446744073709551615"), Some(Whole::Value(u64::MAX)));
        assert_eq!(whole(b"18446744073709551616"), Some(Whole::TooLarge));
        for bad in ["", "-1", "+1", "1.0", "1e3", "x"] {
            assert_eq!(whole(bad.as_bytes()), None, "{bad}");
        }
    }
}
