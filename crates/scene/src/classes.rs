//! Robot classes by name. Each is read when somebody first asks for it.

use std::collections::BTreeMap;
use std::fmt;
use std::ops::Index;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use serde::ser::{Error, SerializeMap};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::RobotDef;

/// A reader of a class. It fails with the reason in words.
type Read = Arc<dyn Fn() -> Result<RobotDef, String> + Send + Sync>;

/// Most classes that can be added while worlds run.
const MAX_ADDED: usize = 64;

/// Robot classes by name. Copies share what is read, and the classes that are added later.
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
pub struct Classes {
    first: BTreeMap<String, Arc<Class>>,
    added: Arc<Added>,
}

/// Classes that came while worlds run. None changes or goes, so readers need no lock.
struct Added {
    slots: [OnceLock<(String, Class)>; MAX_ADDED],
    /// Held while a class is added.
    adding: Mutex<()>,
}

impl Default for Added {
    fn default() -> Self {
        Self { slots: [const { OnceLock::new() }; MAX_ADDED], adding: Mutex::default() }
    }
}

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
        self.first.insert(name, Arc::new(Class::of(def)));
    }

    /// Adds a class that is read when somebody first asks for it. The reader fails with the reason in words.
    pub fn insert_unread(
        &mut self,
        name: impl Into<String>,
        read: impl Fn() -> Result<RobotDef, String> + Send + Sync + 'static,
    ) {
        self.first.insert(name.into(), Arc::new(Class { read: Arc::new(read), def: OnceLock::new() }));
    }

    /// Adds a class for all copies, also those of worlds that run. It gets a number if another one has its name; one that is the same as one
    /// that was added is not added again. Returns its name.
    ///
    /// # Errors
    /// If 64 classes were added, in words.
    pub fn add(&self, mut def: RobotDef) -> Result<&str, String> {
        let _guard = self.added.adding.lock().unwrap_or_else(PoisonError::into_inner);
        let wanted = def.class.clone();
        for (name, class) in self.added().filter(|(name, _)| name.starts_with(&wanted)) {
            // Only its number may differ.
            def.class.clone_from(name);
            if class.get() == Ok(&def) {
                return Ok(name);
            }
        }
        let slot = self
            .added
            .slots
            .iter()
            .find(|slot| slot.get().is_none())
            .ok_or_else(|| format!("{MAX_ADDED} classes were added since the start: expected no more"))?;
        def.class = names::free(&wanted, |name| self.find(name).is_none());
        let (name, _) = slot.get_or_init(|| (def.class.clone(), Class::of(def)));
        Ok(name)
    }

    /// Returns the classes that were added.
    fn added(&self) -> impl Iterator<Item = (&String, &Class)> {
        self.added.slots.iter().map_while(OnceLock::get).map(|(name, class)| (name, class))
    }

    /// Returns all classes, those that were added last.
    fn all(&self) -> impl Iterator<Item = (&String, &Class)> {
        self.first.iter().map(|(name, class)| (name, &**class)).chain(self.added())
    }

    fn class(&self, name: &str) -> Option<&Class> {
        let added = || self.added().find(|(known, _)| *known == name).map(|(_, class)| class);
        self.first.get(name).map(|class| &**class).or_else(added)
    }

    /// Returns a class, and reads it if nobody has. `None` if there is none of that name, or it cannot be read.
    pub fn get(&self, name: &str) -> Option<&RobotDef> {
        self.class(name)?.get().ok()
    }

    /// Returns a class to change it. Copies keep theirs.
    pub fn get_mut(&mut self, name: &str) -> Option<&mut RobotDef> {
        let class = self.first.get_mut(name)?;
        class.get().ok()?;
        Arc::make_mut(class).def.get_mut()?.as_mut().ok()
    }

    /// Returns the reason why a class cannot be read; `None` if it can, or if there is none of that name.
    pub fn problem(&self, name: &str) -> Option<&str> {
        self.class(name)?.get().err()
    }

    /// True if there is a class of that name. It is not read.
    pub fn contains_key(&self, name: &str) -> bool {
        self.class(name).is_some()
    }

    /// Returns the name of a class that is given in any case. The class is not read.
    pub fn find(&self, name: &str) -> Option<&String> {
        self.keys().find(|known| known.eq_ignore_ascii_case(name))
    }

    /// Returns the number of classes.
    pub fn len(&self) -> usize {
        self.all().count()
    }

    /// True if there is no class.
    pub fn is_empty(&self) -> bool {
        self.all().next().is_none()
    }

    /// Returns the names of all classes, in order, and then of those that were added. None is read.
    pub fn keys(&self) -> impl Iterator<Item = &String> {
        self.all().map(|(name, _)| name)
    }

    /// Returns the classes that are read, in the order of [`Classes::keys`].
    pub fn read(&self) -> impl Iterator<Item = (&String, &RobotDef)> {
        self.all().filter_map(|(name, class)| Some((name, class.def.get()?.as_ref().ok()?)))
    }

    /// Returns all classes that can be read, in the order of [`Classes::keys`], and reads them.
    pub fn iter(&self) -> impl Iterator<Item = (&String, &RobotDef)> {
        self.all().filter_map(|(name, class)| Some((name, class.get().ok()?)))
    }

    /// Returns all classes as [`Classes::iter`] does, without their names.
    pub fn values(&self) -> impl Iterator<Item = &RobotDef> {
        self.iter().map(|(_, def)| def)
    }

    /// Returns the first classes to change them, and reads them: those that were added stay as they are.
    pub fn values_mut(&mut self) -> impl Iterator<Item = &mut RobotDef> {
        self.first.values_mut().filter_map(|class| {
            class.get().ok()?;
            Arc::make_mut(class).def.get_mut()?.as_mut().ok()
        })
    }

    /// Changes the first classes: those that are read now, the others when they are read.
    pub fn change(&mut self, change: impl Fn(&mut RobotDef) + Send + Sync + Clone + 'static) {
        for class in self.first.values_mut() {
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
        let class = self.first.remove(name)?;
        class.get().ok().cloned()
    }

    /// Keeps the classes with these names.
    pub fn retain(&mut self, mut keep: impl FnMut(&str) -> bool) {
        self.first.retain(|name, _| keep(name));
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
        let first = classes.into_iter().map(|(name, def)| (name, Arc::new(Class::of(def)))).collect();
        Self { first, ..Self::default() }
    }
}

impl<const N: usize> From<[(String, RobotDef); N]> for Classes {
    fn from(classes: [(String, RobotDef); N]) -> Self {
        classes.into_iter().collect()
    }
}

impl PartialEq for Classes {
    fn eq(&self, other: &Self) -> bool {
        let is_one = |one: &Class, other: &Class| std::ptr::eq(one, other) || one.get() == other.get();
        self.len() == other.len()
            && self.all().zip(other.all()).all(|(one, other)| one.0 == other.0 && is_one(one.1, other.1))
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
        let mut map = serializer.serialize_map(Some(self.len()))?;
        for (name, class) in self.all() {
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
    fn an_added_class_is_known_to_all_copies_under_a_name_of_its_own() {
        let classes = Classes::from([("Cart".to_owned(), cart("Cart"))]);
        let copy = classes.clone();
        assert_eq!(copy.add(cart("New")), Ok("New"));
        assert_eq!(classes.add(cart("cart")), Ok("cart_2"));
        assert_eq!(copy.add(cart("Cart")), Ok("Cart_3"));
        assert_eq!(copy.keys().collect::<Vec<_>>(), ["Cart", "New", "cart_2", "Cart_3"]);
        assert_eq!((classes.add(cart("New")), classes.add(cart("Cart"))), (Ok("New"), Ok("Cart_3")));
        assert_eq!(
            (classes["cart_2"].class.as_str(), classes.find("NEW").map(String::as_str)),
            ("cart_2", Some("New"))
        );
        assert_eq!((classes.len(), classes == copy), (4, true));
        let written = serde_json::to_string(&classes).unwrap();
        assert_eq!(serde_json::from_str::<Classes>(&written).unwrap().len(), 4);
        let other = |number| RobotDef { description: format!("{number}"), ..cart("Cart") };
        let rest = (3..MAX_ADDED).map(|number| classes.add(other(number)).map(drop));
        assert!(rest.collect::<Result<Vec<_>, _>>().is_ok());
        assert_eq!(copy.add(cart("Other")), Err("64 classes were added since the start: expected no more".to_owned()));
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
