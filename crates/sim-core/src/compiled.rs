//! A scene prepared for worlds.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use scene::{Setting, WorldDef};

use crate::physics::{CompiledMap, CompiledRobot, Materials};

/// A scene with the data that its worlds share: shapes, masses, joints. The data is computed from a definition: that of the map at once, that
/// of a class when a world first asks for it. Copies share it.
#[derive(Clone)]
pub struct CompiledScene(Arc<Parts>);

struct Parts {
    def: WorldDef,
    map: CompiledMap,
    materials: Materials,
    robots: Arc<Robots>,
}

/// Compiled classes by name; none of those that cannot be read. Classes may be added while worlds run.
type Robots = Mutex<BTreeMap<String, Arc<OnceLock<Option<Arc<CompiledRobot>>>>>>;

impl AsRef<WorldDef> for CompiledScene {
    fn as_ref(&self) -> &WorldDef {
        self.def()
    }
}

impl From<WorldDef> for CompiledScene {
    fn from(def: WorldDef) -> Self {
        let mut materials = Materials::default();
        let map = CompiledMap::new(&def.map, &mut materials);
        Self(Arc::new(Parts { def, map, materials, robots: Arc::default() }))
    }
}

impl CompiledScene {
    /// Returns the scene on another map, with what is played there. Both share the classes that are compiled.
    #[must_use]
    pub fn on(&self, setting: impl Into<Setting>) -> Self {
        let setting = setting.into();
        let Parts { def, materials, robots, .. } = &*self.0;
        let (mut materials, robots) = (materials.clone(), robots.clone());
        let compiled = CompiledMap::new(&setting.map, &mut materials);
        Self(Arc::new(Parts { def: def.clone().on(setting), map: compiled, materials, robots }))
    }

    /// True if both are copies of one scene: of one map, with what is played there. A scene of equal files is another one.
    pub fn is_copy_of(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }

    /// Returns the definition that it was compiled from.
    pub fn def(&self) -> &WorldDef {
        &self.0.def
    }

    pub(crate) fn map(&self) -> &CompiledMap {
        &self.0.map
    }

    pub(crate) fn materials(&self) -> &Materials {
        &self.0.materials
    }

    /// Returns a robot class by its name. `None` if there is none of that name, or it cannot be read.
    pub(crate) fn class(&self, name: &str) -> Option<Arc<CompiledRobot>> {
        let Parts { def, materials, robots, .. } = &*self.0;
        if !def.robots.contains_key(name) {
            return None;
        }
        let compile = || {
            let robot = def.robots.get(name)?.clone();
            Some(Arc::new(CompiledRobot::new(robot, &mut materials.clone())))
        };
        let robot = robots.lock().unwrap_or_else(PoisonError::into_inner).entry(name.to_owned()).or_default().clone();
        robot.get_or_init(compile).clone()
    }
}
