//! Classes of robots for pages. Each is written and packed once, when a page first asks for it.

use std::collections::BTreeMap;
use std::sync::Arc;

use axum::body::Bytes;
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};
use flate2::Compression;
use gamebots_proto::shown;
use names::listed;
use page_protocol::class_json;
use scene::Classes;
use tokio::sync::Mutex;
use tokio::task::spawn_blocking;

use crate::page::packed::{answer, pack};

/// Classes of robots for pages.
pub(crate) struct ClassPages {
    classes: Classes,
    made: Arc<Mutex<BTreeMap<String, Made>>>,
}

/// A class as JSON and its packed form, or the reason why it cannot be read.
type Made = Result<(Bytes, Option<Bytes>), String>;

impl ClassPages {
    pub(crate) fn new(classes: &Classes) -> Self {
        Self { classes: classes.clone(), made: Arc::default() }
    }

    /// Answers with a class of robots.
    pub(crate) async fn answer(&self, name: &str, headers: &HeaderMap) -> Response {
        if !self.classes.contains_key(name) {
            let known = listed(self.classes.keys().map(String::as_str));
            let text = format!("no class `{}`: expected one of {known}\n", shown(name).escape_debug());
            return (StatusCode::NOT_FOUND, text).into_response();
        }
        match self.made(name).await {
            Ok((body, packed)) => answer(headers, body, packed),
            Err(reason) => (StatusCode::UNPROCESSABLE_ENTITY, format!("class {name}: {reason}\n")).into_response(),
        }
    }

    /// Returns a class, and makes it on another thread if nobody has. That thread holds the lock: pages that ask for all classes at once use
    /// one core, and a page that leaves loses no work.
    async fn made(&self, name: &str) -> Made {
        let mut made = self.made.clone().lock_owned().await;
        if let Some(made) = made.get(name) {
            return made.clone();
        }
        let (classes, name) = (self.classes.clone(), name.to_owned());
        let make = move || made.entry(name).or_insert_with_key(|name| make(&classes, name)).clone();
        spawn_blocking(make).await.unwrap_or_else(|_| Err("a defect: the class cannot be drawn".to_owned()))
    }
}

fn make(classes: &Classes, name: &str) -> Made {
    let class =
        classes.get(name).ok_or_else(|| classes.problem(name).unwrap_or("there is no such class").to_owned())?;
    let body = Bytes::from(class_json(class));
    let packed = pack(&body, Compression::fast());
    Ok((body, packed))
}
