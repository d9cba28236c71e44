//! An empty body. A camera sends only this line; its pictures take another way (protocol.md 0.9).

use super::Body;
use crate::field::{Format, record};

record! {
    /// The camera is alive.
    Camera {}
}

impl Body for Camera {
    const TYPE: &'static str = "Camera";
    const TIME: [Format; 2] = [Format::Rounded(4), Format::Fixed(4)];

    fn name(&self) -> Option<&str> {
        None
    }
}
