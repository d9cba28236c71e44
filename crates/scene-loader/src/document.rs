//! A TOML file, read piece by piece so that one mistake does not hide the next.

use std::collections::BTreeMap;
use std::ops::Range;

use names::{did_you_mean, listed};
use scene::Material;
use scene::check::Range as Bounds;
use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};

use crate::problem::{Problems, Unread};

/// Message for tables and arrays nested too deep: the parser takes 80 levels.
const TOO_DEEP: &str = "nested too deep: expected at most 80 levels";

/// A file, its text, and the problems found in it.
pub(crate) struct Document<'a> {
    file: &'a str,
    text: &'a str,
    problems: &'a mut Problems,
}

/// A table of the file with its position.
pub(crate) struct Table<'a> {
    span: Range<usize>,
    entries: DeTable<'a>,
}

impl<'a> Document<'a> {
    /// Parses the syntax. Reports only the first syntax error, as later text may be misread after it.
    pub(crate) fn parse(file: &'a str, text: &'a str, problems: &'a mut Problems) -> Option<(Self, Table<'a>)> {
        match DeTable::parse(text) {
            Ok(root) => Some((Self { file, text, problems }, Table { span: 0..0, entries: root.into_inner() })),
            Err(error) => {
                let place = error.span().map_or(0, |span| span.start);
                // The parser stops before it recurses too far, and reports that in two ways.
                match error.message() {
                    message if message.contains("recurs") => problems.at(file, text, place, TOO_DEEP),
                    message => problems.at(file, text, place, message),
                }
                None
            }
        }
    }

    /// Reports a problem at a position.
    pub(crate) fn problem(&mut self, span: &Range<usize>, message: impl std::fmt::Display) {
        self.problems.at(self.file, self.text, span.start, message);
    }

    /// Reports the problems of the entry at a position.
    pub(crate) fn wrong(&mut self, span: &Range<usize>, messages: impl IntoIterator<Item = String>) {
        messages.into_iter().for_each(|message| self.problem(span, message));
    }

    /// Reports a problem unless a number is within its range.
    pub(crate) fn within(&mut self, span: &Range<usize>, key: &str, value: f64, range: Bounds) -> bool {
        let problem = range.problem(key, value);
        let good = problem.is_none();
        self.wrong(span, problem);
        good
    }

    /// Reports the problems of the file as a whole, if it has no others.
    pub(crate) fn as_a_whole(&mut self, check: impl FnOnce() -> Vec<String>) {
        if self.problems.count() == 0 {
            self.wrong(&(0..0), check());
        }
    }

    /// Returns the problems, to add those of other files.
    pub(crate) fn problems(&mut self) -> &mut Problems {
        self.problems
    }

    /// Takes a value out of a table. Returns `None` if it is missing, or if it has the wrong type, which is reported.
    pub(crate) fn optional<T: DeserializeOwned>(&mut self, table: &mut Table<'a>, key: &str) -> Option<T> {
        let value = table.entries.remove(key)?;
        self.read(value).map(|(_, value)| value)
    }

    /// Takes a required value out of a table.
    pub(crate) fn required<T: DeserializeOwned>(&mut self, table: &mut Table<'a>, key: &str, what: &str) -> Option<T> {
        if !table.entries.contains_key(key) {
            self.problem(&table.span, format_args!("missing `{key}`: expected {what}"));
        }
        self.optional(table, key)
    }

    /// Takes an array of tables and reads each by itself. Tables with a mistake are left out.
    pub(crate) fn list<T: DeserializeOwned>(&mut self, table: &mut Table<'a>, key: &str) -> Vec<(Range<usize>, T)> {
        let elements = self.elements(table, key);
        elements.into_iter().filter_map(|element| self.read(element)).collect()
    }

    /// Takes an array of tables, to be read key by key.
    pub(crate) fn tables(&mut self, table: &mut Table<'a>, key: &str) -> Vec<Table<'a>> {
        let elements = self.elements(table, key);
        elements.into_iter().filter_map(|element| self.as_table(element)).collect()
    }

    /// Takes a table, to be read key by key.
    pub(crate) fn table(&mut self, table: &mut Table<'a>, key: &str) -> Option<Table<'a>> {
        let value = table.entries.remove(key)?;
        self.as_table(value)
    }

    fn as_table(&mut self, value: Spanned<DeValue<'a>>) -> Option<Table<'a>> {
        let span = value.span();
        match value.into_inner() {
            DeValue::Table(entries) => Some(Table { span, entries }),
            other => {
                self.problem(&span, format_args!("expected a table, got {}", other.type_str()));
                None
            }
        }
    }

    /// Takes one table or value with its position.
    pub(crate) fn section<T: DeserializeOwned>(
        &mut self,
        table: &mut Table<'a>,
        key: &str,
    ) -> Result<Option<(Range<usize>, T)>, Unread> {
        table.entries.remove(key).map(|value| self.read(value).ok_or(Unread)).transpose()
    }

    /// Takes all remaining entries as named tables.
    pub(crate) fn named<T: DeserializeOwned>(&mut self, table: &mut Table<'a>) -> Vec<(Range<usize>, String, T)> {
        let entries = std::mem::take(&mut table.entries);
        let read = |(key, value): (Spanned<_>, _)| {
            let span = key.span();
            let name: toml::de::DeString = key.into_inner();
            self.read(value).map(|(_, value)| (span, name.into_owned(), value))
        };
        entries.into_iter().filter_map(read).collect()
    }

    /// Reports every key that was not taken.
    pub(crate) fn finish(&mut self, table: Table<'a>, expected: &str) {
        for key in table.entries.keys() {
            let suggestion = did_you_mean(key.get_ref(), expected.split(", ").map(str::trim));
            let key_name = key.get_ref();
            self.problem(&key.span(), format_args!("unknown key `{key_name}`: expected one of {expected}{suggestion}"));
        }
    }

    /// Reads the rest of a table as a whole.
    pub(crate) fn rest<T>(
        &mut self,
        table: Table<'a>,
        read: impl FnOnce(ValueDeserializer<'a>) -> Result<T, toml::de::Error>,
    ) -> Option<T> {
        let Table { span, entries } = table;
        let value = Spanned::new(span.clone(), DeValue::Table(entries));
        self.result(&span, read(ValueDeserializer::from(value)))
    }

    /// Looks up a material. An unknown one is reported and replaced by the default, so that its users can still be checked.
    pub(crate) fn material(
        &mut self,
        span: &Range<usize>,
        name: &str,
        materials: &BTreeMap<String, Material>,
    ) -> Material {
        materials.get(name).cloned().unwrap_or_else(|| {
            let known = || materials.keys().map(String::as_str);
            let (names, suggestion) = (listed(known()), did_you_mean(name, known()));
            self.problem(span, format_args!("unknown material `{name}`: expected one of {names}{suggestion}"));
            Material::default()
        })
    }

    /// Returns the index of a name among the known ones. An unknown name is reported with the nearest one.
    pub(crate) fn one_of<'n>(
        &mut self,
        span: &Range<usize>,
        key: &str,
        name: &str,
        known: impl Iterator<Item = &'n str> + Clone,
    ) -> Option<usize> {
        let number = known.clone().position(|other| other == name);
        if number.is_none() {
            let suggestion = did_you_mean(name, known.clone());
            self.problem(span, format_args!("`{key}` is `{name}`: expected one of {}{suggestion}", listed(known)));
        }
        number
    }

    fn elements(&mut self, table: &mut Table<'a>, key: &str) -> Vec<Spanned<DeValue<'a>>> {
        let Some(value) = table.entries.remove(key) else { return Vec::new() };
        let span = value.span();
        match value.into_inner() {
            DeValue::Array(array) => array.into_iter().collect(),
            other => {
                self.problem(&span, format_args!("expected [[{key}]] tables, got {}", other.type_str()));
                Vec::new()
            }
        }
    }

    fn read<T: DeserializeOwned>(&mut self, value: Spanned<DeValue<'a>>) -> Option<(Range<usize>, T)> {
        let span = value.span();
        let result = T::deserialize(ValueDeserializer::from(value));
        self.result(&span, result).map(|value| (span, value))
    }

    fn result<T>(&mut self, span: &Range<usize>, result: Result<T, toml::de::Error>) -> Option<T> {
        match result {
            Ok(value) => Some(value),
            Err(error) => {
                let place = error.span().unwrap_or_else(|| span.clone());
                // serde puts the wrong name first, then the known ones.
                let names: Vec<&str> = error.message().split('`').skip(1).step_by(2).collect();
                let suggestion = match names.split_first() {
                    Some((wrong, known)) if error.message().starts_with("unknown ") => {
                        did_you_mean(wrong, known.iter().copied())
                    }
                    _ => String::new(),
                };
                self.problem(&place, format_args!("{}{suggestion}", error.message()));
                None
            }
        }
    }
}

impl<'a> Table<'a> {
    /// True if a key has not been taken.
    pub(crate) fn has(&self, key: &str) -> bool {
        self.entries.contains_key(key)
    }

    /// Adds a value in TOML for a key that the table does not have.
    pub(crate) fn add_default(&mut self, key: &'a str, value: &'a str) {
        if !self.has(key)
            && let Ok(value) = DeValue::parse(value)
        {
            let value = Spanned::new(self.span(), value.into_inner());
            self.entries.insert(Spanned::new(self.span(), key.into()), value);
        }
    }

    /// Removes keys that do not count, so that they are not reported.
    pub(crate) fn forget(&mut self, keys: &[&str]) {
        for key in keys {
            self.entries.remove(*key);
        }
    }

    /// Returns the keys that have not been taken, with their positions.
    pub(crate) fn keys(&self) -> Vec<(Range<usize>, String)> {
        self.entries.keys().map(|key| (key.span(), key.get_ref().to_string())).collect()
    }

    /// Returns the position of the table.
    pub(crate) fn span(&self) -> Range<usize> {
        self.span.clone()
    }
}

/// A vector of three numbers.
pub(crate) type Vector = [f64; 3];
