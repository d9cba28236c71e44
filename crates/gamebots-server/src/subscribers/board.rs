//! A board with the newest pictures of the first four cameras, for the port of images.

use std::sync::Arc;

use picture::Image;
use scene::PawnId;
use sim_core::TILES;
use tokio::sync::watch;

/// The newest picture of each tile, with the robot that it is of.
#[derive(Debug, Clone, Default)]
pub(crate) struct Tiles {
    /// Number of changes.
    pub(crate) changes: u64,
    /// Number of times that the world started over.
    pub(crate) worlds: u64,
    pub(crate) tiles: [Option<Tile>; TILES],
    /// The tile that fills the whole picture, if one does.
    pub(crate) single: Option<usize>,
}

/// A camera: a robot and the number of the sensor.
pub(crate) type Camera = (PawnId, usize);

/// A tile that a robot's camera has.
#[derive(Debug, Clone)]
pub(crate) struct Tile {
    pub(crate) camera: Camera,
    /// Its newest picture; none before the first.
    pub(crate) image: Option<Arc<Image>>,
}

/// A board that cameras' pictures are put on.
#[derive(Debug, Clone, Default)]
pub(crate) struct Board {
    tiles: watch::Sender<Tiles>,
}

impl Board {
    /// Returns the end that shows the newest pictures and tells of changes.
    pub(crate) fn subscribe(&self) -> watch::Receiver<Tiles> {
        self.tiles.subscribe()
    }

    /// True if a client looks.
    pub(crate) fn is_watched(&self) -> bool {
        self.tiles.receiver_count() > 0
    }

    /// Returns the number of times that the world started over.
    pub(crate) fn worlds(&self) -> u64 {
        self.tiles.borrow().worlds
    }

    /// Gives the tiles to cameras. `single` is the tile that fills the whole picture, if one does. Other cameras' pictures go.
    pub(crate) fn assign(&self, cameras: [Option<Camera>; TILES], single: Option<usize>) {
        self.change_if(|board| {
            let mut is_changed = std::mem::replace(&mut board.single, single) != single;
            for (tile, camera) in board.tiles.iter_mut().zip(cameras) {
                if tile.as_ref().map(|tile| tile.camera) != camera {
                    let before = std::mem::replace(tile, camera.map(|camera| Tile { camera, image: None }));
                    is_changed |= before.is_some_and(|tile| tile.image.is_some());
                }
            }
            is_changed
        });
    }

    /// Shows the picture of a camera in its tile, if it is of the present world and the camera still has one. Its robot may have left while
    /// the picture was drawn.
    pub(crate) fn show(&self, world: u64, camera: Camera, image: Image) {
        self.change_if(|board| {
            let owned = board.tiles.iter_mut().flatten().find(|tile| tile.camera == camera);
            let shown = owned.filter(|_| board.worlds == world).map(|tile| tile.image = Some(Arc::new(image)));
            shown.is_some()
        });
    }

    /// Blackens the tiles of a robot that has left.
    pub(crate) fn forget(&self, robot: PawnId) {
        self.change_if(|board| {
            let left = board.tiles.iter_mut().filter_map(|place| place.take_if(|tile| tile.camera.0 == robot));
            left.filter(|tile| tile.image.is_some()).count() > 0
        });
    }

    /// Blackens all tiles, as the world starts over.
    pub(crate) fn start_over(&self) {
        self.change_if(|board| {
            *board = Tiles { worlds: board.worlds + 1, changes: board.changes, ..Tiles::default() };
            true
        });
    }

    /// Changes the board. Notifies clients if `change` returns true.
    fn change_if(&self, change: impl FnOnce(&mut Tiles) -> bool) {
        self.tiles.send_if_modified(|board| {
            let is_changed = change(board);
            board.changes += u64::from(is_changed);
            is_changed
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_that_is_ready_after_its_robot_has_left_is_not_shown() {
        let [width, height] = picture::SENSOR_SIZE;
        let board = Board::default();
        let assign = |robot| board.assign([None, Some((PawnId(robot), 3)), None, None], None);
        let show = |robot| {
            board.show(0, (PawnId(robot), 3), Image { width, height, pixels: vec![[9; 3]; width * height] });
            let shown = board.tiles.borrow().tiles[1].clone().filter(|tile| tile.image.is_some());
            shown.map(|tile| tile.camera.0.0)
        };
        assign(5);
        assert_eq!(show(5), Some(5));
        board.forget(PawnId(5));
        assert_eq!(show(5), None);
        assign(6);
        assert_eq!(show(5), None);
        assert_eq!(show(6), Some(6));
    }
}
