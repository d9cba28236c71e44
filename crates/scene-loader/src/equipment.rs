//! Equipment: the items that robots carry instead of those of their files. It comes from a set (TOML), or from USARSim's ini files.

mod classes;
mod ini;
mod put_on;
mod usarsim;

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use names::did_you_mean;
use scene::Battery;

use crate::LoadError;
use crate::document::Document;
use crate::problem::{FileProblem, Problems};
use crate::shipped;
use crate::source::Source;
use usarsim::Inis;

/// Name of the equipment that robots have by their own files.
const SHIPPED: &str = "shipped";
/// Most items of one class.
pub(crate) const MAX_ITEMS: usize = 256;
/// Largest file of equipment, bytes: DefaultUSAR.ini has 20 kB.
const MAX_FILE: u64 = 1 << 20;

/// The items of some classes of robots and actuators, and settings of sensors.
#[derive(Debug, Default)]
pub struct Equipment(Kind);

#[derive(Debug, Default)]
enum Kind {
    #[default]
    Shipped,
    Set(Set),
    Inis(Inis),
}

/// A set: a file with the `[[sensor]]`, `[[mount]]` and `[battery]` tables of classes.
#[derive(Debug)]
struct Set {
    file: String,
    text: String,
    /// Classes as they are spelled and their positions, by their names in lower case.
    classes: BTreeMap<String, (String, Range<usize>)>,
}

/// Changes of a command line to the files of robots: numbers, and items.
#[derive(Debug, Clone, Copy)]
pub struct Changes<'a> {
    /// Replaced numbers.
    pub overrides: &'a [crate::Override],
    /// Items.
    pub equipment: &'a Equipment,
}

static NONE: Equipment = Equipment(Kind::Shipped);

impl<'a> Changes<'a> {
    /// Returns changes of numbers alone.
    pub(crate) fn of(overrides: &'a [crate::Override]) -> Self {
        Self { overrides, equipment: &NONE }
    }

    /// True if nothing is changed.
    pub(crate) fn is_none(&self) -> bool {
        self.overrides.is_empty() && matches!(self.equipment.0, Kind::Shipped)
    }
}

impl Equipment {
    /// Loads equipment by its name, `shipped` or that of an embedded set, or by the path of a set's file.
    ///
    /// # Errors
    /// Reports an unknown name, an unreadable file, or all problems of the file's structure.
    pub fn load(name: &str) -> Result<Self, LoadError> {
        if name.eq_ignore_ascii_case(SHIPPED) {
            return Ok(Self::default());
        }
        let path = Path::new(name);
        let (source, file) = match shipped::equipment_file(name) {
            Some((source, file)) => (source, file),
            None if path.is_file() => {
                let file = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
                (Source::of_file(path), file)
            }
            None => {
                let known = || shipped::equipment_names().into_iter().chain([SHIPPED.to_owned()]);
                let known: Vec<String> = known().collect();
                let suggestion = did_you_mean(name, known.iter().map(String::as_str));
                let (kind, got, expected) = ("equipment", name.to_owned(), known.join(", "));
                return Err(LoadError::UnknownName { kind, got, suggestion, expected });
            }
        };
        let text = source.text_up_to(&file, MAX_FILE)?;
        let mut problems = Problems::default();
        let set = Set::read(source.display(&file), text, &mut problems);
        problems.into_result(set.map_or_else(Self::default, |set| Self(Kind::Set(set))))
    }

    /// Reads ini files of USARSim for UDK or UT2004, the later ones after the earlier ones as Unreal does.
    ///
    /// # Errors
    /// Reports a file that cannot be read, and settings of sensors that are out of their ranges.
    pub fn of_inis(files: &[PathBuf]) -> Result<Self, LoadError> {
        let mut texts = Vec::new();
        for file in files {
            let name = file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
            let source = Source::of_file(file);
            let text = ini::decode(&source.bytes(&name, MAX_FILE)?).ok_or_else(|| LoadError::Unreadable {
                file: source.display(&name),
                reason: "expected text in UTF-8, UTF-16 or Latin 1".to_owned(),
            })?;
            texts.push((source.display(&name), text));
        }
        let mut problems = Problems::default();
        let inis = Inis::read(texts, &mut problems);
        problems.into_result(Self(Kind::Inis(inis)))
    }

    /// Lists the lines of ini files that have no effect, and sections of classes that are not among `robots` and the actuators.
    pub fn warnings<'a>(&self, robots: impl Iterator<Item = &'a str>) -> Vec<FileProblem> {
        let Kind::Inis(inis) = &self.0 else { return Vec::new() };
        inis.warnings(&known_classes(robots))
    }

    /// Checks that a set names only classes that are among `robots` and the actuators.
    ///
    /// # Errors
    /// Lists the others.
    pub(crate) fn check_classes<'a>(&self, robots: impl Iterator<Item = &'a str>) -> Result<(), LoadError> {
        let Kind::Set(set) = &self.0 else { return Ok(()) };
        let known = known_classes(robots);
        let mut problems = Problems::default();
        for (class, span) in set.classes.values() {
            if !known.iter().any(|known| known.eq_ignore_ascii_case(class)) {
                let meant = did_you_mean(class, known.iter().map(String::as_str));
                let message = format!("unknown class `{class}`: expected a class of robots or actuators{meant}");
                problems.at(&set.file, &set.text, span.start, message);
            }
        }
        problems.into_result(())
    }

    /// Returns the names of a set's classes as they are spelled.
    pub(crate) fn set_classes(&self) -> Vec<&str> {
        match &self.0 {
            Kind::Set(set) => set.classes.values().map(|(class, _)| class.as_str()).collect(),
            _ => Vec::new(),
        }
    }

    /// True if it says what a class carries.
    pub(crate) fn has(&self, class: &str) -> bool {
        match &self.0 {
            Kind::Shipped => false,
            Kind::Set(set) => set.classes.contains_key(&class.to_lowercase()),
            Kind::Inis(inis) => inis.has(class),
        }
    }

    /// True if its items of a class replace the class's own. Otherwise they are added.
    pub(crate) fn replaces(&self, class: &str) -> bool {
        match &self.0 {
            Kind::Inis(inis) => inis.replaces(class),
            _ => self.has(class),
        }
    }

    /// Returns the settings of a class of sensors that replace its defaults: keys of robot.toml, and values in TOML.
    pub(crate) fn settings(&self, class: &str) -> &[(&'static str, String)] {
        match &self.0 {
            Kind::Inis(inis) => inis.settings(class),
            _ => &[],
        }
    }
}

/// Returns the names of the classes that may have items: robots and actuators.
fn known_classes<'a>(robots: impl Iterator<Item = &'a str>) -> Vec<String> {
    robots.map(str::to_owned).chain(shipped::actuator_names()).collect()
}

impl Set {
    fn read(file: String, text: String, problems: &mut Problems) -> Option<Self> {
        let classes = Self::classes(&file, &text, problems)?;
        Some(Self { file, text, classes })
    }

    fn classes(file: &str, text: &str, problems: &mut Problems) -> Option<BTreeMap<String, (String, Range<usize>)>> {
        let (mut document, mut root) = Document::parse(file, text, problems)?;
        let _: Option<String> = document.required(&mut root, "description", "one sentence about the equipment");
        let mut classes: BTreeMap<String, (String, Range<usize>)> = BTreeMap::new();
        for (span, class) in root.keys() {
            if document.table(&mut root, &class).is_none() {
                continue;
            }
            if let Some((other, _)) = classes.insert(class.to_lowercase(), (class, span.clone())) {
                document.problem(&span, format_args!("second table of class `{other}`: expected one"));
            }
        }
        Some(classes)
    }
}

/// Returns a battery with the numbers of USARSim (DefaultUSAR.ini:190-193).
fn default_battery() -> Battery {
    Battery { max_energy: 1e6, life: 1200.0 }
}
