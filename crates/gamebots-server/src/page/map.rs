//! Pictures of maps for those who choose one. Each is drawn once, when a page first asks for it.

use std::collections::BTreeMap;
use std::sync::Arc;

use axum::body::Bytes;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use picture::{Camera, Stage};
use scene::{MapDef, Options, Setting, WorldDef};
use sim_core::World;
use tokio::sync::Mutex;
use tokio::task::spawn_blocking;

use crate::maps::{AvailableMap, Maps};

/// Width and height of a picture, px.
const SIZE: [usize; 2] = [256, 160];
/// Most pictures that are kept.
const MAX_KEPT: usize = 64;

/// Pictures of maps for pages.
pub(crate) struct MapPictures {
    maps: Maps,
    /// Everything but a map.
    world: WorldDef,
    drawn: Arc<Mutex<BTreeMap<String, Drawn>>>,
}

struct Drawn {
    map: AvailableMap,
    /// The file, or the reason why there is none.
    png: Result<Bytes, String>,
}

impl MapPictures {
    pub(crate) fn new(maps: Maps, world: &WorldDef) -> Self {
        Self { maps, world: world.clone().on(Setting::default()), drawn: Arc::default() }
    }

    /// Answers with the picture of a map.
    pub(crate) async fn answer(&self, name: &str) -> Response {
        let map = match self.maps.find(name) {
            Ok(map) => map,
            Err(reason) => return (StatusCode::NOT_FOUND, format!("{reason}\n")).into_response(),
        };
        match self.picture(map).await {
            Ok(png) => ([(header::CONTENT_TYPE, "image/png")], png).into_response(),
            Err(reason) => (StatusCode::UNPROCESSABLE_ENTITY, format!("map {name}: {reason}\n")).into_response(),
        }
    }

    /// Returns a picture, and draws it on another thread if nobody has. That thread holds the lock: pages that ask for all maps at once use
    /// one core.
    async fn picture(&self, map: AvailableMap) -> Result<Bytes, String> {
        let mut drawn = self.drawn.clone().lock_owned().await;
        // A map that came while the server runs may have the name of one that is gone.
        if let Some(known) = drawn.get(&map.name).filter(|known| Arc::ptr_eq(&known.map.read, &map.read)) {
            return known.png.clone();
        }
        let world = self.world.clone();
        let make = move || {
            let png = (map.read)().and_then(|def| draw(world, def));
            while drawn.len() >= MAX_KEPT {
                drawn.pop_first();
            }
            drawn.insert(map.name.clone(), Drawn { map, png: png.clone() });
            png
        };
        spawn_blocking(make).await.unwrap_or_else(|_| Err("a defect: the map cannot be drawn".to_owned()))
    }
}

fn draw(world: WorldDef, map: MapDef) -> Result<Bytes, String> {
    let world = world.on(Setting { map, ..Setting::default() });
    world.check().map_err(|problem| problem.to_string())?;
    let world = World::new(world, Options::default());
    let (def, stage) = (world.def(), Stage::new(world.def()));
    let picture = picture::picture(&stage, def, &world.snapshot(), &Camera::of_map(&def.map, SIZE), SIZE);
    picture.to_png().map(Bytes::from).map_err(|error| error.to_string())
}
