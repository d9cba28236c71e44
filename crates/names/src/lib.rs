//! Names: parts of messages about wrong ones, such as the nearest name and a list of the known ones, and free ones.

/// Most names that a message lists.
const MAX_LISTED: usize = 30;

/// Returns the known name nearest to a wrong one, in any case. A name is near if at most a third of its letters differ, or if
/// it begins with the wrong name.
pub fn nearest<'a>(wrong: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let wrong = wrong.to_lowercase();
    let distance = |name: &&str| strsim::damerau_levenshtein(&name.to_lowercase(), &wrong);
    let is_near = |name: &&str| 3 * distance(name) <= name.chars().count().max(3);
    let begins_so = |name: &&str| wrong.chars().count() > 2 && name.to_lowercase().starts_with(&wrong);
    known.into_iter().filter(|name| is_near(name) || begins_so(name)).min_by_key(distance)
}

/// Returns the nearest name as a suffix of a message; empty if no name is near.
pub fn did_you_mean<'a>(wrong: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    nearest(wrong, known).map_or(String::new(), |name| format!(" (did you mean `{name}`?)"))
}

/// Lists names in a message.
pub fn listed<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let names: Vec<&str> = names.into_iter().collect();
    let more = names.len().saturating_sub(MAX_LISTED);
    let text = names[..names.len() - more].join(", ");
    if more == 0 { text } else { format!("{text} and {more} more") }
}

/// Formats a number of things: `1 file`, `2 files`.
pub fn count(number: usize, thing: &str) -> String {
    let end = if number == 1 { "" } else { "s" };
    format!("{number} {thing}{end}")
}

/// Returns a name that is free: the wanted one, or that with the first number from 2 that makes it free, as `cart_2`.
pub fn free(wanted: &str, is_free: impl Fn(&str) -> bool) -> String {
    let mut names = std::iter::once(wanted.to_owned()).chain((2..).map(|number: u64| format!("{wanted}_{number}")));
    names.find(|name| is_free(name)).unwrap_or_default()
}

/// The examples of the README, as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_free_name_is_the_wanted_one_or_has_the_first_number_that_is_free() {
        for (taken, expected) in
            [(&[][..], "cart"), (&["cart_2"], "cart"), (&["cart"], "cart_2"), (&["cart", "cart_2"], "cart_3")]
        {
            assert_eq!(free("cart", |name| !taken.contains(&name)), expected, "{taken:?}");
        }
    }

    #[test]
    fn the_nearest_name_is_found_and_a_far_one_is_not() {
        let classes = ["AirRobot", "KUKA_YouBot", "P2DX", "P3AT", "YouBot", "YouBotArm"];
        for (wrong, expected) in [
            ("KUKAYouBot", Some("KUKA_YouBot")),
            ("youbot", Some("YouBot")),
            ("kuka", Some("KUKA_YouBot")),
            ("P3TA", Some("P3AT")),
            ("Airrobot", Some("AirRobot")),
            ("Nao", None),
            ("", None),
        ] {
            assert_eq!(nearest(wrong, classes), expected, "{wrong}");
        }
        assert_eq!(did_you_mean("gian", ["mass", "gain"]), " (did you mean `gain`?)");
        assert_eq!(did_you_mean("gian", ["mass"]), "");
    }

    #[test]
    fn a_long_list_is_cut() {
        assert_eq!(listed(["a", "b"]), "a, b");
        assert!(listed(["a"; 40]).ends_with("a, a and 10 more"));
    }

    #[test]
    fn one_has_no_plural() {
        assert_eq!([0, 1, 2].map(|number| count(number, "file")), ["0 files", "1 file", "2 files"]);
    }
}
