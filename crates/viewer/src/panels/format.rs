//! Numbers as text, the same everywhere in the window.

/// A count in groups of three digits: `1 234 567`.
pub fn count(n: u64) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push('\u{a0}');
        }
        text.push(digit);
    }
    text
}

/// A count with its noun: `1 light`, `2 lights`.
pub fn counted(n: u64, noun: &str) -> String {
    let plural = match n {
        1 => "",
        _ if noun.ends_with('x') || noun.ends_with("sh") => "es",
        _ => "s",
    };
    format!("{} {noun}{plural}", count(n))
}

/// A rate with three digits: `12.3 M`, `870 k`.
pub fn rate(per_second: f64) -> String {
    let (value, unit) = match per_second {
        x if x >= 1e9 => (x / 1e9, "G"),
        x if x >= 1e6 => (x / 1e6, "M"),
        x => (x / 1e3, "k"),
    };
    let decimals = if value < 9.995 {
        2
    } else {
        usize::from(value < 99.95)
    };
    format!("{value:.decimals$} {unit}")
}

/// A round number in short: `5`, `20 k`, `1 M`.
pub fn si(value: f64) -> String {
    let (value, unit) = match value {
        x if x >= 1e12 => (x / 1e12, " T"),
        x if x >= 1e9 => (x / 1e9, " G"),
        x if x >= 1e6 => (x / 1e6, " M"),
        x if x >= 1e3 => (x / 1e3, " k"),
        x => (x, ""),
    };
    format!("{value}{unit}")
}

/// A time with three digits: `0.123 s`, `12.3 s`, `123 s`.
pub fn seconds(seconds: f64) -> String {
    format!("{seconds:.*} s", seconds_decimals(seconds))
}

/// A time and how far off it may be: `12.0 s ± 2.1`.
pub fn seconds_within(value: f64, half: f64) -> String {
    format!("{} ± {half:.*}", seconds(value), seconds_decimals(value))
}

fn seconds_decimals(seconds: f64) -> usize {
    match seconds {
        x if x >= 99.95 => 0,
        x if x >= 9.995 => 1,
        x if x >= 0.9995 => 2,
        _ => 3,
    }
}

/// Seconds as minutes and seconds, or hours: `0:07`, `1:02:03`.
pub fn clock(seconds: f64) -> String {
    // No picture takes longer than what still fits.
    let s = seconds.clamp(0.0, 3.6e9) as u64;
    let (h, m, s) = (s / 3600, s / 60 % 60, s % 60);
    if h > 0 {
        format!("{h}:{m:02}:{s:02}")
    } else {
        format!("{m}:{s:02}")
    }
}

/// Time that is left, or `-:--` while nobody knows.
pub fn eta(seconds: Option<f64>) -> String {
    // Rounded up: "0:00 left" would be over.
    seconds.map_or_else(|| "-:--".into(), |s| clock(s.ceil()))
}

/// A relative error in per cent with two digits: `12 %`, `0.34 %`.
pub fn percent(share: f64) -> String {
    format!("{:.*} %", percent_decimals(share), share * 100.0)
}

/// A relative error and how far off it may be: `1.2 % ± 0.1`.
pub fn percent_within(share: f64, half: f64) -> String {
    format!(
        "{} ± {:.*}",
        percent(share),
        percent_decimals(share),
        half * 100.0
    )
}

fn percent_decimals(share: f64) -> usize {
    match share * 100.0 {
        x if x >= 9.95 => 0,
        x if x >= 0.995 => 1,
        x if x >= 0.0995 => 2,
        _ => 3,
    }
}

/// A length with four digits, without trailing zeros.
pub fn length(x: f32) -> String {
    let magnitude = x.abs();
    if magnitude != 0.0 && !(1e-3..1e6).contains(&magnitude) {
        return format!("{x:.2e}");
    }
    let decimals = match magnitude {
        m if m >= 999.95 => 0,
        m if m >= 99.995 => 1,
        m if m >= 9.9995 => 2,
        _ => 3,
    };
    format!("{x:.decimals$}")
}

/// A number with up to three digits, without trailing zeros: `0.0312`, `16`, `1.5e-7`.
pub fn short(x: f32) -> String {
    let magnitude = x.abs();
    if magnitude != 0.0 && !(1e-4..1e6).contains(&magnitude) {
        return format!("{x:.1e}");
    }
    let decimals = match magnitude {
        0.0 => 0,
        m => (2 - m.log10().floor() as i32).max(0) as usize,
    };
    let text = format!("{x:.decimals$}");
    if decimals == 0 {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_grouped() {
        let shown = [0, 999, 1000, 1_234_567].map(|n| count(n).replace('\u{a0}', " "));
        assert_eq!(shown, ["0", "999", "1 000", "1 234 567"]);
        assert_eq!(
            [counted(1, "light"), counted(2, "light"), counted(2, "mesh")],
            ["1 light", "2 lights", "2 meshes"]
        );
    }

    #[test]
    fn rates_have_three_digits() {
        assert_eq!(
            [12.34e6, 1.0e6, 870e3, 0.0, 2.5e9, 123.4e6].map(rate),
            ["12.3 M", "1.00 M", "870 k", "0.00 k", "2.50 G", "123 M"]
        );
    }

    #[test]
    fn figures_and_what_they_may_be_off_have_the_same_digits() {
        assert_eq!(
            [0.0, 0.0123, 7.324, 12.345, 124.4].map(seconds),
            ["0.000 s", "0.012 s", "7.32 s", "12.3 s", "124 s"]
        );
        assert_eq!(seconds_within(12.0, 2.123), "12.0 s ± 2.1");
        assert_eq!(percent_within(0.0141, 0.0012), "1.4 % ± 0.1");
        assert_eq!([5.0, 2e4, 1e6, 3e9].map(si), ["5", "20 k", "1 M", "3 G"]);
    }

    #[test]
    fn times_are_clocks() {
        assert_eq!(
            [0.0, 7.9, 61.0, 3723.0, -1.0, f64::INFINITY].map(clock),
            ["0:00", "0:07", "1:01", "1:02:03", "0:00", "1000000:00:00"]
        );
        assert_eq!(
            [None, Some(0.2), Some(59.5)].map(eta),
            ["-:--", "0:01", "1:00"]
        );
    }

    #[test]
    fn shares_and_lengths_keep_their_digits() {
        assert_eq!(
            [0.5, 0.0123, 0.00123, 0.0].map(percent),
            ["50 %", "1.2 %", "0.12 %", "0.000 %"]
        );
        assert_eq!(
            [3.24159, 12.3456, 123.45, 1234.5, 0.0, 1e-5].map(length),
            ["3.242", "12.35", "123.4", "1234", "0.000", "1.00e-5"]
        );
        assert_eq!(
            [0.03125, 16.0, -1.5, 100.0, 1e-7, 0.0].map(short),
            ["0.0312", "16", "-1.5", "100", "1.0e-7", "0"]
        );
    }
}
