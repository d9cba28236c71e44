//! The port of images: what the first four cameras see, in one picture of two by two tiles (ImageServer.cpp, Multiview.uc).
//!
//! A client asks for each picture. It gets one that it has not had yet, or the same again after a while, so that a client that asks without
//! pause costs little. Cameras are drawn only while a client is connected.

use std::sync::Arc;
use std::time::Duration;

use axum::body::Bytes;
use gamebots_proto::ports::{PictureRequest, PictureRequests, picture, raw};
use jpeg_encoder::{ColorType, Encoder, SamplingFactor};
use picture::SENSOR_SIZE;
use tokio::sync::Mutex;
use tokio::task::spawn_blocking;
use tokio::time::timeout;

use crate::access::login::Accepted;
use crate::config::ImageKind;
use crate::door::lines::Conversation;
use crate::subscribers::board::{Board, Tiles};

/// Longest wait for a picture that the client has not had.
const WAIT: Duration = Duration::from_millis(100);
/// Longest wait for the first picture of all: cameras measure every 0.1 s of simulated time.
const FIRST_WAIT: Duration = Duration::from_millis(500);

impl ImageKind {
    /// Returns the quality of JPEG; `None` for raw pixels.
    fn quality(self) -> Option<u8> {
        match self {
            Self::Raw => None,
            Self::Super => Some(100),
            Self::Good => Some(75),
            Self::Normal => Some(50),
            Self::Fair => Some(25),
            Self::Bad => Some(10),
        }
    }
}

/// Pictures of a board, encoded for clients.
#[derive(Debug, Clone)]
pub(crate) struct Pictures {
    board: Board,
    kind: ImageKind,
    /// True to send the first picture unasked.
    is_legacy: bool,
    /// The last whole picture that was asked for, with the number of changes.
    whole: Arc<Mutex<Option<(u64, Bytes)>>>,
}

impl Pictures {
    pub(crate) fn new(board: Board, kind: ImageKind, is_legacy: bool) -> Self {
        Self { board, kind, is_legacy, whole: Arc::default() }
    }

    /// Returns the answer to a request. Pictures are encoded on another thread, and a whole one once for all clients.
    async fn answer(&self, request: PictureRequest, tiles: Tiles) -> Bytes {
        let kind = self.kind;
        let part = match request {
            PictureRequest::Part(part) => part,
            PictureRequest::Whole => {
                let mut known = self.whole.lock().await;
                if let Some((_, bytes)) = known.as_ref().filter(|(changes, _)| *changes == tiles.changes) {
                    return bytes.clone();
                }
                let [width, height] = SENSOR_SIZE.map(|size| 2 * size as u32);
                let changes = tiles.changes;
                let bytes = Bytes::from(encoded(kind, tiles, [0, 0, width, height]).await);
                *known = Some((changes, bytes.clone()));
                return bytes;
            }
        };
        encoded(kind, tiles, part).await.into()
    }
}

async fn encoded(kind: ImageKind, tiles: Tiles, part: [u32; 4]) -> Vec<u8> {
    // Encoding does not panic; without a thread there is no picture.
    spawn_blocking(move || encode(kind, &tiles, part)).await.unwrap_or_default()
}

/// Returns the answer with a part of the board: x, y, width and height, pixels. It is cut at the board's edges.
fn encode(kind: ImageKind, tiles: &Tiles, [x, y, width, height]: [u32; 4]) -> Vec<u8> {
    let [most_width, most_height] = SENSOR_SIZE.map(|size| 2 * size);
    let [left, top] = [(x as usize).min(most_width), (y as usize).min(most_height)];
    let [width, height] = [(width as usize).min(most_width - left), (height as usize).min(most_height - top)];
    let rows: Vec<Vec<[u8; 3]>> = (top..top + height).map(|row| pixels(tiles, row, left..left + width)).collect();
    let row = |number: usize| rows.get(number).map_or(&[][..], |row| row);
    let is_empty = width == 0 || height == 0;
    let Some(quality) = kind.quality() else {
        let [width, height] = if is_empty { [0; 2] } else { [width as u16, height as u16] };
        return picture(kind as u8, &raw(width, height, row));
    };
    let mut file = Vec::new();
    if !is_empty {
        let pixels = rows.concat();
        let mut encoder = Encoder::new(&mut file, quality);
        encoder.set_sampling_factor(SamplingFactor::F_2_2);
        // Sizes and bytes fit, and writing to memory does not fail.
        let _ = encoder.encode(pixels.as_flattened(), width as u16, height as u16, ColorType::Rgb);
    }
    picture(kind as u8, &file)
}

/// Returns the pixels of a row of the board, within some columns. Tiles without a picture are black. A single one is twice as large.
fn pixels(tiles: &Tiles, row: usize, columns: std::ops::Range<usize>) -> Vec<[u8; 3]> {
    let [width, height] = SENSOR_SIZE;
    let row_of = |tile: usize, row: usize| {
        let image = tiles.tiles.get(tile).and_then(Option::as_ref).and_then(|tile| tile.image.as_ref());
        image.and_then(|image| image.pixels.chunks(width).nth(row)).filter(|source| source.len() == width)
    };
    let mut pixels = vec![[0; 3]; 2 * width];
    if let Some(tile) = tiles.single {
        let source = row_of(tile, row / 2).unwrap_or_default();
        for (target, source) in pixels.chunks_mut(2).zip(source) {
            target.fill(*source);
        }
    } else {
        for (column, target) in pixels.chunks_mut(width).enumerate() {
            if let Some(source) = row_of(2 * (row / height) + column, row % height) {
                target.copy_from_slice(source);
            }
        }
    }
    pixels.get(columns).map(<[_]>::to_vec).unwrap_or_default()
}

/// Sends a client the pictures that it asks for, until it leaves, speaks HTTP or does not read.
pub(crate) async fn converse(pictures: Pictures, accepted: Accepted, stall_timeout: Duration) {
    let mut shown = pictures.board.subscribe();
    let (mut client, mut sent) = (Conversation::new(accepted.stream, PictureRequests::default(), stall_timeout), None);
    // As the server's LegacyMode: the client asks for the second picture when it has the first.
    let mut asked = Vec::from_iter(pictures.is_legacy.then_some(PictureRequest::Whole));
    loop {
        for request in asked {
            let (changes, is_empty) = {
                let tiles = shown.borrow_and_update();
                (tiles.changes, tiles.tiles.iter().flatten().all(|tile| tile.image.is_none()))
            };
            let is_known = sent == Some(changes);
            if is_known || sent.is_none() && is_empty {
                let wait = if is_known { WAIT } else { FIRST_WAIT };
                // Nothing new: the same is sent again.
                let _ = timeout(wait, shown.changed()).await;
            }
            let tiles = shown.borrow_and_update().clone();
            sent = Some(tiles.changes);
            let answer = pictures.answer(request, tiles).await;
            if !client.send(&answer).await {
                return;
            }
        }
        let Some(requests) = client.next().await else { return };
        asked = requests;
    }
}

#[cfg(test)]
mod tests {
    use picture::Image;
    use scene::PawnId;

    use super::*;

    /// Returns a board with a red picture in the second tile and a green one in the third.
    fn tiles() -> Tiles {
        let [width, height] = SENSOR_SIZE;
        let board = Board::default();
        let plain = |colour| Image { width, height, pixels: vec![colour; width * height] };
        let camera = |robot| (PawnId(robot), 0);
        board.assign([0, 1, 2, 3].map(|robot| Some(camera(robot)).filter(|_| robot < 3)), None);
        board.show(0, camera(1), plain([200, 0, 0]));
        board.show(0, camera(2), plain([0, 200, 0]));
        board.show(0, camera(3), plain([1, 1, 1]));
        board.show(1, camera(0), plain([1, 1, 1]));
        board.subscribe().borrow().clone()
    }

    fn check(part: [u32; 4], size: [u16; 2], first: [u8; 3]) {
        let bytes = encode(ImageKind::Raw, &tiles(), part);
        let [width, height] = size.map(usize::from);
        let pitch = (3 * width).next_multiple_of(4);
        assert_eq!(bytes[0], 0);
        assert_eq!(bytes[1..5], (4 + (height * pitch) as u32).to_be_bytes(), "{part:?}");
        assert_eq!(bytes[5..9], [size[0].to_be_bytes(), size[1].to_be_bytes()].concat(), "{part:?}");
        assert_eq!(bytes.len(), 9 + height * pitch, "{part:?}");
        assert_eq!(bytes.get(9..12).unwrap_or(&[0; 3]), first, "{part:?}");
    }

    #[test]
    fn a_single_tile_fills_the_picture() {
        let tiles = Tiles { single: Some(2), ..tiles() };
        let [width, height] = SENSOR_SIZE.map(|size| 2 * size);
        let green = vec![[0, 200, 0]; width];
        assert!((0..height).all(|row| pixels(&tiles, row, 0..width) == green));
    }

    #[test]
    fn a_part_is_cut_at_the_edges() {
        check([0, 0, 640, 480], [640, 480], [0, 0, 0]);
        check([320, 0, 320, 240], [320, 240], [0, 0, 200]);
        check([1, 240, 3, 2], [3, 2], [0, 200, 0]);
        check([630, 470, 320, 240], [10, 10], [0, 0, 0]);
        check([640, 0, 10, 10], [0, 0], [0, 0, 0]);
        check([0, 0, 0, 10], [0, 0], [0, 0, 0]);
        check([u32::MAX; 4], [0, 0], [0, 0, 0]);
        check([319, 0, u32::MAX, 1], [321, 1], [0, 0, 0]);
    }

    #[test]
    fn a_jpeg_is_small_and_says_its_kind() {
        for (kind, number) in [(ImageKind::Super, 1), (ImageKind::Good, 2), (ImageKind::Bad, 5)] {
            let bytes = encode(kind, &tiles(), [0, 0, 640, 480]);
            assert_eq!(bytes[0], number);
            assert_eq!(bytes[1..5], (bytes.len() as u32 - 5).to_be_bytes());
            assert_eq!(bytes[5..7], [0xff, 0xd8]);
            assert!(bytes.len() < 20_000, "{}", bytes.len());
        }
        assert_eq!(encode(ImageKind::Good, &tiles(), [640, 0, 1, 1]), [2, 0, 0, 0, 0]);
    }
}
