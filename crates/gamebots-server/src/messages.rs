//! Messages between the page and the server.

pub(crate) mod control;
pub(crate) mod fit;
pub(crate) mod frame;
pub mod pb;
pub(crate) mod scene;
