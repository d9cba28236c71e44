//! A scene prepared for worlds.

use std::collections::BTreeMap;
use std::sync::Arc;

use scene::WorldDef;

use crate::physics::{CompiledMap, CompiledRobot, Materials};

/// A scene with the data that its worlds share: shapes, masses, joints. The data is computed once from a definition; copies share it.
#[derive(Clone)]
pub struct CompiledScene(Arc<Parts>);

struct Parts {
    def: WorldDef,
    materials: Arc<Materials>,
    map: CompiledMap,
    robots: BTreeMap<String, Arc<CompiledRobot>>,
}

impl From<WorldDef> for CompiledScene {
    fn from(def: WorldDef) -> Self {
        let mut materials = Materials::default();
        let map = CompiledMap::new(&def.map, &mut materials);
        let compiled = |(class, robot): (&String, &scene::RobotDef)| {
            (class.clone(), Arc::new(CompiledRobot::new(robot.clone(), &mut materials)))
        };
        let robots = def.robots.iter().map(compiled).collect();
        Self(Arc::new(Parts { def, map, robots, materials: Arc::new(materials) }))
    }
}

impl CompiledScene {
    /// Returns the definition that it was compiled from.
    pub fn def(&self) -> &WorldDef {
        &self.0.def
    }

    pub(crate) fn map(&self) -> &CompiledMap {
        &self.0.map
    }

    pub(crate) fn materials(&self) -> Arc<Materials> {
        self.0.materials.clone()
    }

    /// Returns the robot classes that clients can spawn, by name.
    pub(crate) fn robots(&self) -> &BTreeMap<String, Arc<CompiledRobot>> {
        &self.0.robots
    }
}
