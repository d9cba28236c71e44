//! Rights of clients, their logins, and their shares of what all need.

pub(crate) mod budget;
pub(crate) mod login;
pub(crate) mod pass;
pub(crate) mod shares;
pub(crate) mod tokens;
pub(crate) mod waiting_room;
