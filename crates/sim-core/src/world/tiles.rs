//! Tiles of the picture that the image server sends: two by two, one for each of the first four cameras (Multiview.uc,
//! DefaultUSAR.ini:429-433).
//!
//! A camera takes the first free tile when it comes, and its CONF says which. A fifth one has none. A robot can exchange its own cameras by
//! `SET {Type Viewports}`.

use gamebots_proto::command::Set;
use gamebots_proto::message::{Message, ViewportsRes};
use scene::PawnId;
use scene::sensor::Config;
use serde::{Deserialize, Serialize};

use super::{Executed, World};

/// Number of tiles.
pub const TILES: usize = 4;

/// The cameras that have the tiles: robots and the numbers of their sensors.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Tiles([Option<(PawnId, usize)>; TILES]);

impl Tiles {
    /// Returns the camera of each tile: its robot and the number of the sensor.
    pub fn cameras(&self) -> [Option<(PawnId, usize)>; TILES] {
        self.0
    }

    /// Returns the tile of a camera.
    fn of(&self, robot: PawnId, sensor: usize) -> Option<usize> {
        self.0.iter().position(|camera| *camera == Some((robot, sensor)))
    }

    /// Gives a camera a tile, if one is free. Returns false if none is.
    fn give(&mut self, robot: PawnId, sensor: usize) -> bool {
        let free = self.0.iter_mut().find(|tile| tile.is_none());
        free.map(|tile| *tile = Some((robot, sensor))).is_some()
    }

    /// Frees the tiles of a robot.
    pub(super) fn free(&mut self, robot: PawnId) {
        for tile in &mut self.0 {
            *tile = tile.filter(|(owner, _)| *owner != robot);
        }
    }

    /// True if nobody else has a tile.
    fn is_free_for(&self, tile: usize, robot: PawnId) -> bool {
        self.0.get(tile).is_some_and(|camera| camera.is_none_or(|(owner, _)| owner == robot))
    }
}

impl World {
    /// Returns the cameras that have tiles.
    pub fn tiles(&self) -> Tiles {
        self.tiles
    }

    /// Returns the tile that fills the whole picture: that of a robot that asked for a single view, while no other camera has one.
    pub fn single_tile(&self) -> Option<usize> {
        let mut shown = self.tiles.0.iter().enumerate().filter_map(|(tile, camera)| Some((tile, (*camera)?)));
        let ((tile, (robot, _)), None) = (shown.next()?, shown.next()) else { return None };
        (self.single_view == Some(robot)).then_some(tile)
    }

    /// Gives the cameras of a new robot tiles.
    pub(super) fn give_tiles(&mut self, id: PawnId) {
        for sensor in self.cameras_of(id, "") {
            self.tiles.give(id, sensor);
        }
        self.tell_tiles(id);
    }

    /// Returns the numbers of a robot's cameras with a name, in any case; of all with an empty one.
    fn cameras_of(&self, id: PawnId, name: &str) -> Vec<usize> {
        let sensors = self.robots.get(&id).into_iter().flat_map(|robot| robot.def().sensors.iter().enumerate());
        let is_meant = |name_of: &str| name.is_empty() || name_of.eq_ignore_ascii_case(name);
        let cameras = sensors.filter(|(_, it)| matches!(it.config, Config::Camera(_)) && is_meant(&it.name));
        cameras.map(|(number, _)| number).collect()
    }

    /// Follows a SET that chooses the cameras of tiles. `None` for another SET.
    pub(super) fn set_tiles(&mut self, id: PawnId, set: &Set) -> Option<Executed> {
        if set.type_name.eq_ignore_ascii_case("Viewports") {
            return Some(self.set_viewports(id, set));
        }
        let is_of_client = set.type_name.eq_ignore_ascii_case("Camera") && !set.other("Client").is_empty();
        is_of_client.then(|| {
            // All clients of the image server see all tiles, so that a camera needs no more than one.
            let robot = match set.other("Robot") {
                "" => Some(id),
                name => self.robots().find(|(.., known)| known.eq_ignore_ascii_case(name)).map(|(robot, ..)| robot),
            };
            let camera = robot.and_then(|robot| Some((robot, *self.cameras_of(robot, &set.name).first()?)));
            let found = camera.is_some_and(|(robot, sensor)| {
                let has_tile = self.tiles.of(robot, sensor).is_some() || self.tiles.give(robot, sensor);
                self.tell_tiles(robot);
                has_tile
            });
            Executed { found, ..Executed::default() }
        })
    }

    /// Gives a robot's cameras the tiles that it names, all or none: `{Viewport1 c}` is the first. `None` and `Disabled` free a tile.
    fn set_viewports(&mut self, id: PawnId, set: &Set) -> Executed {
        let config = match set.other("Config") {
            "" => Some(self.single_view == Some(id)),
            // Some programs send numbers.
            single if single.eq_ignore_ascii_case("SingleView") || single == "0" => Some(true),
            four if four.eq_ignore_ascii_case("QuadView") || four == "1" => Some(false),
            _ => None,
        };
        let wanted: [&str; TILES] = std::array::from_fn(|tile| set.other(&format!("Viewport{}", tile + 1)));
        let tiles = config.and_then(|is_single| self.chosen(id, &wanted, is_single).map(|tiles| (tiles, is_single)));
        let found = tiles.is_some();
        if let Some((tiles, is_single)) = tiles {
            self.tiles = tiles;
            self.single_view = if is_single { Some(id) } else { self.single_view.filter(|robot| *robot != id) };
            self.tell_tiles(id);
        }
        let is_single = self.single_view == Some(id);
        let name = |(tile, camera): (usize, Option<(PawnId, usize)>)| match camera {
            Some((owner, sensor)) if owner == id => {
                let sensor = self.robots.get(&id).and_then(|robot| robot.def().sensors.get(sensor));
                sensor.map_or(String::new(), |sensor| sensor.name.clone())
            }
            None if !is_single || tile == 0 => "None".to_owned(),
            _ => "Disabled".to_owned(),
        };
        let cameras = std::array::from_fn(|tile| (name((tile, self.tiles.0[tile])), wanted[tile].is_empty() || found));
        let res = ViewportsRes { time: self.time() as f32, is_single, is_known: config.is_some(), cameras };
        Executed { answers: vec![Message::Viewports(res).into()], found, ..Executed::default() }
    }

    /// Returns the tiles with the cameras that a robot wants. `None` if it cannot have all of them.
    fn chosen(&self, id: PawnId, wanted: &[&str; TILES], is_single: bool) -> Option<Tiles> {
        let mut tiles = self.tiles;
        for (tile, name) in wanted.iter().enumerate().filter(|(_, name)| !name.is_empty()) {
            let is_free = |name: &str| ["None", "Disabled", "Disable"].iter().any(|it| it.eq_ignore_ascii_case(name));
            if is_free(name) {
                tiles.0[tile] = tiles.0[tile].filter(|(owner, _)| *owner != id);
                continue;
            }
            let sensor = *self.cameras_of(id, name).first().filter(|_| tiles.is_free_for(tile, id))?;
            if let Some(before) = tiles.of(id, sensor) {
                tiles.0[before] = None;
            }
            tiles.0[tile] = Some((id, sensor));
        }
        if is_single {
            // One view has room for one camera.
            for (tile, camera) in tiles.0.iter_mut().enumerate() {
                *camera = camera.filter(|(owner, _)| tile == 0 || *owner != id);
            }
        }
        Some(tiles)
    }

    /// Tells the cameras of a robot their tiles.
    pub(super) fn tell_tiles(&mut self, id: PawnId) {
        let tiles = self.tiles;
        if let Some(robot) = self.robots.get_mut(&id) {
            robot.set_tiles(|sensor| tiles.of(id, sensor));
        }
    }
}
