//! Fuzz targets: everything that a stranger can send, as functions from bytes.
//!
//! A target panics where an invariant is broken. The same functions are called on the committed inputs and random changes of
//! them by `cargo test`, and with coverage as the guide by `make fuzz`. What they check and what they found is in
//! `docs/reliability.md`.

#![forbid(unsafe_code)]

mod files;
#[cfg(feature = "libfuzzer")]
mod guided;
mod log;
mod ports;
mod requests;
mod saved;
mod wire;
mod world;

pub use files::{dae, glb, ini, league, map, material, obj, robot, sdf, stl, urdf};
#[cfg(feature = "libfuzzer")]
pub use guided::guided;
pub use log::log;
pub use ports::ports;
pub use requests::requests;
pub use saved::saved;
pub use wire::wire;
pub use world::world;

use std::alloc::System;
use std::fmt::Debug;
use std::panic::{set_hook, take_hook};
use std::sync::{Mutex, Once, PoisonError};

use cap::Cap;

/// Takes any bytes.
pub type Target = fn(&[u8]);

/// Every target with its name, which is also that of its folder in `corpus`.
pub const TARGETS: [(&str, Target); 17] = [
    ("wire", wire),
    ("ports", ports),
    ("world", world),
    ("robot", robot),
    ("map", map),
    ("league", league),
    ("material", material),
    ("ini", ini),
    ("sdf", sdf),
    ("urdf", urdf),
    ("stl", stl),
    ("obj", obj),
    ("dae", dae),
    ("glb", glb),
    ("log", log),
    ("requests", requests),
    ("saved", saved),
];

/// Most memory that an input may need, bytes.
pub const MEMORY: usize = 64 << 20;

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, usize::MAX);

/// Runs a target on an input with a limit on its memory: an allocation beyond it ends the process.
pub fn run(target: Target, bytes: &[u8]) {
    static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
    static HOOK: Once = Once::new();
    let _alone = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
    // What prints a panic needs more than the target may.
    HOOK.call_once(|| {
        let print = take_hook();
        set_hook(Box::new(move |panic| {
            limit(usize::MAX);
            print(panic);
        }));
    });
    limit(ALLOCATOR.allocated() + MEMORY);
    target(bytes);
    limit(usize::MAX);
}

fn limit(bytes: usize) {
    // Refused only where more is allocated already.
    let _ = ALLOCATOR.set_limit(bytes);
}

/// Panics when there is a number that is not finite in a value, as its `Debug` shows it.
fn assert_finite(what: &str, value: &impl Debug) {
    let shown = format!("{value:?}");
    assert!(!has_not_finite(&shown), "{what} has a number that is not finite: {shown}");
}

/// True if `NaN` or `inf` stands outside of quotes.
fn has_not_finite(debug: &str) -> bool {
    let (mut quoted, mut escaped) = (false, false);
    let word = |c: char| {
        let inside = quoted;
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = quoted,
            '"' => quoted = !quoted,
            _ => {}
        }
        inside || !c.is_alphanumeric()
    };
    debug.split(word).any(|word| word == "NaN" || word == "inf")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_are_not_finite_are_seen() {
        for (value, finite) in
            [(vec![1.0, -2.5e300], true), (vec![0.0, f64::NAN], false), (vec![-f64::INFINITY], false)]
        {
            assert_eq!(has_not_finite(&format!("{value:?}")), !finite, "{value:?}");
        }
        for (value, finite) in [(("inf", 1.0), true), (("a \" NaN", f32::NAN), false), (("\\", 0.0), true)] {
            assert_eq!(has_not_finite(&format!("{value:?}")), !finite, "{value:?}");
        }
    }

    #[test]
    #[should_panic(expected = "not finite")]
    fn a_number_that_is_not_finite_is_a_finding() {
        assert_finite("it", &Some(f32::INFINITY));
    }
}
