//! Messages between the page and the server.

pub(crate) mod control;
pub(crate) mod fit;
pub(crate) mod frame;
pub(crate) mod live;
pub mod pb;
pub(crate) mod scene;
