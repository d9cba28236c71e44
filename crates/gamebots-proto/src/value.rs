//! Lenient reading of the values in a client's blocks: there is always a result, and a note of each mistake.

use crate::{Block, Line, Problem, shown};

/// Largest magnitude of a client's number; 32-bit physics has no use for more.
pub const LIMIT: f64 = 1e6;

/// Reads a scalar: the longest numeric prefix, as C's atof does. A comma may replace the point.
pub(crate) fn scalar_of(key: &str, text: &str, problems: &mut Vec<Problem>) -> f64 {
    let Some(value) = number_prefix(&text.replacen(',', ".", 1)) else {
        problems.push(Problem::NotANumber { key: key.to_owned(), got: shown(text), read_as: 0.0 });
        return 0.0;
    };
    limited(key, text, value, problems)
}

/// Checks a number that was never a text, as [`scalar_of`] checks one that it reads.
pub(crate) fn checked(key: &str, number: f64, problems: &mut Vec<Problem>) -> f64 {
    if !number.is_finite() {
        problems.push(Problem::NotANumber { key: key.to_owned(), got: number.to_string(), read_as: 0.0 });
        return 0.0;
    }
    limited(key, &number.to_string(), number, problems)
}

/// Reads an index, counted from 0.
pub(crate) fn index_of(block: &Block, problems: &mut Vec<Problem>) -> Option<usize> {
    let index = block.value.parse().ok();
    if index.is_none() {
        problems.push(Problem::NotANumber { key: block.key.clone(), got: shown(&block.value), read_as: -1.0 });
    }
    index
}

/// Reads a vector; zeros if the block is missing. Other than three numbers are a problem.
pub(crate) fn vector(line: &Line, key: &str, problems: &mut Vec<Problem>) -> [f64; 3] {
    let before = problems.len();
    let read_as = vector_or_part(line, key, problems);
    let text = line.get(key).unwrap_or_default();
    if problems.len() == before && !text.is_empty() && !has_three_numbers(text) {
        problems.push(Problem::NotAVector { key: key.to_owned(), got: shown(text), read_as });
    }
    read_as
}

/// True if a vector has three parts, with commas or white space between them.
fn has_three_numbers(text: &str) -> bool {
    let words = text.split_whitespace().map(|word| word.trim_matches(',')).filter(|word| !word.is_empty());
    words.count() == 3 || text.split(',').count() == 3 && text.split(',').all(|part| !part.trim().is_empty())
}

/// Reads a vector; zeros if the block is missing, and for parts that are missing.
pub(crate) fn vector_or_part(line: &Line, key: &str, problems: &mut Vec<Problem>) -> [f64; 3] {
    let Some(text) = line.get(key).filter(|text| !text.is_empty()) else { return [0.0; 3] };
    vector_parts(text).map(|part| {
        if part.is_empty() {
            return 0.0;
        }
        let Some(value) = number_prefix(&part) else {
            problems.push(Problem::NotANumber { key: key.to_owned(), got: shown(text), read_as: 0.0 });
            return 0.0;
        };
        limited(key, text, value, problems)
    })
}

/// Reads a vector that stands alone. A part that is no number is 0, and the largest numbers are cut.
pub(crate) fn vector_of(text: &str) -> [f64; 3] {
    vector_parts(text).map(|part| number_prefix(&part).unwrap_or_default().clamp(-LIMIT, LIMIT))
}

/// Reads a boolean: `true` and `True` are true, everything else is false (`TRUE` too: protocol.md case 79).
pub(crate) fn boolean(line: &Line, key: &str, problems: &mut Vec<Problem>) -> Option<bool> {
    let text = line.get(key).filter(|text| !text.is_empty())?;
    if !["true", "false"].iter().any(|word| text.eq_ignore_ascii_case(word)) {
        problems.push(Problem::NotABool { key: key.to_owned(), got: shown(text) });
    }
    Some(text == "true" || text == "True")
}

/// Splits a vector. Three pieces separated by white space are the components, as in `1 2 3`, `1, 2, 3`,
/// `1,0000, 2,0000, -0,5000`. Commas at their ends are dropped, and commas inside them are decimal. Anything else follows USARSim's rule
/// (Utilities.uc:92-108): x before the first comma, y before the second, z the rest; without a comma z alone.
fn vector_parts(text: &str) -> [String; 3] {
    let pieces: Vec<&str> =
        text.split_whitespace().map(|piece| piece.trim_matches(',')).filter(|piece| !piece.is_empty()).collect();
    if let [x, y, z] = pieces[..] {
        return [x, y, z].map(|piece| piece.replacen(',', ".", 1));
    }
    let parts: Vec<&str> = text.splitn(3, ',').map(str::trim).collect();
    let [x, y, z] = match parts[..] {
        [z] => ["", "", z],
        [x, z] => [x, "", z],
        [x, y, z] => [x, y, z],
        _ => ["", "", ""],
    };
    [x, y, z].map(str::to_owned)
}

fn limited(key: &str, text: &str, value: f64, problems: &mut Vec<Problem>) -> f64 {
    if value.abs() <= LIMIT {
        return value;
    }
    let read_as = LIMIT.copysign(value);
    problems.push(Problem::OutOfRange { key: key.to_owned(), got: shown(text), limit: LIMIT, read_as });
    read_as
}

/// Parses the longest prefix that is a decimal number; infinite if it is too large. `inf` and `nan` are not numbers.
fn number_prefix(text: &str) -> Option<f64> {
    let text = text.trim_start();
    let bytes = text.as_bytes();
    let digits = |from: usize| bytes.iter().skip(from).take_while(|byte| byte.is_ascii_digit()).count();
    let sign = usize::from(matches!(bytes.first(), Some(b'+' | b'-')));
    let whole = digits(sign);
    let mut end = sign + whole;
    let mut fraction = 0;
    if bytes.get(end) == Some(&b'.') {
        fraction = digits(end + 1);
        if whole + fraction > 0 {
            end += 1 + fraction;
        }
    }
    if whole + fraction == 0 {
        return None;
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let exponent_sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        let exponent = digits(end + 1 + exponent_sign);
        if exponent > 0 {
            end += 1 + exponent_sign + exponent;
        }
    }
    text.get(..end)?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn check_scalar(text: &str, expected: f64, problems_expected: usize) {
        let mut problems = Vec::new();
        assert_eq!(scalar_of("K", text, &mut problems), expected, "{text}");
        assert_eq!(problems.len(), problems_expected, "{text}: {problems:?}");
    }

    #[test]
    fn scalars() {
        for (text, expected) in [
            ("1", 1.0),
            ("1.5", 1.5),
            ("1,00", 1.0),
            ("1,50", 1.5),
            ("+1,00", 1.0),
            ("-0,25", -0.25),
            (".5", 0.5),
            ("5e-1", 0.5),
            ("5e", 5.0),
            ("20.0abc", 20.0),
            ("3.", 3.0),
        ] {
            check_scalar(text, expected, 0);
        }
        for text in ["abc", "", "-", ".", "NaN", "inf", "-infinity", "e5"] {
            check_scalar(text, 0.0, 1);
        }
        check_scalar("1e999", LIMIT, 1);
        check_scalar("-99999999999999", -LIMIT, 1);
    }

    #[test]
    fn vectors() {
        for (text, expected, is_whole) in [
            ("1,2,-0.5", [1.0, 2.0, -0.5], true),
            ("1, 2, -0.5", [1.0, 2.0, -0.5], true),
            ("1 2 -0.5", [1.0, 2.0, -0.5], true),
            ("1 , 2 , -0.5", [1.0, 2.0, -0.5], true),
            ("5", [0.0, 0.0, 5.0], false),
            ("1,2", [1.0, 0.0, 2.0], false),
            ("1,2,-3,9", [1.0, 2.0, -3.0], false),
            ("1,0000, 2,0000, 0,4000", [1.0, 2.0, 0.4], true),
            ("1,500000 -2,250000 0,400000", [1.5, -2.25, 0.4], true),
            (".4, .4, 1.8", [0.4, 0.4, 1.8], true),
            ("1, 2,3", [1.0, 2.0, 3.0], true),
            ("1,,3", [1.0, 0.0, 3.0], false),
        ] {
            let mut problems = Vec::new();
            let line = Line::new("INIT").with("Location", text);
            assert_eq!(vector(&line, "Location", &mut problems), expected, "{text}");
            let problem = Problem::NotAVector { key: "Location".to_owned(), got: text.to_owned(), read_as: expected };
            assert_eq!(problems, if is_whole { Vec::new() } else { vec![problem] }, "{text}");
        }
        let mut problems = Vec::new();
        let line = Line::new("INIT").with("Location", "NaN,inf,1e30");
        assert_eq!(vector(&line, "Location", &mut problems), [0.0, 0.0, LIMIT]);
        assert_eq!(problems.len(), 3);
    }

    #[test]
    fn booleans() {
        for (text, expected) in [("true", true), ("True", true), ("TRUE", false), ("False", false), ("1", false)] {
            let line = Line::new("DRIVE").with("Light", text);
            assert_eq!(boolean(&line, "Light", &mut Vec::new()), Some(expected), "{text}");
        }
    }

    proptest! {
        #[test]
        fn any_text_gives_a_finite_number(text in ".*") {
            prop_assert!(scalar_of("K", &text, &mut Vec::new()).is_finite());
            let line = Line::new("V").with("K", &text);
            prop_assert!(vector(&line, "K", &mut Vec::new()).iter().all(|value| value.is_finite()));
        }
    }
}
