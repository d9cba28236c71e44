//! Maps that viewers may change to.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use gamebots_proto::shown;
use scene::MapDef;

/// Most maps that come while the server runs. A newer one replaces the oldest.
const MAX_ADDED: usize = 16;

/// A map that a viewer may change to. It is read when somebody does.
#[derive(Clone)]
pub struct AvailableMap {
    /// Its name.
    pub name: String,
    /// One sentence about it.
    pub description: String,
    /// Reads it. It fails with the reason in words.
    pub read: Arc<dyn Fn() -> Result<MapDef, String> + Send + Sync>,
    /// True if it came while the server runs.
    pub is_added: bool,
}

impl From<MapDef> for AvailableMap {
    fn from(map: MapDef) -> Self {
        let (name, description) = (map.name.clone(), map.description.clone());
        Self { name, description, read: Arc::new(move || Ok(map.clone())), is_added: false }
    }
}

impl std::fmt::Debug for AvailableMap {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.name)
    }
}

/// The maps that viewers may change to. Copies share them.
#[derive(Debug, Clone, Default)]
pub struct Maps(Arc<Mutex<Vec<AvailableMap>>>);

impl From<Vec<AvailableMap>> for Maps {
    fn from(maps: Vec<AvailableMap>) -> Self {
        Self(Arc::new(Mutex::new(maps)))
    }
}

impl Maps {
    fn lock(&self) -> MutexGuard<'_, Vec<AvailableMap>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Lists the maps with their descriptions.
    pub(crate) fn list(&self) -> Vec<(String, String)> {
        self.lock().iter().map(|map| (map.name.clone(), map.description.clone())).collect()
    }

    /// Finds a map by its name.
    ///
    /// # Errors
    /// When there is none of that name.
    pub(crate) fn find(&self, name: &str) -> Result<AvailableMap, String> {
        let found = self.lock().iter().find(|map| map.name == name).cloned();
        found.ok_or_else(|| {
            let names: Vec<String> = self.list().into_iter().map(|(name, _)| name).collect();
            format!("no map `{}`: expected {}", shown(name).escape_debug(), names.join(", "))
        })
    }

    /// Reads a map by its name.
    ///
    /// # Errors
    /// When there is none of that name, or it cannot be read.
    pub(crate) fn read(&self, name: &str) -> Result<MapDef, String> {
        let map = self.find(name)?;
        (map.read)().map_err(|reason| format!("not changed to the map {name}: {reason}"))
    }

    /// Adds a map that came while the server runs. It gets a number if another one has its name. Returns its name.
    pub(crate) fn add(&self, mut map: MapDef) -> String {
        let mut maps = self.lock();
        let name = names::free(&map.name, |name| !maps.iter().any(|map| map.name.eq_ignore_ascii_case(name)));
        map.name.clone_from(&name);
        let added = maps.iter().filter(|map| map.is_added).count();
        if added >= MAX_ADDED
            && let Some(oldest) = maps.iter().position(|map| map.is_added)
        {
            maps.remove(oldest);
        }
        maps.push(AvailableMap { is_added: true, ..map.into() });
        name
    }
}
