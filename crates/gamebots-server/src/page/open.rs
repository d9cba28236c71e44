//! Request to open files of other programs: `POST /open` with a form whose fields are the files, each named by its path. Its answer names the
//! class or map, which the page then spawns or changes to, or lists the files that could be meant.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use axum::Extension;
use axum::body::Bytes;
use axum::extract::multipart::MultipartError;
use axum::extract::{Multipart, Query, State};
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use serde_json::json;
use tokio::task::spawn_blocking;
use tokio::time::timeout;

use crate::access::origin::bearer;
use crate::access::tokens::Role;
use crate::page::opener::{Answer, NotOpened};
use crate::page::packed::json;
use crate::page::shared::{Peer, Site, Visit};

/// Most bytes of all files: meshes of a robot take some ten MB.
pub(crate) const MAX_BYTES: usize = 128 << 20;
/// Most files.
const MAX_FILES: usize = 2000;
/// Longest time for files to arrive, and for their wait until those of others are opened.
const PATIENCE: Duration = Duration::from_secs(60);

#[derive(Deserialize)]
pub(crate) struct Chosen {
    /// Path of the file that is meant, if several could be.
    file: Option<String>,
}

pub(crate) async fn answer(
    State(site): State<Arc<Site>>,
    Extension(visit): Extension<Arc<Visit>>,
    Extension(peer): Extension<Peer>,
    Query(chosen): Query<Chosen>,
    headers: HeaderMap,
    form: Multipart,
) -> Response {
    let opened = match admit(&site, &visit, peer, &headers) {
        Ok(()) => work(&site, chosen.file, form).await,
        Err(refused) => Err(refused),
    };
    match opened {
        Ok(Ok(answer)) => json(serde_json::to_vec(&answer).unwrap_or_default().into()),
        Ok(Err(NotOpened::Choose(choices))) => json(json!({ "choices": choices }).to_string().into()),
        Ok(Err(NotOpened::Bad(reason))) => (StatusCode::UNPROCESSABLE_ENTITY, format!("{reason}\n")).into_response(),
        Err((status, reason)) => (status, format!("{reason}\n")).into_response(),
    }
}

type Refused = (StatusCode, String);

/// Refuses who may not control the world.
fn admit(site: &Site, visit: &Visit, peer: Peer, headers: &HeaderMap) -> Result<(), Refused> {
    let rights = site.access.rights(bearer(headers), &[Role::Referee]);
    let rights = rights.map_err(|refusal| (StatusCode::UNAUTHORIZED, format!("not opened: {refusal}")))?;
    if let Some(reason) = site.access.refusal(&rights, site.world_control, peer.address, peer.own) {
        return Err((StatusCode::FORBIDDEN, format!("not opened: {reason}")));
    }
    if visit.admit() { Ok(()) } else { Err((StatusCode::SERVICE_UNAVAILABLE, "too many pages are open".to_owned())) }
}

async fn work(site: &Site, chosen: Option<String>, form: Multipart) -> Result<Result<Answer, NotOpened>, Refused> {
    let none = || (StatusCode::NOT_FOUND, "this server opens no files".to_owned());
    let opener = site.opener.clone().ok_or_else(none)?;
    let busy = |_| (StatusCode::SERVICE_UNAVAILABLE, "the files of others are being opened: try again".to_owned());
    let place = timeout(PATIENCE, opener.places.clone().acquire_owned()).await.map_err(busy)?;
    let place = place.map_err(|_| (StatusCode::SERVICE_UNAVAILABLE, "the server ends".to_owned()))?;
    let slow = |_| {
        let text = format!("the files have not come whole within {} s", PATIENCE.as_secs());
        (StatusCode::REQUEST_TIMEOUT, text)
    };
    let files = timeout(PATIENCE, received(form)).await.map_err(slow)??;
    let opened = spawn_blocking(move || {
        let _place = place;
        opener.open(&files, chosen.as_deref())
    });
    // A panic would be a defect of the readers; it ends only this answer.
    Ok(opened.await.unwrap_or_else(|_| Err(NotOpened::Bad("a defect: the files cannot be opened".to_owned()))))
}

/// Receives the files of a form, by their paths.
async fn received(mut form: Multipart) -> Result<BTreeMap<String, Bytes>, Refused> {
    let wrong = |error: MultipartError| match error.status() {
        StatusCode::PAYLOAD_TOO_LARGE => {
            (StatusCode::PAYLOAD_TOO_LARGE, format!("the files are larger than {} MB together", MAX_BYTES >> 20))
        }
        status => (status, error.body_text()),
    };
    let mut files = BTreeMap::new();
    while let Some(field) = form.next_field().await.map_err(wrong)? {
        if files.len() >= MAX_FILES {
            return Err((StatusCode::PAYLOAD_TOO_LARGE, format!("expected at most {MAX_FILES} files")));
        }
        let name = field.name().unwrap_or_default().to_owned();
        files.insert(name, field.bytes().await.map_err(wrong)?);
    }
    Ok(files)
}
