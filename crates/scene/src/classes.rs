//! Robot classes by name. Each is read when somebody first asks for it.

use std::collections::BTreeMap;
use std::fmt;
use std::ops::Index;
use std::sync::{Arc, OnceLock};

use serde::ser::{Error, SerializeMap};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::RobotDef;

/// A reader of a class. It fails with the reason in words.
type Read = Arc<dyn Fn() -> Result<RobotDef, String> + Send + Sync>;

/// Robot classes by name. Copies share what is read.
///
/// ```
/// use scene::{Classes, Link, RobotDef, Steering};
///
/// let mut classes = Classes::default();
/// classes.insert_unread("Cart", || Ok(RobotDef::new("Cart", Steering::Skid, vec![Link::default()])));
/// assert_eq!(classes.read().count(), 0);
/// assert!(classes.get("Cart").is_some());
/// assert_eq!(classes.read().count(), 1);
/// ```
#[derive(Clone, Default)]
pub struct Classes(BTreeMap<String, Arc<Class>>);

#[derive(Clone)]
struct Class {
    read: Read,
    def: OnceLock<Result<RobotDef, String>>,
}

impl Class {
    fn get(&self) -> Result<&RobotDef, &str> {
        self.def.get_or_init(|| (self.read)()).as_ref().map_err(String::as_str)
    }

    fn of(def: RobotDef) -> Self {
        // Nobody calls the reader of a class that is there.
        Self { read: Arc::new(|| Err("it is read".to_owned())), def: Ok(def).into() }
    }
}

impl Classes {
    /// Adds a class.
    pub fn insert(&mut self, name: String, def: RobotDef) {
        self.0.insert(name, Arc::new(Class::of(def)));
    }

    /// Adds a class that is read when somebody first asks for it. The reader fails with the reason in words.
    pub fn insert_unread(
        &mut self,
        name: impl Into<String>,
        read: impl Fn() -> Result<RobotDef, String> + Send + Sync + 'static,
    ) {
        self.0.insert(name.into(), Arc::new(Class { read: Arc::new(read), def: OnceLock::new() }));
    }

    /// Returns a class, and reads it if nobody has. `None` if there is none of that name, or it cannot be read.
    pub fn get(&self, name: &str) -> Option<&RobotDef> {
        self.0.get(name)?.get().ok()
    }

    /// Returns a class to change it. Copies keep theirs.
    pub fn get_mut(&mut self, name: &str) -> Option<&mut RobotDef> {
        let class = self.0.get_mut(name)?;
        class.get().ok()?;
        Arc::make_mut(class).def.get_mut()?.as_mut().ok()
    }

    /// Returns the reason why a class cannot be read; `None` if it can, or if there is none of that name.
    pub fn problem(&self, name: &str) -> Option<&str> {
        self.0.get(name)?.get().err()
    }

    /// True if there is a class of that name. It is not read.
    pub fn contains_key(&self, name: &str) -> bool {
        self.0.contains_key(name)
    }

    /// Returns the name of a class that is given in any case. The class is not read.
    pub fn find(&self, name: &str) -> Option<&String> {
        self.0.keys().find(|known| known.eq_ignore_ascii_case(name))
    }

    /// Returns the number of classes.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// True if there is no class.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns the names of all classes, in order. None is read.
    pub fn keys(&self) -> impl Iterator<Item = &String> {
        self.0.keys()
    }

    /// Returns the classes that are read, in the order of their names.
    pub fn read(&self) -> impl Iterator<Item = (&String, &RobotDef)> {
        self.0.iter().filter_map(|(name, class)| Some((name, class.def.get()?.as_ref().ok()?)))
    }

    /// Returns all classes that can be read, in the order of their names, and reads them.
    pub fn iter(&self) -> impl Iterator<Item = (&String, &RobotDef)> {
        self.0.iter().filter_map(|(name, class)| Some((name, class.get().ok()?)))
    }

    /// Returns all classes as [`Classes::iter`] does, without their names.
    pub fn values(&self) -> impl Iterator<Item = &RobotDef> {
        self.iter().map(|(_, def)| def)
    }

    /// Returns all classes to change them, and reads them.
    pub fn values_mut(&mut self) -> impl Iterator<Item = &mut RobotDef> {
        self.0.values_mut().filter_map(|class| {
            class.get().ok()?;
            Arc::make_mut(class).def.get_mut()?.as_mut().ok()
        })
    }

    /// Changes all classes: those that are read now, the others when they are read.
    pub fn change(&mut self, change: impl Fn(&mut RobotDef) + Send + Sync + Clone + 'static) {
        for class in self.0.values_mut() {
            let Class { read, def } = Arc::make_mut(class);
            match def.get_mut() {
                Some(def) => def.iter_mut().for_each(&change),
                None => {
                    let (unchanged, change) = (read.clone(), change.clone());
                    *read = Arc::new(move || {
                        let mut def = unchanged()?;
                        change(&mut def);
                        Ok(def)
                    });
                }
            }
        }
    }

    /// Removes a class, and returns it if it can be read.
    pub fn remove(&mut self, name: &str) -> Option<RobotDef> {
        let class = self.0.remove(name)?;
        class.get().ok().cloned()
    }

    /// Keeps the classes with these names.
    pub fn retain(&mut self, mut keep: impl FnMut(&str) -> bool) {
        self.0.retain(|name, _| keep(name));
    }
}

impl Index<&str> for Classes {
    type Output = RobotDef;

    fn index(&self, name: &str) -> &RobotDef {
        self.get(name).unwrap_or_else(|| panic!("no class {name}: {}", self.problem(name).unwrap_or("unknown")))
    }
}

impl FromIterator<(String, RobotDef)> for Classes {
    fn from_iter<I: IntoIterator<Item = (String, RobotDef)>>(classes: I) -> Self {
        Self(classes.into_iter().map(|(name, def)| (name, Arc::new(Class::of(def)))).collect())
    }
}

impl<const N: usize> From<[(String, RobotDef); N]> for Classes {
    fn from(classes: [(String, RobotDef); N]) -> Self {
        classes.into_iter().collect()
    }
}

impl PartialEq for Classes {
    fn eq(&self, other: &Self) -> bool {
        self.0.len() == other.0.len()
            && self
                .0
                .iter()
                .zip(&other.0)
                .all(|(one, other)| one.0 == other.0 && (Arc::ptr_eq(one.1, other.1) || one.1.get() == other.1.get()))
    }
}

impl fmt::Debug for Classes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_set().entries(self.keys()).finish()
    }
}

impl Serialize for Classes {
    /// Writes all classes, and reads them.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (name, class) in &self.0 {
            map.serialize_entry(name, class.get().map_err(S::Error::custom)?)?;
        }
        map.end()
    }
}

impl<'de> Deserialize<'de> for Classes {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(BTreeMap::<String, RobotDef>::deserialize(deserializer)?.into_iter().collect())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;
    use crate::{DriveModel, Link, Steering};

    fn cart(name: &str) -> RobotDef {
        RobotDef::new(name, Steering::Skid, vec![Link::default()])
    }

    #[test]
    fn a_class_is_read_once_by_all_copies_and_never_by_its_name() {
        let count = Arc::new(AtomicUsize::new(0));
        let mut classes = Classes::default();
        let counted = count.clone();
        classes.insert_unread("Cart", move || {
            counted.fetch_add(1, Ordering::Relaxed);
            Ok(cart("Cart"))
        });
        let copy = classes.clone();
        assert!(copy.contains_key("Cart") && copy.keys().count() == 1 && copy.read().count() == 0);
        assert_eq!(count.load(Ordering::Relaxed), 0);
        assert_eq!(
            [&classes, &copy].map(|classes| classes.get("Cart").cloned()),
            [Some(cart("Cart")), Some(cart("Cart"))]
        );
        assert_eq!(count.load(Ordering::Relaxed), 1);
    }

    #[test]
    fn a_change_reaches_classes_that_are_read_later_and_no_copy() {
        let mut classes = Classes::from([("Read".to_owned(), cart("Read"))]);
        classes.insert_unread("Unread", || Ok(cart("Unread")));
        let copy = classes.clone();
        classes.change(|def| def.drive_model = DriveModel::Analytic);
        for name in ["Read", "Unread"] {
            assert_eq!(classes[name].drive_model, DriveModel::Analytic, "{name}");
            assert_eq!(copy[name], cart(name), "{name}");
        }
    }

    #[test]
    fn a_class_that_cannot_be_read_says_why() {
        let mut classes = Classes::default();
        classes.insert_unread("Broken", || Err("no wheels".to_owned()));
        assert_eq!((classes.get("Broken"), classes.problem("Broken")), (None, Some("no wheels")));
        assert_eq!((classes.get("None"), classes.problem("None")), (None, None));
        assert!(serde_json::to_string(&classes).is_err_and(|error| error.to_string() == "no wheels"));
    }
}
