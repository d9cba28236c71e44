//! Rights of clients, their logins, and their shares of limited things.

pub(crate) mod login;
pub(crate) mod origin;
pub(crate) mod pass;
pub(crate) mod rights;
pub(crate) mod shares;
pub(crate) mod tokens;
pub(crate) mod waiting_room;
