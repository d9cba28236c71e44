//! Fields of messages. Each has one row: key, value, format, unit and meaning. The writers of both dialects, the reader and the
//! reference are made from these rows.

use std::fmt;

use crate::dialect::Dialect;
use crate::number::{fixed, rounded};
use crate::{Block, Line};

/// The format of a written value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Format {
    /// Not written in this dialect.
    Absent,
    /// The text as it is.
    Word,
    /// A whole number.
    Integer,
    /// `True` or `False`.
    Boolean,
    /// One of two words, for false and true.
    Either([&'static str; 2]),
    /// A number of decimals, truncated.
    Fixed(u32),
    /// A number of decimals, truncated, or a bare `0` if there is no value.
    FixedOrZero(u32),
    /// A number of decimals, rounded.
    Rounded(u32),
    /// Angles, rounded, each in [0, 2 pi).
    Turns(u32),
    /// x, y and an angle, truncated, the angle in (-pi, pi].
    Pose(u32),
    /// Whole degrees, minutes with four decimals, truncated, and a letter.
    Minutes,
    /// Points with a number of decimals, truncated, each in brackets.
    Brackets(u32),
    /// Points with a number of decimals, rounded, with semicolons between them.
    Semicolons(u32),
    /// Points with a number of decimals, truncated, with blanks between them.
    Blanks(u32),
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Absent => f.write_str("-"),
            Self::Word => f.write_str("word"),
            Self::Integer => f.write_str("whole number"),
            Self::Boolean => f.write_str("`False` or `True`"),
            Self::Either([no, yes]) => write!(f, "`{no}` or `{yes}`"),
            Self::FixedOrZero(decimals) => write!(f, "{decimals} decimals, truncated, or `0`"),
            Self::Fixed(decimals) => write!(f, "{decimals} decimals, truncated"),
            Self::Rounded(decimals) => write!(f, "{decimals} decimals"),
            Self::Turns(decimals) => write!(f, "{decimals} decimals, 0 to 2 pi"),
            Self::Pose(decimals) => write!(f, "{decimals} decimals, truncated, the angle -pi to pi"),
            Self::Minutes => f.write_str("degrees, minutes of 4 decimals, truncated, letter"),
            Self::Brackets(decimals) => write!(f, "`[x,y,z][x,y,z]`, {decimals} decimals, truncated"),
            Self::Semicolons(decimals) => write!(f, "`x,y,z;x,y,z`, {decimals} decimals"),
            Self::Blanks(decimals) => write!(f, "`x,y,z x,y,z`, {decimals} decimals, truncated"),
        }
    }
}

/// A row: the definition of one block of a line. Pairs are for UDK and UT2004. A row without a key is a block of its value alone, the last
/// of its line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Field {
    /// The word before the value.
    pub key: [&'static str; 2],
    /// Format of the value.
    pub format: [Format; 2],
    /// Unit of a number, if it has one.
    pub unit: &'static str,
    /// Meaning of the value.
    pub about: &'static str,
    /// Constant blocks that follow it, by key and value. A dialect with an empty value omits the block.
    pub then: &'static [([&'static str; 2], [&'static str; 2])],
    /// Sort key of the block; blocks of equal rank stay in the table's order.
    rank: [u8; 2],
    /// True if the block follows without a space in UDK's dialect.
    tight: bool,
}

impl Field {
    /// Creates a row for both dialects.
    pub(crate) const fn new(key: &'static str, format: Format) -> Self {
        Self { key: [key; 2], format: [format; 2], unit: "", about: "", then: &[], rank: [0; 2], tight: false }
    }

    pub(crate) const fn unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }

    pub(crate) const fn about(self, about: &'static str) -> Self {
        Self { about, ..self }
    }

    /// Sets another format for UT2004's dialect.
    pub(crate) const fn ut2004(self, format: Format) -> Self {
        Self { format: [self.format[0], format], ..self }
    }

    /// Sets another key for UT2004's dialect.
    pub(crate) const fn ut2004_key(self, key: &'static str) -> Self {
        Self { key: [self.key[0], key], ..self }
    }

    /// Omits the block in UDK's dialect.
    pub(crate) const fn only_ut2004(self) -> Self {
        Self { format: [Format::Absent, self.format[1]], ..self }
    }

    /// Omits the block in UT2004's dialect.
    pub(crate) const fn only_udk(self) -> Self {
        self.ut2004(Format::Absent)
    }

    pub(crate) const fn then(self, then: &'static [([&'static str; 2], [&'static str; 2])]) -> Self {
        Self { then, ..self }
    }

    pub(crate) const fn rank(self, rank: [u8; 2]) -> Self {
        Self { rank, ..self }
    }

    pub(crate) const fn tight(self) -> Self {
        Self { tight: true, ..self }
    }

    /// Appends the block of a value, if it has one, and the constant blocks that follow it.
    pub(crate) fn write(&self, value: &impl Value, dialect: Dialect, blocks: &mut Vec<Written>) {
        let format = dialect.of(self.format);
        let (tight, rank) = (self.tight && dialect == Dialect::Udk, dialect.of(self.rank));
        if format != Format::Absent
            && let Some(value) = value.write(format)
        {
            blocks.push(Written { key: dialect.of(self.key).to_owned(), value, tight, rank });
        }
        let then = self.then.iter().map(|(key, value)| (dialect.of(*key), dialect.of(*value)));
        blocks.extend(then.filter(|(_, value)| !value.is_empty()).map(|(key, value)| Written {
            key: key.to_owned(),
            value: value.to_owned(),
            tight,
            rank,
        }));
    }

    /// Reads the value from a line, by the key of either dialect. If the block is missing and a dialect omits it, returns the
    /// default.
    pub(crate) fn read<V: Value>(&self, line: &Line) -> Option<V> {
        let [udk, ut2004] = self.key;
        if udk.is_empty() {
            let block = line.blocks.last()?;
            return V::read(Some(format!("{} {}", block.key, block.value).trim()), self.format[0]);
        }
        let (text, format) = match line.get(udk) {
            None if udk != ut2004 => (line.get(ut2004), self.format[1]),
            text if self.format[0] == Format::Absent => (text, self.format[1]),
            text => (text, self.format[0]),
        };
        if text.is_none() && self.format.contains(&Format::Absent) {
            return Some(V::default());
        }
        V::read(text, format)
    }
}

/// A block to write.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Written {
    key: String,
    value: String,
    tight: bool,
    rank: u8,
}

impl Written {
    pub(crate) fn new(key: &str, value: impl Into<String>) -> Self {
        Self { key: key.to_owned(), value: value.into(), tight: false, rank: 0 }
    }

    pub(crate) fn ranked(self, rank: u8) -> Self {
        Self { rank, ..self }
    }
}

/// Joins the blocks by rank, each with the space before it.
pub(crate) fn blocks(mut blocks: Vec<Written>) -> String {
    blocks.sort_by_key(|block| block.rank);
    let text = |Written { key, value, tight, .. }: Written| {
        let (before, between) = (if tight { "" } else { " " }, if key.is_empty() { "" } else { " " });
        format!("{before}{{{key}{between}{value}}}")
    };
    blocks.into_iter().map(text).collect()
}

/// Joins the blocks of items as UT2004 does: one brace for each item, with the space before it.
pub(crate) fn merged(blocks: &[Written]) -> String {
    let item = |blocks: &[Written]| {
        let words: Vec<String> = blocks.iter().map(|Written { key, value, .. }| format!("{key} {value}")).collect();
        format!(" {{{}}}", words.join(" "))
    };
    blocks.chunk_by(|_, next| next.key != "Name").map(item).collect()
}

/// Joins the values alone, as UDK writes poses.
pub(crate) fn bare(blocks: &[Written]) -> String {
    blocks.iter().map(|block| block.value.as_str()).collect::<Vec<_>>().join(" ")
}

/// The rows of a message, or of a part of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Table {
    /// Name of its type in this library.
    pub name: &'static str,
    /// Its meaning.
    pub about: &'static str,
    /// Its rows.
    pub fields: &'static [Field],
    /// Tables of the items that follow, each any number of times.
    pub each: &'static [Table],
}

impl Table {
    /// Splits a UT2004 item, which is one block, into UDK's blocks, one for each value. Returns any other block unchanged.
    pub(crate) fn unmerged(&self, block: &Block) -> Vec<Block> {
        let present = self.fields.iter().filter(|field| field.format[1] != Format::Absent);
        let keys: Vec<[&str; 2]> = present.map(|field| field.key).collect();
        let mut parts = vec![Block { key: block.key.clone(), value: String::new() }];
        for word in block.value.split_whitespace() {
            let next = keys.get(parts.len()).filter(|[_, key]| *key == word);
            match (next, parts.last_mut()) {
                (Some([udk, _]), Some(last)) if !last.value.is_empty() => {
                    parts.push(Block { key: (*udk).to_owned(), value: String::new() });
                }
                (_, Some(last)) => {
                    last.value += if last.value.is_empty() { "" } else { " " };
                    last.value += word;
                }
                (_, None) => {}
            }
        }
        if parts.len() == keys.len() { parts } else { vec![block.clone()] }
    }
}

/// A part of a line that has a table.
pub(crate) trait Record: Sized {
    const TABLE: Table;

    /// Returns the blocks in a dialect.
    fn write(&self, dialect: Dialect) -> Vec<Written>;

    /// Reads the blocks of a line.
    fn read(line: &Line) -> Option<Self>;
}

/// Reads the repeated items of a line. Each begins with the first key of its table.
pub(crate) fn read_each<R: Record>(line: &Line) -> Option<Vec<R>> {
    let first = R::TABLE.fields.first()?.key[0];
    let runs = line.blocks.chunk_by(|_, next| next.key != first);
    let runs = runs.filter(|run| run.first().is_some_and(|block| block.key == first));
    runs.map(|blocks| R::read(&Line { blocks: blocks.to_vec(), ..Line::default() })).collect()
}

/// Defines a struct and its table by rows: each field with its meaning, its name, its type and its [`Field`]. A repeated item
/// follows after a semicolon.
macro_rules! record {
    (
        $(#[doc = $about:literal])*
        $name:ident {
            $($(#[doc = $doc:literal])* $field:ident: $type:ty = $row:expr,)*
            $(; $(#[doc = $each_doc:literal])* $each:ident: [$item:ident])?
        }
    ) => {
        $(#[doc = $about])*
        #[derive(Debug, Clone, PartialEq)]
        pub struct $name {
            $($(#[doc = $doc])* pub $field: $type,)*
            $($(#[doc = $each_doc])* pub $each: Vec<$item>,)?
        }

        impl $crate::field::Record for $name {
            const TABLE: $crate::field::Table = $crate::field::Table {
                name: stringify!($name),
                about: concat!($($about,)*),
                fields: &[$($row.about(concat!($($doc,)*)),)*],
                each: &[$(<$item as $crate::field::Record>::TABLE)?],
            };

            #[allow(unused_mut, unused_variables, reason = "a table may have no rows of its own")]
            fn write(&self, dialect: $crate::Dialect) -> Vec<$crate::field::Written> {
                let (mut rows, mut blocks) = (Self::TABLE.fields.iter(), Vec::new());
                $(rows.next().into_iter().for_each(|row| row.write(&self.$field, dialect, &mut blocks));)*
                $(self.$each.iter().for_each(|item| blocks.extend(item.write(dialect)));)?
                blocks
            }

            #[allow(unused_mut, unused_variables, reason = "a table may have no rows of its own")]
            fn read(line: &$crate::Line) -> Option<Self> {
                let mut rows = Self::TABLE.fields.iter();
                Some(Self {
                    $($field: rows.next()?.read(line)?,)*
                    $($each: $crate::field::read_each::<$item>(line)?,)?
                })
            }
        }
    };
}
pub(crate) use record;

/// A value of a row.
pub(crate) trait Value: Default {
    /// Returns its text; `None` omits the block.
    fn write(&self, format: Format) -> Option<String>;

    /// Reads the text of a block, which may be missing.
    fn read(text: Option<&str>, format: Format) -> Option<Self>;
}

impl Value for String {
    fn write(&self, _: Format) -> Option<String> {
        Some(self.clone())
    }

    fn read(text: Option<&str>, _: Format) -> Option<Self> {
        text.map(str::to_owned)
    }
}

impl Value for bool {
    fn write(&self, format: Format) -> Option<String> {
        let [no, yes] = words(format);
        Some(if *self { yes } else { no }.to_owned())
    }

    fn read(text: Option<&str>, format: Format) -> Option<Self> {
        words(format).iter().position(|word| Some(*word) == text).map(|word| word == 1)
    }
}

fn words(format: Format) -> [&'static str; 2] {
    if let Format::Either(words) = format { words } else { ["False", "True"] }
}

macro_rules! whole_numbers {
    ($($type:ty)*) => {$(
        impl Value for $type {
            fn write(&self, _: Format) -> Option<String> {
                Some(self.to_string())
            }

            fn read(text: Option<&str>, _: Format) -> Option<Self> {
                text?.parse().ok()
            }
        }
    )*};
}
whole_numbers! { i32 u32 usize }

impl Value for f32 {
    fn write(&self, format: Format) -> Option<String> {
        Some(number(*self, format))
    }

    fn read(text: Option<&str>, _: Format) -> Option<Self> {
        text?.parse().ok()
    }
}

/// Without a value, writes a bare `0` or `0.0000`, depending on the format.
impl Value for Option<f32> {
    fn write(&self, format: Format) -> Option<String> {
        let none = || if let Format::FixedOrZero(_) = format { "0".to_owned() } else { number(0.0, format) };
        Some(self.map_or_else(none, |value| number(value, format)))
    }

    fn read(text: Option<&str>, _: Format) -> Option<Self> {
        if text? == "0" { Some(None) } else { Some(Some(text?.parse().ok()?)) }
    }
}

impl Value for [f32; 3] {
    fn write(&self, format: Format) -> Option<String> {
        let [x, y, angle] = *self;
        let values = if let Format::Pose(_) = format { [x, y, half_turned(angle)] } else { *self };
        Some(values.map(|value| number(value, format)).join(","))
    }

    fn read(text: Option<&str>, format: Format) -> Option<Self> {
        Vec::read(Some(text?), format)?.try_into().ok()
    }
}

/// An empty list has no block.
impl Value for Vec<f32> {
    fn write(&self, format: Format) -> Option<String> {
        let values: Vec<String> = self.iter().map(|&value| number(value, format)).collect();
        if values.is_empty() { None } else { Some(values.join(",")) }
    }

    fn read(text: Option<&str>, _: Format) -> Option<Self> {
        let numbers = |text: &str| text.split(',').map(|part| part.trim().parse().ok()).collect();
        text.map_or(Some(Vec::new()), numbers)
    }
}

/// An empty list has no block.
impl Value for Vec<[f32; 3]> {
    fn write(&self, format: Format) -> Option<String> {
        let (decimals, between) = match format {
            Format::Brackets(decimals) => (Format::Fixed(decimals), "]["),
            Format::Semicolons(decimals) => (Format::Rounded(decimals), ";"),
            Format::Blanks(decimals) => (Format::Fixed(decimals), " "),
            other => (other, " "),
        };
        let points: Vec<String> = self.iter().filter_map(|point| point.write(decimals)).collect();
        let text = points.join(between);
        let text = if let Format::Brackets(_) = format { format!("[{text}]") } else { text };
        if points.is_empty() { None } else { Some(text) }
    }

    fn read(text: Option<&str>, format: Format) -> Option<Self> {
        let Some(text) = text else { return Some(Vec::new()) };
        let text = text.trim_start_matches('[').trim_end_matches(']');
        let between = match format {
            Format::Brackets(_) => "][",
            Format::Semicolons(_) => ";",
            _ => " ",
        };
        text.split(between).map(|point| Value::read(Some(point), format)).collect()
    }
}

macro_rules! optional {
    ($($type:ty)*) => {$(
        /// A missing value has no block.
        impl Value for Option<$type> {
            fn write(&self, format: Format) -> Option<String> {
                self.as_ref()?.write(format)
            }

            fn read(text: Option<&str>, format: Format) -> Option<Self> {
                text.map_or(Some(None), |text| Value::read(Some(text), format).map(Some))
            }
        }
    )*};
}
optional! { [f32; 3] String usize }

fn number(value: f32, format: Format) -> String {
    match format {
        Format::Fixed(decimals) | Format::FixedOrZero(decimals) | Format::Pose(decimals) => fixed(value, decimals),
        Format::Rounded(decimals) => rounded(value, decimals),
        Format::Turns(decimals) => rounded(value.rem_euclid(std::f32::consts::TAU), decimals),
        _ => value.to_string(),
    }
}

/// Wraps an angle to (-pi, pi].
fn half_turned(angle: f32) -> f32 {
    let (angle, pi) = (f64::from(angle), std::f64::consts::PI);
    (angle - 2.0 * pi * ((angle - pi) / (2.0 * pi)).ceil()) as f32
}
