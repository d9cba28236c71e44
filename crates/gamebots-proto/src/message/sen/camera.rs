//! An empty body: a camera sends its line, its pictures go elsewhere (protocol.md 0.9).

use super::ReadWrite;
use crate::Line;

/// The camera is alive.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera;

impl ReadWrite for Camera {
    const TYPE: &'static str = "Camera";

    fn name(&self) -> Option<&str> {
        None
    }

    fn write(&self) -> String {
        String::new()
    }

    fn read(_line: &Line) -> Option<Self> {
        Some(Self)
    }
}
