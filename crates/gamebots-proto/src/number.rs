//! The number formats of the wire: two in 32-bit floats, and one of the wireless simulator. Nothing else formats a number for a client.
//!
//! USARSim's own formatter ([`fixed`], UnitsConverter.uc:46-71) truncates; the Unreal engine's ([`rounded`]) rounds. The format
//! of each message says which one applies. A number that is not finite is written as 0: no client can read `NaN`.

/// Formats `%Fn`: fixed point with `decimals` digits, truncated toward zero. The sign is `-` whenever the value is below zero.
pub fn fixed(value: f32, decimals: u32) -> String {
    let value = finite(value);
    let sign = if value < 0.0 { "-" } else { "" };
    let value = value.abs();
    let whole = value.trunc();
    let fraction = ((value - whole) * 10f32.powi(decimals as i32)).trunc();
    format!("{sign}{whole:.0}.{fraction:0width$.0}", width = decimals as usize)
}

/// Formats with `decimals` digits, rounded. The engine uses four (`%f`), and two for vectors (`%v`); it may print `-0.00`.
pub fn rounded(value: f32, decimals: u32) -> String {
    format!("{:.1$}", finite(value), decimals as usize)
}

/// Formats `%g`, as C++ streams do: six significant digits without zeros at their end, and an exponent for very large and small numbers.
pub fn general(value: f64) -> String {
    const DIGITS: i32 = 6;
    if value == 0.0 || !value.is_finite() {
        return "0".to_owned();
    }
    let text = format!("{value:.0$e}", DIGITS as usize - 1);
    let Some((digits, exponent)) = text.split_once('e') else { return text };
    let exponent: i32 = exponent.parse().unwrap_or_default();
    let short = |text: &str| {
        let has_point = text.contains('.');
        if has_point { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text.to_owned() }
    };
    if (-4..DIGITS).contains(&exponent) {
        return short(&format!("{value:.0$}", (DIGITS - 1 - exponent) as usize));
    }
    let sign = if exponent < 0 { '-' } else { '+' };
    format!("{}e{sign}{:02}", short(digits), exponent.abs())
}

fn finite(value: f32) -> f32 {
    if value.is_finite() { value } else { 0.0 }
}

#[cfg(test)]
#[expect(clippy::approx_constant, reason = "the numbers are what USARSim's files and clients say")]
mod tests {
    use super::*;

    #[test]
    fn fixed_truncates_in_32_bits() {
        for (value, decimals, expected) in [
            (1.3, 4, "1.2999"),
            (-1.25, 4, "-1.2500"),
            (-0.00001, 4, "-0.0000"),
            (-0.0, 4, "0.0000"),
            (0.99999, 4, "0.9999"),
            (123.456, 2, "123.45"),
            (3.14159, 3, "3.141"),
            (20.0, 2, "20.00"),
            (0.098, 4, "0.0980"),
            (0.29, 2, "0.29"),
            (2.0, 4, "2.0000"),
            (-0.0004, 3, "-0.000"),
            (0.01745, 4, "0.0174"),
            (1.5707964, 3, "1.570"),
            (0.01, 4, "0.0100"),
            (8.0273, 4, "8.0272"),
            (1.571, 4, "1.5710"),
            (f32::NAN, 2, "0.00"),
            (f32::INFINITY, 2, "0.00"),
        ] {
            assert_eq!(fixed(value, decimals), expected, "fixed({value}, {decimals})");
        }
    }

    #[test]
    fn general_numbers_are_those_of_streams() {
        let rows = [
            (0.0, "0"),
            (-49.67, "-49.67"),
            (-53.649_400_086_720_37, "-53.6494"),
            (100.0, "100"),
            (999_999.5, "1e+06"),
            (123_456.0, "123456"),
            (0.0001, "0.0001"),
            (-0.000_012_345_67, "-1.23457e-05"),
            (-1e10, "-1e+10"),
            (f64::NAN, "0"),
        ];
        for (value, expected) in rows {
            assert_eq!(general(value), expected);
        }
    }

    #[test]
    fn the_engine_rounds() {
        assert_eq!(rounded(44.5467, 4), "44.5467");
        assert_eq!(rounded(std::f32::consts::TAU, 4), "6.2832");
        assert_eq!([-5.468, 27.82, -0.001].map(|number| rounded(number, 2)), ["-5.47", "27.82", "-0.00"]);
        assert_eq!(rounded(f32::NAN, 2), "0.00");
    }
}
