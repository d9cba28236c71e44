//! Classes of robots for pages. Each is written and packed when a page first asks for it.

use std::collections::BTreeMap;

use axum::body::Bytes;
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};
use names::listed;
use scene::Classes;
use tokio::sync::OnceCell;
use tokio::task::spawn_blocking;

use crate::messages::scene::class_json;
use crate::page::packed::Packed;

/// Most letters of a wrong name that an answer repeats.
const MAX_SHOWN: usize = 64;

/// Classes of robots for pages.
pub(crate) struct ClassPages {
    classes: Classes,
    made: BTreeMap<String, Made>,
}

/// A class as JSON, or the reason why it cannot be read, and its packed form.
#[derive(Default)]
struct Made {
    body: OnceCell<Result<Bytes, String>>,
    packed: Packed,
}

impl ClassPages {
    pub(crate) fn new(classes: &Classes) -> Self {
        let made = classes.keys().map(|name| (name.clone(), Made::default())).collect();
        Self { classes: classes.clone(), made }
    }

    /// Answers with a class of robots.
    pub(crate) async fn answer(&self, name: &str, headers: &HeaderMap) -> Response {
        let Some(made) = self.made.get(name) else {
            let got: String = name.chars().take(MAX_SHOWN).collect();
            let known = listed(self.classes.keys().map(String::as_str));
            let text = format!("no class `{}`: expected one of {known}\n", got.escape_debug());
            return (StatusCode::NOT_FOUND, text).into_response();
        };
        match self.body(name, made).await {
            Ok(body) => made.packed.answer(headers, body).await,
            Err(reason) => (StatusCode::UNPROCESSABLE_ENTITY, format!("class {name}: {reason}\n")).into_response(),
        }
    }

    async fn body(&self, name: &str, made: &Made) -> Result<Bytes, String> {
        let make = async || {
            let (classes, name) = (self.classes.clone(), name.to_owned());
            // Files are read and shapes written: the other connections do not wait for that.
            let made = spawn_blocking(move || match classes.get(&name) {
                Some(class) => Ok(class_json(class).into()),
                None => Err(classes.problem(&name).unwrap_or("there is no such class").to_owned()),
            });
            made.await.unwrap_or_else(|_| Err("a defect: the class cannot be drawn".to_owned()))
        };
        made.body.get_or_init(make).await.clone()
    }
}
