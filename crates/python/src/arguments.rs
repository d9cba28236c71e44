//! Checks of arguments, and what they stand for.

use gamebots_proto::LIMIT;
use pyo3::prelude::*;
use thread_pool::ThreadPool;

use crate::error;

/// Returns a pool of threads; 0 are as many as the machine runs at a time.
pub(crate) fn pool(threads: usize) -> PyResult<ThreadPool> {
    if threads > 256 {
        return Err(error::command(format_args!("threads: got {threads}, expected 0 to 256")));
    }
    Ok(if threads == 0 { ThreadPool::of_machine()? } else { ThreadPool::new(threads)? })
}

/// Checks the size of a picture.
pub(crate) fn check_size(size: [usize; 2]) -> PyResult<()> {
    let is_good = size.iter().all(|edge| (16..=8192).contains(edge));
    is_good
        .then_some(())
        .ok_or_else(|| error::command(format_args!("size: got {size:?}, expected 16 to 8192 pixels each")))
}

/// Checks that numbers are finite.
pub(crate) fn check_finite(name: &str, numbers: &[f64]) -> PyResult<()> {
    match numbers.iter().find(|number| !number.is_finite()) {
        Some(number) => Err(error::command(format_args!("{name}: got {number}, expected finite numbers"))),
        None => Ok(()),
    }
}

/// Checks that numbers are finite and in the range of the protocol, as a log has them by its lines.
pub(crate) fn check_numbers(name: &str, numbers: &[f64]) -> PyResult<()> {
    check_finite(name, numbers)?;
    match numbers.iter().find(|number| number.abs() > LIMIT) {
        Some(number) => Err(error::command(format_args!("{name}: got {number}, expected -{LIMIT} to {LIMIT}"))),
        None => Ok(()),
    }
}

/// Checks that a text is one word that can be the key of a block.
pub(crate) fn check_key(name: &str, text: &str) -> PyResult<()> {
    check_text(name, text)?;
    if text.is_empty() || text.contains(char::is_whitespace) {
        return Err(error::command(format_args!("{name}: got {text:?}, expected one word")));
    }
    Ok(())
}

/// Checks that a text fits into a block of a line.
pub(crate) fn check_text(name: &str, text: &str) -> PyResult<()> {
    if text.contains(|c: char| c == '{' || c == '}' || c.is_control()) {
        return Err(error::command(format_args!("{name}: got {text:?}, expected a text without braces and line ends")));
    }
    Ok(())
}

/// Checks that a text is one line of the protocol.
pub(crate) fn check_line(line: &str) -> PyResult<()> {
    if line.contains(['\n', '\r']) || line.len() > 65536 {
        return Err(error::command("line: expected one line of at most 65536 bytes"));
    }
    Ok(())
}

/// Returns the error of an array whose numbers are not one after the other.
pub(crate) fn contiguous(name: &str) -> PyErr {
    error::task(format_args!("{name}: expected a contiguous array in C order"))
}

/// Returns the error of a world that another thread steps.
pub(crate) fn busy() -> PyErr {
    pyo3::exceptions::PyRuntimeError::new_err(
        "the world is being stepped in another thread: a world belongs to one thread at a time",
    )
}

/// Warns of problems that did not keep a command from being done.
pub(crate) fn warn(py: Python, problems: &[String]) -> PyResult<()> {
    let category = py.get_type::<error::UsarsimWarning>();
    for problem in problems {
        let text = std::ffi::CString::new(problem.replace('\0', " ")).map_err(error::command)?;
        PyErr::warn(py, &category, &text, 2)?;
    }
    Ok(())
}
