//! Overrides of numbers in files: `robot.wheels.gain=2.5`, `map.gravity=1.62`, `material.carpet.friction=0.5`.

use std::collections::BTreeSet;
use std::str::FromStr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use names::did_you_mean;
use toml_edit::{DocumentMut, Item, TableLike, Value};

use crate::LoadError;

/// Scopes other than classes of robots.
const SCOPES: [&str; 3] = ["robot", "map", "material"];

/// One `path=value`.
///
/// The path begins with a scope: `robot` (every class with a matching key), the name of a class, `map` or `material`. The rest are
/// the keys of the file. In an array a key is an index (0 ...) or the `name` of an element; without it, all elements are set.
/// `robot.roller_friction` is short for `robot.rollers.friction`.
#[derive(Debug, Clone)]
pub struct Override {
    /// Original text.
    text: String,
    scope: String,
    keys: Vec<String>,
    value: Value,
    found: Arc<Mutex<Found>>,
}

/// Use of an override by the files read so far.
#[derive(Debug, Default)]
struct Found {
    /// True if a file used it.
    used: bool,
    /// First message of a file that rejected it.
    refusal: Option<String>,
    /// Every path that it could have named.
    paths: BTreeSet<String>,
}

impl Override {
    fn found(&self) -> MutexGuard<'_, Found> {
        self.found.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn refused(&self, reason: String) -> LoadError {
        LoadError::Override { text: self.text.clone(), reason }
    }
}

impl FromStr for Override {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = "expected PATH=VALUE, as in robot.wheels.gain=2.5";
        let (path, value) = text.split_once('=').ok_or(expected)?;
        let mut keys = path.trim().split('.').map(str::to_owned);
        let scope = keys.next().unwrap_or_default();
        let keys: Vec<String> = match keys.collect::<Vec<_>>() {
            keys if keys == ["roller_friction"] => ["rollers", "friction"].map(str::to_owned).to_vec(),
            keys => keys,
        };
        if keys.is_empty() || keys.iter().any(String::is_empty) {
            return Err(expected.to_owned());
        }
        let value = value.trim();
        let value = value.parse().unwrap_or_else(|_| Value::from(value));
        Ok(Self { text: text.to_owned(), scope, keys, value, found: Arc::default() })
    }
}

/// Applies every override with a scope among the names to the text of a file. A text that is not TOML stays unchanged; its reader
/// reports the problem. Keys that do not count (`without`) are removed before.
pub(crate) fn apply(text: String, overrides: &[Override], names: &[&str], without: &[&str]) -> String {
    let mut wanted = overrides.iter().filter(|it| names.iter().any(|name| name.eq_ignore_ascii_case(&it.scope)));
    let Some(first) = wanted.next() else { return text };
    let Ok(mut document) = text.parse::<DocumentMut>() else { return text };
    without.iter().for_each(|key| {
        document.remove(key);
    });
    let mut known = BTreeSet::new();
    paths(document.as_table(), "", &mut known);
    for it in std::iter::once(first).chain(wanted) {
        let mut found = it.found();
        found.paths.extend(known.iter().cloned());
        found.used |= set(document.as_item_mut(), &it.keys, &it.value);
    }
    document.to_string()
}

/// Checks that every override was used.
///
/// # Errors
/// Reports the first one that was not.
pub fn check_used(overrides: &[Override]) -> Result<(), LoadError> {
    let unused = overrides.iter().find(|it| !it.found().used);
    unused.map_or(Ok(()), |it| Err(it.refused(it.why_unused())))
}

impl Override {
    fn why_unused(&self) -> String {
        let Found { refusal, paths, .. } = &*self.found();
        let path = self.keys.join(".");
        if paths.is_empty() {
            let classes = crate::robot_names();
            let scopes = || SCOPES.into_iter().chain(classes.iter().map(String::as_str));
            if scopes().any(|known| known.eq_ignore_ascii_case(&self.scope)) {
                return format!("nothing that is read here is a `{}`", self.scope);
            }
            let meant = did_you_mean(&self.scope, scopes());
            return format!("no `{}`{meant}: expected robot, map, material or a class of robots", self.scope);
        }
        let nearest = names::nearest(&path, paths.iter().map(String::as_str));
        // If no path is near, the keys that a file's reader lists are more helpful.
        if let Some(refusal) = refusal.as_ref().filter(|_| nearest.is_none()) {
            return refusal.clone();
        }
        let meant = nearest.map_or(String::new(), |meant| format!(" (did you mean `{}.{meant}`?)", self.scope));
        format!("nothing that is read here has `{path}`{meant}; `usarsim show robot|map NAME` lists what there is")
    }
}

/// Collects the paths of every value in a table, with and without the names of an array's elements.
fn paths(table: &dyn TableLike, before: &str, found: &mut BTreeSet<String>) {
    for (key, item) in table.iter() {
        let path = if before.is_empty() { key.to_owned() } else { format!("{before}.{key}") };
        if let Some(table) = item.as_table_like() {
            paths(table, &path, found);
        } else if let Some(tables) = item.as_array_of_tables() {
            for table in tables {
                paths(table, &path, found);
                if let Some(name) = table.get("name").and_then(Item::as_str) {
                    paths(table, &format!("{path}.{name}"), found);
                }
            }
        } else {
            found.insert(path);
        }
    }
}

/// Reads with overrides, and attributes errors to them. An override with a key unknown to this file is left out, as another file
/// may have the key. [`check_used`] rejects overrides that no file used. Other errors that occur only with overrides are reported
/// for the first override that fails alone, otherwise for all.
///
/// # Errors
/// As `read`.
pub(crate) fn blame<T>(
    overrides: &[Override],
    read: impl Fn(&[Override]) -> Result<T, LoadError>,
) -> Result<T, LoadError> {
    let used: Vec<bool> = overrides.iter().map(|it| it.found().used).collect();
    match read(overrides) {
        Err(LoadError::Bad(_)) if !overrides.is_empty() && read(&[]).is_ok() => {}
        result => return result,
    }
    let mut fitting = Vec::new();
    for (it, used) in overrides.iter().zip(used) {
        let Err(LoadError::Bad(problems)) = read(std::slice::from_ref(it)) else {
            fitting.push(it.clone());
            continue;
        };
        let reason = problems.first().map_or_else(String::new, |first| format!("{}: {}", first.file, first.message));
        if !problems.iter().any(|problem| problem.is_unknown_key()) {
            return Err(it.refused(reason));
        }
        let mut found = it.found();
        found.used = used;
        found.refusal.get_or_insert(reason);
    }
    read(&fitting).map_err(|error| match error {
        LoadError::Bad(problems) => {
            let text = fitting.iter().map(|it| it.text.as_str()).collect::<Vec<_>>().join(" --set ");
            let reason = problems.first().map_or_else(String::new, |it| format!("{}: {}", it.file, it.message));
            LoadError::Override { text, reason }
        }
        error => error,
    })
}

/// Sets the value at a path. New keys are inserted into existing tables; the reader of the file rejects those it does not know.
fn set(item: &mut Item, keys: &[String], value: &Value) -> bool {
    let Some((key, rest)) = keys.split_first() else { return replace(item, value) };
    if let Some(tables) = item.as_array_of_tables_mut() {
        let named = |table: &toml_edit::Table| table.get("name").and_then(Item::as_str) == Some(key);
        if let Some(table) = key.parse().ok().and_then(|index: usize| tables.get_mut(index)) {
            return set_in(table, rest, value);
        }
        if let Some(table) = tables.iter_mut().find(|table| named(table)) {
            return set_in(table, rest, value);
        }
        // A key that is neither an index nor a name sets every element, not only the first.
        return tables.iter_mut().filter_map(|table| set_in(table, keys, value).then_some(())).count() > 0;
    }
    if let Some(array) = item.as_array_mut() {
        let element = key.parse().ok().and_then(|index: usize| array.get_mut(index));
        return rest.is_empty() && element.map(|element| *element = value.clone()).is_some();
    }
    item.as_table_mut().is_some_and(|table| set_in(table, keys, value))
}

fn set_in(table: &mut toml_edit::Table, keys: &[String], value: &Value) -> bool {
    match keys {
        [] => false,
        [key] if !table.contains_key(key) => {
            // A missing key is created, a missing table is not.
            table.insert(key, Item::Value(value.clone()));
            true
        }
        [key, rest @ ..] => table.get_mut(key).is_some_and(|item| set(item, rest, value)),
    }
}

fn replace(item: &mut Item, value: &Value) -> bool {
    let Item::Value(old) = item else { return false };
    let decor = old.decor().clone();
    *old = value.clone();
    *old.decor_mut() = decor;
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "gravity = 9.81 # m/s²\n[wheels]\ngain = 4\n[[wheel]]\nname = \"FL\"\nplace = [1, 2]\n[[wheel]]\nname = \"FR\"\n";

    #[track_caller]
    fn check(text: &str, expected: &str) {
        let it: Override = text.parse().expect("an override");
        assert_eq!(apply(FILE.to_owned(), std::slice::from_ref(&it), &["robot"], &[]).trim(), expected.trim());
        assert_eq!(it.found().used, FILE.trim() != expected.trim());
    }

    #[test]
    fn paths_name_keys_elements_and_all_elements() {
        check("robot.gravity=1.62", &FILE.replace("9.81", "1.62"));
        check("robot.wheels.gain=2.5", &FILE.replace("gain = 4", "gain = 2.5"));
        check("robot.wheels.armature=0.1", &FILE.replace("gain = 4", "gain = 4\narmature = 0.1"));
        check("robot.wheel.FL.place.1=7", &FILE.replace("[1, 2]", "[1, 7]"));
        check("robot.wheel.1.mass=2", &FILE.replace("\"FR\"", "\"FR\"\nmass = 2"));
        check(
            "robot.wheel.mass=2",
            &FILE.replace("place = [1, 2]", "place = [1, 2]\nmass = 2").replace("\"FR\"", "\"FR\"\nmass = 2"),
        );
        check("map.gravity=1", FILE);
        check("robot.rollers.mass=1", FILE);
        check("robot.roller_friction=1", FILE);
    }

    #[test]
    fn the_paths_of_a_file_are_those_that_an_override_can_have() {
        let document: DocumentMut = FILE.parse().expect("TOML");
        let mut found = BTreeSet::new();
        paths(document.as_table(), "", &mut found);
        let expected = "gravity wheel.FL.name wheel.FL.place wheel.FR.name wheel.name wheel.place wheels.gain";
        assert_eq!(found.into_iter().collect::<Vec<_>>().join(" "), expected);
    }

    #[test]
    fn what_is_no_path_and_value_is_refused() {
        for text in ["robot", "robot=1", "robot.=1", "=1", "robot..gain=1"] {
            assert!(text.parse::<Override>().is_err(), "{text}");
        }
    }
}
