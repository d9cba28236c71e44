//! Wrong names: what was most likely meant, and what there is. Every message about one is made of these.

/// Most names that a message lists.
const MAX_LISTED: usize = 30;

/// What a wrong name was most likely meant to be. Near is a name of which at most a third of the letters are others, in any case, or
/// one that begins so.
pub fn nearest<'a>(wrong: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let wrong = wrong.to_lowercase();
    let distance = |name: &&str| strsim::damerau_levenshtein(&name.to_lowercase(), &wrong);
    let is_near = |name: &&str| 3 * distance(name) <= name.chars().count().max(3);
    let begins_so = |name: &&str| wrong.chars().count() > 2 && name.to_lowercase().starts_with(&wrong);
    known.into_iter().filter(|name| is_near(name) || begins_so(name)).min_by_key(distance)
}

/// The nearest name for a message, behind the wrong one or at the end; nothing where none is near.
pub fn did_you_mean<'a>(wrong: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    nearest(wrong, known).map_or(String::new(), |name| format!(" (did you mean `{name}`?)"))
}

/// Names for a message.
pub fn listed<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let names: Vec<&str> = names.into_iter().collect();
    let more = names.len().saturating_sub(MAX_LISTED);
    let text = names[..names.len() - more].join(", ");
    if more == 0 { text } else { format!("{text} and {more} more") }
}

/// A number of things: `1 file`, `2 files`.
pub fn count(number: usize, thing: &str) -> String {
    let end = if number == 1 { "" } else { "s" };
    format!("{number} {thing}{end}")
}

#[cfg(test)]
mod tests {
    use super::*;

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
