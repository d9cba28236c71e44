//! `/metrics` for Prometheus and `/health` for supervisors: counts, which any viewer may see.
//!
//! The world's thread answers, so a world that hangs is seen. No page needs them, so they do not depend on the name in the request: a
//! supervisor may call the machine as it likes.

use std::fmt::Write;
use std::sync::Arc;
use std::time::Duration;

use axum::extract::State;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use served_world::{Health, Question};
use tokio::time::timeout;

use crate::page::shared::Site;

/// Longest wait for the world.
const PATIENCE: Duration = Duration::from_secs(2);

/// Asks the world. `None` if it does not answer in time.
async fn ask(site: &Site) -> Option<Health> {
    timeout(PATIENCE, site.inquiry.ask(Question::Health)).await.ok().flatten()
}

pub(crate) async fn health(State(site): State<Arc<Site>>) -> Response {
    let head = [(header::CONTENT_TYPE, "application/json"), (header::CACHE_CONTROL, "no-store")];
    match ask(&site).await {
        Some(health) => {
            // Supervisors have no token, and learn no more than that the world answers.
            let body = match site.access.is_open() {
                true => serde_json::json!({ "status": "ok", "time": health.simulated, "robots": health.robots }),
                false => serde_json::json!({ "status": "ok" }),
            };
            (head, body.to_string()).into_response()
        }
        None => (StatusCode::SERVICE_UNAVAILABLE, head, "{\"status\":\"the world does not answer\"}").into_response(),
    }
}

pub(crate) async fn metrics(State(site): State<Arc<Site>>) -> Response {
    let Some(health) = ask(&site).await else { return StatusCode::SERVICE_UNAVAILABLE.into_response() };
    let head = [(header::CONTENT_TYPE, "text/plain; version=0.0.4"), (header::CACHE_CONTROL, "no-store")];
    (head, text(&health) + &limits(&site.limits)).into_response()
}

/// Returns the limits of connections in Prometheus's text format.
fn limits(limits: &[(&str, usize)]) -> String {
    let mut text = "# HELP usarsim_connection_limit Most connections of a kind at once.\n\
                    # TYPE usarsim_connection_limit gauge\n"
        .to_owned();
    for (kind, limit) in limits {
        // Writing to a text cannot fail.
        let _ = writeln!(text, "usarsim_connection_limit{{kind=\"{kind}\"}} {limit}");
    }
    text
}

/// Returns the numbers in Prometheus's text format.
fn text(health: &Health) -> String {
    let gauge = |name, help, value| (name, "gauge", help, value);
    let counter = |name, help, value| (name, "counter", help, value);
    let rows = [
        gauge("usarsim_simulated_seconds", "Time in the world.", health.simulated),
        gauge(
            "usarsim_real_time_factor",
            "Simulated seconds per real second over the last half second.",
            health.real_time_factor,
        ),
        gauge("usarsim_wanted_real_time_factor", "The factor asked for; 0 is as fast as possible.", health.speed),
        gauge("usarsim_paused", "1 while the world is paused.", f64::from(u8::from(health.paused))),
        counter("usarsim_steps_total", "Steps of the world since the server started.", health.steps as f64),
        counter("usarsim_step_seconds_total", "Real time that those steps took.", health.step_seconds),
        gauge(
            "usarsim_unsettled_steps",
            "Steps of the present world whose contacts did not converge.",
            health.solver.unsettled as f64,
        ),
        gauge(
            "usarsim_solver_systems",
            "Robots, or groups that touch, solved in the present world.",
            health.solver.systems as f64,
        ),
        gauge("usarsim_solver_sweeps", "Sweeps over their contacts.", health.solver.sweeps as f64),
        gauge("usarsim_solver_newton_steps", "Steps of Newton's method for them.", health.solver.newton_steps as f64),
        gauge("usarsim_robots", "Robots in the world.", health.robots as f64),
        gauge("usarsim_clients", "Connected controllers.", health.clients as f64),
        counter(
            "usarsim_dropped_lines_total",
            "Periodic lines dropped because clients were too slow.",
            health.dropped_lines as f64,
        ),
        counter("usarsim_resets_total", "Times that the world started over.", health.resets as f64),
    ];
    let mut text = String::new();
    for (name, kind, help, value) in rows {
        // Writing to a text cannot fail.
        let _ = writeln!(text, "# HELP {name} {help}\n# TYPE {name} {kind}\n{name} {value}");
    }
    text
}
