//! The port of pictures, 5003: what robots' cameras see (ImageServer.cpp; protocol.md 7.1).
//!
//! `OK` asks for the whole picture, `U` with four numbers for a part of it. Other bytes do not count, so ends of lines may follow.

/// A request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PictureRequest {
    /// The whole picture.
    Whole,
    /// A rectangle: x, y, width and height, pixels.
    Part([u32; 4]),
}

/// Reads requests from a stream of bytes.
#[derive(Debug, Clone, Default)]
pub struct PictureRequests {
    state: State,
}

#[derive(Debug, Clone, Default)]
enum State {
    /// Nothing has begun.
    #[default]
    Idle,
    /// After an O.
    AfterO,
    /// After a U, with the bytes of its numbers so far.
    Numbers(Vec<u8>),
}

impl PictureRequests {
    /// Takes a byte, and returns the request that it completes.
    pub fn push(&mut self, byte: u8) -> Option<PictureRequest> {
        match &mut self.state {
            State::Idle => {
                self.state = match byte {
                    b'O' => State::AfterO,
                    b'U' => State::Numbers(Vec::new()),
                    _ => State::Idle,
                };
                None
            }
            State::AfterO => {
                self.state = State::Idle;
                (byte == b'K').then_some(PictureRequest::Whole)
            }
            State::Numbers(bytes) => {
                bytes.push(byte);
                let (numbers, _) = bytes.as_chunks::<4>();
                let &[x, y, width, height] = numbers else { return None };
                self.state = State::Idle;
                Some(PictureRequest::Part([x, y, width, height].map(u32::from_be_bytes)))
            }
        }
    }
}

/// Returns an answer: the kind of picture, 0 for raw pixels or 1 to 5 for JPEG, its length and its bytes.
pub fn picture(kind: u8, bytes: &[u8]) -> Vec<u8> {
    let mut answer = vec![kind];
    answer.extend((bytes.len() as u32).to_be_bytes());
    answer.extend(bytes);
    answer
}

/// Returns raw pixels: width, height, and rows of blue, green and red, each filled up to a multiple of four bytes. `row` gives the red, green
/// and blue of a row's pixels.
pub fn raw<'a>(width: u16, height: u16, row: impl Fn(usize) -> &'a [[u8; 3]]) -> Vec<u8> {
    let filling = (4 - 3 * usize::from(width) % 4) % 4;
    let mut bytes = Vec::with_capacity(4 + usize::from(height) * (3 * usize::from(width) + filling));
    bytes.extend(width.to_be_bytes());
    bytes.extend(height.to_be_bytes());
    for number in 0..usize::from(height) {
        bytes.extend(row(number).iter().flat_map(|&[red, green, blue]| [blue, green, red]));
        bytes.extend(std::iter::repeat_n(0, filling));
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(bytes: &[u8], expected: &[PictureRequest]) {
        let mut requests = PictureRequests::default();
        let got: Vec<PictureRequest> = bytes.iter().filter_map(|&byte| requests.push(byte)).collect();
        assert_eq!(got, expected, "{bytes:?}");
    }

    #[test]
    fn requests_are_found_among_other_bytes() {
        use PictureRequest::{Part, Whole};
        check(b"", &[]);
        check(b"OK", &[Whole]);
        check(b"xyOK\r\nOK", &[Whole, Whole]);
        // Both bytes are taken.
        check(b"OOK", &[]);
        check(b"U\0\0\0\x01\0\0\0\x02\0\0\x01\x40\0\0\0\xf0\r\nOK", &[Part([1, 2, 320, 240]), Whole]);
        check(b"UOKOKOKOKOKOKOKOKOK", &[Part([0x4f4b_4f4b; 4]), Whole]);
        check(b"U\xff\xff\xff", &[]);
    }

    #[test]
    fn raw_pixels_have_the_bytes_of_usarsim() {
        let pixels = [[[1, 2, 3], [4, 5, 6]], [[7, 8, 9], [10, 11, 12]]];
        let bytes = raw(2, 2, |row| &pixels[row]);
        assert_eq!(bytes, [0, 2, 0, 2, 3, 2, 1, 6, 5, 4, 0, 0, 9, 8, 7, 12, 11, 10, 0, 0]);
        assert_eq!(picture(0, &bytes)[..7], [0, 0, 0, 0, 20, 0, 2]);
        assert_eq!(raw(0, 0, |_| &[]), [0; 4]);
    }
}
