//! USARSim's ini files: the items of `[USARBot.X]` and `[USARActuator.X]`, and the settings of `[USARSensor.X]`.
//!
//! A line that USARSim would ignore is a warning, and the rest is used. Packages do not matter beyond their beginning with USAR, so the
//! sensors of UT2004, which are in USARBot, and DefaultUSAR.ini's misnamed `[USARBot.GPSSensor]` are found.

mod put_on;

use std::collections::BTreeMap;

use names::did_you_mean;
use scene::sensor::{self, Config};

use super::MAX_ITEMS;
use super::classes::{self, Row, is_among};
use super::ini::{self, Field, Value};
use crate::problem::{FileProblem, Problems};
use crate::shipped;

/// Most lines without an effect that are reported.
const MAX_NOTES: usize = 100;
/// Packages that begin with USAR and have neither robots nor their items.
const OTHER_PACKAGES: [&str; 5] = ["USARBotAPI", "USARUtility", "USARAvatar", "USARGame", "USARPhysObj"];
/// Keys of robots whose values are items.
const ITEM_KEYS: [&str; 6] = ["AddParts", "Sensors", "Cameras", "Effecters", "MisPkgs", "HeadLight"];
/// Keys of robots and actuators that this server leaves to itself.
const WITHOUT_EFFECT: [&str; 12] = [
    "msgTimer",
    "bUseVolumeOverride",
    "volumeOverride",
    "bDebug",
    "bMountByUU",
    "ScanInterval",
    "positionTolerance",
    "angleTolerance",
    "defaultItem",
    "dropCheckFrequency",
    "VacuumForce",
    "bAbsoluteTilt",
];

/// A file and its text.
type Text = (String, String);

/// A position in one of the files.
#[derive(Debug, Clone, Copy)]
struct Place {
    file: usize,
    at: usize,
}

/// The ini files, read one after the other.
#[derive(Debug, Default)]
pub(super) struct Inis {
    texts: Vec<Text>,
    /// Items of classes, by their names in lower case.
    classes: BTreeMap<String, Carried>,
    /// Settings of classes of sensors that replace their defaults, by the class of robot.toml.
    settings: BTreeMap<&'static str, Vec<(&'static str, String)>>,
    /// Values of the sections of sensors, by the class of USARSim and the key in lower case.
    values: BTreeMap<(&'static str, String), String>,
    warnings: Vec<FileProblem>,
}

/// The items of a class of robots or actuators.
#[derive(Debug)]
struct Carried {
    /// Name as its first section spells it.
    class: String,
    place: Place,
    items: Vec<Item>,
    /// True if the items replace those of the class. Otherwise they are added.
    replaces: bool,
    /// Time from full to empty of a robot of UT2004, s.
    battery_life: Option<f64>,
}

/// An item: a sensor or an actuator at a place on the robot.
#[derive(Debug, Clone)]
struct Item {
    place: Place,
    kind: Kind,
    name: String,
    parent: String,
    position: [f64; 3],
    direction: [f64; 3],
}

#[derive(Debug, Clone)]
enum Kind {
    Sensor(&'static Row),
    Mount(String),
}

impl std::fmt::Debug for Row {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

impl Inis {
    /// Reads files with their names, the later ones after the earlier ones.
    pub(super) fn read(texts: Vec<Text>, problems: &mut Problems) -> Self {
        let mut reader = Reader::default();
        for (file, (_, text)) in texts.iter().enumerate() {
            reader.read_file(file, text);
        }
        let Reader { classes, values, notes, places, .. } = reader;
        let mut warnings = Problems::default();
        for (place, message) in notes {
            let (file, text) = &texts[place.file];
            warnings.at(file, text, place.at, message);
        }
        let mut inis = Self { texts, classes, values, warnings: warnings.into_list(), ..Self::default() };
        for (class, _) in sensor::CLASSES {
            let Some(row) = classes::rows().find(|row| row.here == Some(*class)) else { continue };
            let mut settings = inis.settings_of(row);
            settings.retain(|(key, _)| !OF_BATTERIES.contains(key));
            if let Err(message) = check_settings(class, &settings) {
                let place = row.chain().find_map(|row| places.get(row.name()).copied());
                inis.problem(problems, place.unwrap_or(Place { file: 0, at: 0 }), format_args!("{class}: {message}"));
            }
            inis.settings.insert(class, settings);
        }
        inis
    }

    /// Reports a problem at a place of one of the files.
    fn problem(&self, problems: &mut Problems, place: Place, message: impl std::fmt::Display) {
        if let Some((file, text)) = self.texts.get(place.file) {
            problems.at(file, text, place.at, message);
        }
    }

    /// Returns the settings that the sections give a class of sensors: keys of robot.toml, and values in TOML.
    fn settings_of(&self, row: &'static Row) -> Vec<(&'static str, String)> {
        let mut settings: Vec<(&'static str, String)> = Vec::new();
        for (key, here) in row.all_keys().filter(|(_, here)| !here.is_empty()) {
            if let Some(value) = self.value(row, key) {
                settings.push((here, value));
            }
        }
        for (key, value) in row.settings {
            if !settings.iter().any(|(known, _)| known == key) {
                settings.push((key, (*value).to_owned()));
            }
        }
        settings
    }

    /// Returns the value of a key that is in effect for a class, if the files set it.
    fn value(&self, row: &'static Row, key: &str) -> Option<String> {
        for row in row.chain() {
            if let Some(value) = self.values.get(&(row.name(), key.to_lowercase())) {
                return Some(value.clone());
            }
            if row.owns(key) {
                return None;
            }
        }
        None
    }

    fn carried(&self, class: &str) -> Option<&Carried> {
        self.classes.get(&class.to_lowercase())
    }

    pub(super) fn has(&self, class: &str) -> bool {
        self.carried(class).is_some()
    }

    pub(super) fn replaces(&self, class: &str) -> bool {
        self.carried(class).is_some_and(|carried| carried.replaces)
    }

    pub(super) fn settings(&self, class: &str) -> &[(&'static str, String)] {
        self.settings.get(class).map_or(&[], Vec::as_slice)
    }

    pub(super) fn warnings(&self, known: &[String]) -> Vec<FileProblem> {
        let mut unknown = Problems::default();
        for Carried { class, place, .. } in self.classes.values() {
            if !known.iter().any(|known| known.eq_ignore_ascii_case(class)) {
                let meant = did_you_mean(class, known.iter().map(String::as_str));
                self.problem(&mut unknown, *place, format_args!("no class `{class}`{meant}: its items are left out"));
            }
        }
        self.warnings.iter().cloned().chain(unknown.into_list()).collect()
    }
}

const SCAN_INTERVAL: &str = "scan_interval";
/// Settings of a battery that are the robot's.
const OF_BATTERIES: [&str; 2] = [classes::MAX_ENERGY, classes::LIFE];

/// Reads the settings of a class of sensors.
fn config(class: &str, settings: &[(&'static str, String)]) -> Result<Config, String> {
    let mut table = toml::Table::new();
    for (key, value) in settings.iter().filter(|(key, _)| *key != SCAN_INTERVAL && !OF_BATTERIES.contains(key)) {
        table.insert((*key).to_owned(), value.parse().map_err(|_| format!("`{key}` is {value}: expected a number"))?);
    }
    let config = Config::read(class, table).ok_or_else(|| format!("unknown class of sensors `{class}`"))?;
    config.map_err(|error| error.message().to_owned())
}

/// Checks the settings of a class of sensors.
fn check_settings(class: &str, settings: &[(&'static str, String)]) -> Result<(), String> {
    config(class, settings)?.validate().map_err(|expected| format!("expected {expected}"))
}

/// The contents of the lines read so far.
#[derive(Default)]
struct Reader {
    file: usize,
    classes: BTreeMap<String, Carried>,
    values: BTreeMap<(&'static str, String), String>,
    /// Positions of the sections of sensors.
    places: BTreeMap<&'static str, Place>,
    notes: Vec<(Place, String)>,
}

impl Reader {
    fn note(&mut self, at: usize, message: impl Into<String>) {
        if self.notes.len() < MAX_NOTES {
            self.notes.push((Place { file: self.file, at }, message.into()));
        }
    }

    fn read_file(&mut self, file: usize, text: &str) {
        self.file = file;
        let (sections, mistakes) = ini::sections(text);
        mistakes.iter().for_each(|mistake| self.note(mistake.at, mistake.to_string()));
        // Classes whose lists of earlier files this file has replaced.
        let mut begun = Vec::new();
        for section in &sections {
            let Some((package, class)) = section.name.split_once('.') else { continue };
            let begins = package.get(..4).is_some_and(|begin| begin.eq_ignore_ascii_case("USAR"));
            if !begins || OTHER_PACKAGES.iter().any(|other| other.eq_ignore_ascii_case(package)) {
                continue;
            }
            let has_items = section.entries.iter().any(|entry| is_among(&ITEM_KEYS, entry.key));
            match classes::row(class) {
                Some(row) if !has_items => self.read_sensor(row, section),
                None if !has_items && package.eq_ignore_ascii_case("USARSensor") => {
                    if let Some(entry) = section.entries.first() {
                        let meant = did_you_mean(class, classes::names());
                        self.note(entry.at, format!("no class of sensors `{class}`{meant}: its settings are left out"));
                    }
                }
                _ => self.read_carrier(class, section, &mut begun),
            }
        }
    }

    fn read_sensor(&mut self, row: &'static Row, section: &ini::Section) {
        for entry in &section.entries {
            self.places.entry(row.name()).or_insert(Place { file: self.file, at: entry.at });
            let known = row.all_keys().find(|(key, _)| key.eq_ignore_ascii_case(entry.key));
            let Some((key, here)) = known else {
                if !row.ignores(entry.key) {
                    let (name, meant) = (row.name(), did_you_mean(entry.key, row.all_keys().map(|(key, _)| key)));
                    self.note(entry.at, format!("`{}` of {name} has no effect{meant}", entry.key));
                }
                continue;
            };
            if key == classes::ORIGIN {
                self.read_origin(row, entry);
            }
            if here.is_empty() {
                continue;
            }
            match toml_value(row, here, entry.value) {
                Some(value) => {
                    self.values.insert((row.name(), key.to_lowercase()), value);
                }
                None => {
                    self.note(entry.value_at, format!("`{key}` is `{}`: it is left out", short(entry.value)));
                }
            }
        }
    }

    /// Reads the geographic place of a map's origin. Degrees and minutes may have different signs; those of the degrees count.
    fn read_origin(&mut self, row: &'static Row, entry: &ini::Entry) {
        let Ok(fields) = ini::fields(entry.value, entry.value_at) else {
            self.note(entry.value_at, "expected (LatitudeDegree=..,LatitudeMinute=..,..): it is left out");
            return;
        };
        let number = |wanted: &str| {
            let field = fields.iter().find(|field| field.name.eq_ignore_ascii_case(wanted))?;
            if let Value::Word(word) = field.value { ini::number(word) } else { None }
        };
        for key in [classes::LATITUDE, classes::LONGITUDE] {
            let [degrees, minutes] = ["Degree", "Minute"].map(|unit| number(&format!("{key}{unit}")).unwrap_or(0.0));
            let angle = degrees + if degrees < 0.0 { -minutes.abs() } else { minutes } / 60.0;
            self.values.insert((row.name(), key.to_lowercase()), format!("{angle:?}"));
        }
    }

    fn read_carrier(&mut self, class: &str, section: &ini::Section, begun: &mut Vec<String>) {
        let is_carrier = section.entries.iter().any(|it| is_among(&ITEM_KEYS, it.key) || is_life(it.key));
        if !is_carrier {
            return;
        }
        for entry in &section.entries {
            let place = Place { file: self.file, at: entry.at };
            if is_life(entry.key) {
                match ini::number(entry.value) {
                    Some(life) => self.carrier(class, place).battery_life = Some(life),
                    None => self.note(entry.value_at, "expected seconds: it is left out"),
                }
                continue;
            }
            if entry.key.eq_ignore_ascii_case("bMountByUU") && ini::boolean(entry.value) == Some(true) {
                self.note(entry.at, "its items are read in metres and radians all the same");
            }
            if !is_among(&ITEM_KEYS, entry.key) {
                if !is_among(&WITHOUT_EFFECT, entry.key) {
                    self.note(entry.at, format!("`{}` of {class} has no effect", short(entry.key)));
                }
                continue;
            }
            let name = class.to_lowercase();
            let is_first = !begun.contains(&name);
            let carrier = self.carrier(class, place);
            // A list without prefixes replaces that of an earlier file; the class's own items, too.
            if entry.prefix == Some('!') || (entry.prefix.is_none() && is_first) {
                carrier.items.clear();
                carrier.replaces = true;
                begun.push(name);
            }
            if entry.prefix == Some('!') {
                continue;
            }
            let Some(item) = self.read_item(entry) else { continue };
            let carrier = self.carrier(class, place);
            if entry.prefix == Some('-') {
                let before = carrier.items.len();
                carrier.items.retain(|other| !other.is_same(&item));
                if carrier.items.len() == before {
                    self.note(entry.at, "no earlier line has this item: nothing is removed");
                }
            } else if carrier.items.len() >= MAX_ITEMS {
                self.note(entry.at, format!("the class has {MAX_ITEMS} items, the most: this one is left out"));
            } else if entry.prefix != Some('+') || !carrier.items.iter().any(|other| other.is_same(&item)) {
                carrier.items.push(item);
            }
        }
    }

    fn carrier(&mut self, class: &str, place: Place) -> &mut Carried {
        let new = || Carried { class: class.to_owned(), place, items: Vec::new(), replaces: false, battery_life: None };
        self.classes.entry(class.to_lowercase()).or_insert_with(new)
    }

    /// Reads an item. `None` for one that is not mounted, which is noted unless its carrier has it anyway.
    fn read_item(&mut self, entry: &ini::Entry) -> Option<Item> {
        let fields = match ini::fields(entry.value, entry.value_at) {
            Ok(fields) => fields,
            Err(mistake) => {
                self.note(mistake.at, format!("{mistake}: the item is left out"));
                return None;
            }
        };
        let place = Place { file: self.file, at: entry.at };
        let mut item = Item {
            place,
            kind: Kind::Mount(String::new()),
            name: String::new(),
            parent: String::new(),
            position: [0.0; 3],
            direction: [0.0; 3],
        };
        let (mut class, mut is_attached) = ("", true);
        for Field { at, name, value } in &fields {
            let is = |known: &[&str]| is_among(known, name);
            match value {
                Value::Word(word) if is(&["ItemClass", "PkgClass"]) => class = class_name(word),
                Value::Word(word) if is(&["ItemName", "PkgName"]) => item.name = wire_name(word),
                Value::Word(word) if is(&["Parent"]) => item.parent = (*word).to_owned(),
                Value::Word(word) if is(&["startAttached"]) => is_attached = ini::boolean(word).unwrap_or(true),
                Value::Fields(fields) if is(&["Position", "Location"]) => item.position = self.vector(fields),
                Value::Fields(fields) if is(&["Direction"]) => item.direction = self.vector(fields),
                _ if is(&["Mesh", "ParentLink", "Link"]) => {}
                _ => self.note(*at, format!("`{}` of an item has no effect", short(name))),
            }
        }
        let shown = if item.name.is_empty() { class } else { &item.name };
        if is_among(&classes::BUILT_IN, class) {
            return None;
        }
        if !is_attached {
            self.note(entry.at, format!("`{}` is not attached at first: it is left out", short(shown)));
            return None;
        }
        item.kind = match classes::row(class) {
            Some(Row { here: None, .. }) => {
                self.note(entry.at, format!("`{}` cannot be mounted: it is left out", short(class)));
                return None;
            }
            Some(row) => Kind::Sensor(row),
            None => Kind::Mount(self.actuator(class, entry.at)?),
        };
        if item.name.is_empty() {
            item.name = wire_name(class);
        }
        Some(item)
    }

    /// Returns the actuator of a class, in any case.
    fn actuator(&mut self, class: &str, at: usize) -> Option<String> {
        let known = shipped::actuator_names();
        let same = |known: &str| known.eq_ignore_ascii_case(class);
        let other = classes::ACTUATORS.iter().find(|(name, _)| same(name)).map(|(_, here)| (*here).to_owned());
        let found = known.iter().find(|name| same(name)).cloned().or(other);
        if found.is_none() {
            let all: Vec<String> = known.into_iter().chain(classes::names().map(str::to_owned)).collect();
            let meant = did_you_mean(class, all.iter().map(String::as_str));
            self.note(at, format!("no sensor or actuator `{}`{meant}: it is left out", short(class)));
        }
        found
    }

    /// Reads X, Y and Z. What is missing or no number is 0, as in USARSim.
    fn vector(&mut self, fields: &[Field]) -> [f64; 3] {
        let mut vector = [0.0; 3];
        for Field { at, name, value } in fields {
            let axis = ["X", "Y", "Z"].iter().position(|axis| axis.eq_ignore_ascii_case(name));
            let number = match value {
                Value::Word(word) => ini::number(word),
                Value::Fields(_) => None,
            };
            match (axis, number) {
                (Some(axis), Some(number)) => vector[axis] = number,
                (Some(_), None) => self.note(*at, format!("`{name}` is no number: it is 0")),
                (None, _) => self.note(*at, format!("`{}` is none of X, Y and Z", short(name))),
            }
        }
        vector
    }
}

impl Item {
    /// True if another item has the same class and name.
    fn is_same(&self, other: &Self) -> bool {
        let same_kind = match (&self.kind, &other.kind) {
            (Kind::Sensor(one), Kind::Sensor(other)) => one.name() == other.name(),
            (Kind::Mount(one), Kind::Mount(other)) => one == other,
            _ => false,
        };
        same_kind && self.name == other.name
    }
}

/// Returns a value of an ini in TOML: a number or a truth value, whichever the setting takes.
fn toml_value(row: &'static Row, key: &'static str, value: &str) -> Option<String> {
    let number = ini::number(value).map(|number| {
        // Counts are integers in TOML.
        if number.fract() == 0.0 && number.abs() < 1e9 { format!("{number:.0}") } else { format!("{number:?}") }
    });
    let boolean = ini::boolean(value).map(|value| value.to_string());
    if key == SCAN_INTERVAL || OF_BATTERIES.contains(&key) {
        return number;
    }
    // A class that cannot be mounted has keys of the classes that extend it.
    let extends = |other: &&'static Row| other.here.is_some() && other.chain().any(|it| it.name() == row.name());
    let class = row.here.or_else(|| classes::rows().find(extends)?.here)?;
    number.into_iter().chain(boolean).find(|value| config(class, &[(key, value.clone())]).is_ok())
}

/// Returns the class in `class'Package.Class'`, `"Package.Class"` or `Package.Class`.
fn class_name(word: &str) -> &str {
    let inner = word.split('\'').nth(1).unwrap_or(word);
    inner.rsplit('.').next().unwrap_or(inner).trim()
}

/// Returns a name as it can be sent on the wire.
fn wire_name(word: &str) -> String {
    word.chars().map(|c| if c.is_whitespace() || c.is_control() || "{}".contains(c) { '_' } else { c }).collect()
}

fn is_life(key: &str) -> bool {
    key.eq_ignore_ascii_case(classes::LIFE)
}

/// Shortens a name for a message.
fn short(name: &str) -> String {
    name.chars().take(60).collect()
}
