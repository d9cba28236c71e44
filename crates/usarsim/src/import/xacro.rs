//! Expansion of xacro files by Python's `xacro`, as a process with bounded time, memory and output.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::{Failure, exit};

/// Program that expands; its first arguments list the packages and the folders of modules.
const PROGRAM: &str = include_str!("expand.py");
/// Exit code of `PROGRAM` if Python has no xacro.
const NO_XACRO: i32 = 90;
/// Maximum time of an expansion.
const MAX_TIME: Duration = Duration::from_secs(60);
/// Maximum size of an expanded file, bytes, as of any URDF.
const MAX_OUTPUT: u64 = 4 << 20;
/// Maximum size of messages, bytes.
const MAX_MESSAGES: u64 = 64 << 10;
/// Maximum number of lines of an error that are shown.
const MAX_LINES: usize = 8;

/// True for a file that ends in `.xacro`, or declares xacro and uses it. Any other file starts no other program.
pub(super) fn is_needed(file: &Path, text: &str) -> bool {
    file.extension().is_some_and(|ending| ending == "xacro") || is_used(text)
}

/// True for a text that declares xacro and uses it.
pub(crate) fn is_used(text: &str) -> bool {
    ["<xacro:", "${", "$("].iter().any(|it| text.contains(it)) && scene_loader::declares_xacro(text)
}

/// Returns the folders of PYTHONPATH in which Python may search modules: absolute ones, without the current folder and that of the file.
/// They may hold anything, such as a `json.py` of a stranger.
fn module_folders(file: &Path) -> Vec<String> {
    let resolved = |folder: &Path| folder.canonicalize().ok();
    let refused = [resolved(Path::new(".")), file.parent().and_then(resolved)];
    let paths = std::env::var_os("PYTHONPATH").unwrap_or_default();
    let trusted = std::env::split_paths(&paths).filter(|folder| folder.is_absolute());
    let trusted =
        trusted.filter_map(|folder| resolved(&folder)).filter(|folder| !refused.contains(&Some(folder.clone())));
    trusted.map(|folder| folder.display().to_string()).collect()
}

/// Returns the URDF of a xacro file, and the names of packages that were not found.
pub(super) fn expand(
    file: &Path,
    arguments: &[String],
    packages: &BTreeMap<String, PathBuf>,
) -> Result<(String, Vec<String>), Failure> {
    let folders: BTreeMap<&String, String> =
        packages.iter().map(|(name, folder)| (name, folder.display().to_string())).collect();
    let failed = |message: String| Failure::new(exit::FAILURE, message);
    let packages = serde_json::to_string(&folders).map_err(|error| failed(error.to_string()))?;
    let file = file.canonicalize().map_err(|error| failed(format!("{}: {error}", file.display())))?;
    let modules = serde_json::to_string(&module_folders(&file)).map_err(|error| failed(error.to_string()))?;
    let mut command = Command::new("python3");
    // Relative folders of PATH, too, must not lead to the current folder.
    command.args(["-I", "-c", PROGRAM, &packages, &modules]).arg(&file).args(arguments).current_dir("/");
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let install = "a xacro file needs Python's xacro: `pip install xacro`";
    let child = command.spawn().map_err(|error| failed(format!("python3: {error}: {install}")))?;
    let Output { code, text, messages } = wait(child)?;
    let messages = String::from_utf8_lossy(&messages).into_owned();
    let missing: BTreeSet<&str> =
        messages.lines().filter_map(|line| line.strip_prefix("usarsim: no package ")).collect();
    match code {
        Some(0) => {}
        Some(NO_XACRO) => {
            let searched = "searched in its own packages, the user's and absolute folders of PYTHONPATH";
            return Err(failed(format!("python3 has no module xacro ({searched}): {install}")));
        }
        _ => {
            let lines = messages.lines().filter(|line| !line.starts_with("usarsim: ") && !line.trim().is_empty());
            let lines = lines.skip_while(|line| !line.starts_with("error: "));
            let reason = lines.take(MAX_LINES).collect::<Vec<_>>().join("\n");
            let reason = if reason.is_empty() { "it failed without an error message".to_owned() } else { reason };
            let mut message = format!("{}: xacro: {reason}", file.display());
            if let Some(name) = missing_argument(&reason) {
                message += &format!("\ngive it behind the file: {name}:=VALUE");
            }
            for name in missing {
                message += &format!("\npackage `{name}` is not found: name its folder by --package {name}=FOLDER");
            }
            return Err(Failure::new(exit::BAD_DATA, message));
        }
    }
    let mut text = String::from_utf8(text)
        .map_err(|error| Failure::new(exit::BAD_DATA, format_args!("{}: expanded: {error}", file.display())))?;
    for name in &missing {
        text = text.replace(&format!("file:///[{name}]"), &format!("package://{name}"));
    }
    Ok((text, missing.into_iter().map(str::to_owned).collect()))
}

/// Returns the name of an argument that xacro misses, from its message.
fn missing_argument(reason: &str) -> Option<&str> {
    let (_, rest) = reason.split_once("Undefined substitution argument ")?;
    rest.split_whitespace().next().map(|name| name.trim_matches(['`', '\'', '"', '.']))
}

/// Says how to use a file that only defines macros; `None` if it defines none, or its expansion has links.
pub(super) fn only_macros(file: &Path, text: &str, expanded: &str) -> Option<String> {
    /// Most macros that are named.
    const SHOWN: usize = 5;
    if expanded.contains("<link") {
        return None;
    }
    let attribute = |text: &str, name: &str| {
        let (_, rest) = text.split_once(&format!(" {name}="))?;
        let quote = rest.chars().next().filter(|c| ['"', '\''].contains(c))?;
        Some(rest[1..].split(quote).next()?.split_whitespace().collect::<Vec<_>>().join(" "))
    };
    let tags = text.split("<xacro:macro").skip(1).filter_map(|rest| rest.split('>').next());
    let named = tags.filter_map(|tag| {
        let name = attribute(tag, "name")?;
        let parameters = attribute(tag, "params").filter(|it| !it.is_empty());
        Some(parameters.map_or(name.clone(), |it| format!("{name} ({it})")))
    });
    let macros: Vec<String> = named.take(SHOWN).collect();
    let first = macros.first()?.split(' ').next()?.to_owned();
    let (name, list) = (file.display(), macros.join("; "));
    Some(format!(
        "{name} only defines macros: {list}. Expected a file that calls one: a <robot> with <xacro:include filename=\"{name}\"/> and <xacro:{first} ../>"
    ))
}

struct Output {
    /// Exit code; `None` if a signal ended the process.
    code: Option<i32>,
    text: Vec<u8>,
    messages: Vec<u8>,
}

/// Waits for a process, and ends it if it takes too long or writes too much.
fn wait(mut child: Child) -> Result<Output, Failure> {
    let text = child.stdout.take().map(|pipe| std::thread::spawn(move || read(pipe, MAX_OUTPUT)));
    let messages = child.stderr.take().map(|pipe| std::thread::spawn(move || read(pipe, MAX_MESSAGES)));
    let start = Instant::now();
    let status = loop {
        let ended = child.try_wait().map_err(|error| Failure::new(exit::FAILURE, error))?;
        if let Some(status) = ended {
            break status;
        }
        if start.elapsed() > MAX_TIME {
            let _ = child.kill().and_then(|()| child.wait());
            let message = format_args!("xacro takes longer than {} s: expected an end", MAX_TIME.as_secs());
            return Err(Failure::new(exit::BAD_DATA, message));
        }
        std::thread::sleep(Duration::from_millis(10));
    };
    let [text, messages] = [text, messages].map(|reader| reader.and_then(|it| it.join().ok()).unwrap_or_default());
    if text.len() as u64 > MAX_OUTPUT {
        let message = format_args!("xacro makes more than {MAX_OUTPUT} bytes: expected a smaller robot");
        return Err(Failure::new(exit::BAD_DATA, message));
    }
    Ok(Output { code: status.code(), text, messages })
}

/// Reads up to one byte beyond the limit. A process that writes more gets an error, as nobody reads on.
fn read(pipe: impl Read, most: u64) -> Vec<u8> {
    let mut bytes = Vec::new();
    // A broken pipe ends the text; the exit code says more.
    let _ = pipe.take(most + 1).read_to_end(&mut bytes);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_of_macros_says_which_to_call() {
        let text = "<robot xmlns:xacro='u'><xacro:macro name=\"wheel\" params=\"prefix\n  *origin\"><link/></xacro:macro>\
                    <xacro:macro name='base'/></robot>";
        let said = only_macros(Path::new("parts.xacro"), text, "<robot/>").expect("a message");
        assert!(said.starts_with("parts.xacro only defines macros: wheel (prefix *origin); base. "), "{said}");
        assert!(said.ends_with("<xacro:wheel ../>"), "{said}");
        assert_eq!(only_macros(Path::new("x"), text, "<robot><link name='a'/></robot>"), None);
        assert_eq!(only_macros(Path::new("x"), "<robot/>", "<robot/>"), None);
    }

    #[test]
    fn a_missing_argument_is_named() {
        for (reason, name) in [
            ("error: Undefined substitution argument robot_model\nwhen processing x", Some("robot_model")),
            ("error: Undefined substitution argument 'x'", Some("x")),
            ("error: no such file", None),
        ] {
            assert_eq!(missing_argument(reason), name, "{reason}");
        }
    }
}
