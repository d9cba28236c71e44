//! Tiles of the picture that the image server sends: two by two, one for each of the first four cameras (Multiview.uc,
//! DefaultUSAR.ini:429-433).
//!
//! A camera takes the first free tile when it comes, and its CONF says which. A fifth one has none.

use scene::PawnId;
use scene::sensor::Config;
use serde::{Deserialize, Serialize};

use super::World;

/// Number of tiles.
pub const TILES: usize = 4;

/// The cameras that have the tiles: robots and the numbers of their sensors.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct Tiles([Option<(PawnId, usize)>; TILES]);

impl Tiles {
    /// Returns the tile of a camera.
    fn of(&self, robot: PawnId, sensor: usize) -> Option<usize> {
        self.0.iter().position(|camera| *camera == Some((robot, sensor)))
    }

    /// Gives a camera a tile, if one is free.
    fn give(&mut self, robot: PawnId, sensor: usize) {
        if let Some(tile) = self.0.iter_mut().find(|tile| tile.is_none()) {
            *tile = Some((robot, sensor));
        }
    }

    /// Frees the tiles of a robot.
    pub(super) fn free(&mut self, robot: PawnId) {
        for tile in &mut self.0 {
            *tile = tile.filter(|(owner, _)| *owner != robot);
        }
    }
}

impl World {
    /// Returns the tile of a robot's camera, 0 to 3 by rows, by the number of the sensor.
    pub fn tile(&self, robot: PawnId, sensor: usize) -> Option<usize> {
        self.tiles.of(robot, sensor)
    }

    /// Gives the cameras of a new robot tiles.
    pub(super) fn give_tiles(&mut self, id: PawnId) {
        let Some(robot) = self.robots.get(&id) else { return };
        let sensors = robot.def().sensors.iter().enumerate();
        let cameras: Vec<usize> =
            sensors.filter(|(_, it)| matches!(it.config, Config::Camera(_))).map(|(number, _)| number).collect();
        cameras.into_iter().for_each(|sensor| self.tiles.give(id, sensor));
        self.tell_tiles(id);
    }

    /// Tells the cameras of a robot their tiles.
    pub(super) fn tell_tiles(&mut self, id: PawnId) {
        let tiles = self.tiles;
        if let Some(robot) = self.robots.get_mut(&id) {
            robot.set_tiles(|sensor| tiles.of(id, sensor));
        }
    }
}
