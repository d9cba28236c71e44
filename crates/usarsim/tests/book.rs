//! Tests of the book: every command in a `console` block of docs/*.md is run, in the order of its page, with the files that the page shows.
//! Its output must be as shown.

#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use std::collections::BTreeSet;
use std::fs;
use std::io::{BufRead, BufReader};
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc;
use std::time::Duration;

const PATIENCE: Duration = Duration::from_secs(60);

/// A fenced block: the text after the fence, and its lines.
struct Block {
    info: String,
    lines: Vec<String>,
}

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn pages() -> Vec<PathBuf> {
    let files = fs::read_dir(repository().join("docs")).unwrap().map(|entry| entry.unwrap().path());
    let mut pages: Vec<PathBuf> = files.filter(|path| path.extension().is_some_and(|end| end == "md")).collect();
    pages.sort();
    pages
}

fn blocks(text: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut open: Option<Block> = None;
    for line in text.lines() {
        match (line.strip_prefix("```"), open.take()) {
            (Some(_), Some(block)) => blocks.push(block),
            (Some(info), None) => open = Some(Block { info: info.to_owned(), lines: Vec::new() }),
            (None, Some(mut block)) => {
                block.lines.push(line.to_owned());
                open = Some(block);
            }
            (None, None) => {}
        }
    }
    blocks
}

/// Returns the commands of a block, each with the output shown.
fn commands(block: &Block) -> Vec<(String, Vec<String>)> {
    let mut commands: Vec<(String, Vec<String>)> = Vec::new();
    for line in &block.lines {
        match (line.strip_prefix("$ "), commands.last_mut()) {
            (Some(command), _) => commands.push((command.to_owned(), Vec::new())),
            (None, Some((_, shown))) => shown.push(line.clone()),
            (None, None) => panic!("output before a command: {line}"),
        }
    }
    commands
}

/// Replaces numbers, which differ by time, port or version.
fn without_numbers(line: &str) -> String {
    let digits_as_one = line.chars().map(|letter| if letter.is_ascii_digit() { '#' } else { letter });
    let mut text = String::new();
    for letter in digits_as_one {
        if !(letter == '#' && text.ends_with('#')) {
            text.push(letter);
        }
    }
    text
}

/// A page under test: a folder, and a server that may be running.
struct Page {
    folder: tempfile::TempDir,
    port: u16,
    server: Option<Child>,
}

impl Page {
    fn new() -> Self {
        let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        Self { folder: tempfile::tempdir().unwrap(), port, server: None }
    }

    /// Replaces the page's ports by free ones.
    fn localised(&self, text: &str) -> String {
        text.replace("3000", &self.port.to_string()).replace("3001", &self.port.to_string()).replace("8765", "0")
    }

    fn shell(&self, command: &str) -> Command {
        let program = Path::new(env!("CARGO_BIN_EXE_usarsim")).parent().unwrap();
        let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap());
        let mut shell = Command::new("bash");
        shell.args(["-c", &format!("exec {command}")]).current_dir(self.folder.path()).env("PATH", path);
        shell.env("USARSIM_PORT", self.port.to_string()).env("USARSIM_HTTP", "0").stdin(Stdio::null());
        shell
    }

    fn run(&mut self, command: &str, shown: &[String]) {
        println!("$ {command}");
        let local = self.localised(command);
        let output = if local.starts_with("usarsim serve") {
            self.serve(&local, shown.len().max(1))
        } else {
            let local = format!("bash -o pipefail -c {}", quoted(&local));
            let done = self.shell(&local).output().unwrap();
            let (out, err) = (String::from_utf8_lossy(&done.stdout), String::from_utf8_lossy(&done.stderr));
            assert!(done.status.success(), "{command}: {}\n{out}\n{err}", done.status);
            out.lines().map(str::to_owned).collect()
        };
        let came: BTreeSet<String> = output.iter().map(|line| without_numbers(line)).collect();
        for line in shown {
            assert!(came.contains(&without_numbers(line)), "{command}: never printed: {line}\nbut: {output:#?}");
        }
    }

    /// Starts a server instead of the previous one. Returns the lines that it prints when it is ready.
    fn serve(&mut self, command: &str, lines: usize) -> Vec<String> {
        self.stop();
        // The shell sets USARSIM_HTTP, so the browser's page gets a free port. The book shows the default port.
        let mut child = self.shell(command).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let stdout = BufReader::new(child.stdout.take().unwrap());
        self.server = Some(child);
        let (sender, printed) = mpsc::channel();
        std::thread::spawn(move || stdout.lines().map_while(Result::ok).try_for_each(|line| sender.send(line)));
        (0..lines)
            .map(|_| printed.recv_timeout(PATIENCE).unwrap_or_else(|_| panic!("{command} prints nothing")))
            .collect()
    }

    fn stop(&mut self) {
        if let Some(mut server) = self.server.take() {
            server.kill().unwrap();
            server.wait().unwrap();
        }
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        self.stop();
    }
}

fn quoted(text: &str) -> String {
    format!("'{}'", text.replace('\'', "'\\''"))
}

#[test]
fn every_command_of_the_book_runs() {
    let mut count = 0;
    for path in pages() {
        println!("== {}", path.display());
        let mut page = Page::new();
        for block in blocks(&fs::read_to_string(&path).unwrap()) {
            if let Some((_, file)) = block.info.split_once("file=") {
                let text = block.lines.join("\n") + "\n";
                if file.starts_with("crates/") {
                    assert_eq!(text, fs::read_to_string(repository().join(file)).unwrap(), "{file} is another");
                    let built = Path::new(env!("CARGO_BIN_EXE_usarsim")).with_file_name("examples/drive");
                    assert!(built.exists(), "`cargo build --examples` makes {}", built.display());
                    let command = format!("{} 127.0.0.1:3000", built.display());
                    page.run(&command, &["arrived at y = 0.5".to_owned()]);
                } else {
                    let file = page.folder.path().join(file);
                    fs::create_dir_all(file.parent().unwrap()).unwrap();
                    fs::write(file, page.localised(&text)).unwrap();
                }
            } else if let Some((_, file)) = block.info.split_once("append=") {
                let file = page.folder.path().join(file);
                let before = fs::read_to_string(&file).unwrap();
                fs::write(file, before + "\n" + &block.lines.join("\n") + "\n").unwrap();
            } else if block.info == "console" {
                for (command, shown) in commands(&block) {
                    page.run(&command, &shown);
                    count += 1;
                }
            }
        }
    }
    assert!(count > 20, "{count}");
}

/// Also checks that every page is in the table of contents.
#[test]
fn links_of_the_book_lead_somewhere() {
    let link = regex::Regex::new(r#"\]\(([^)#\s]+)[^)]*\)|src="([^"]+)""#).unwrap();
    let summary = fs::read_to_string(repository().join("docs/SUMMARY.md")).unwrap();
    for path in pages() {
        let name = path.file_name().unwrap().to_str().unwrap();
        assert!(name == "SUMMARY.md" || summary.contains(&format!("({name})")), "{name} is not in docs/SUMMARY.md");
        for found in link.captures_iter(&fs::read_to_string(&path).unwrap()) {
            let target = found.get(1).or(found.get(2)).unwrap().as_str();
            let is_local = !target.contains("://");
            assert!(!is_local || path.with_file_name(target).exists(), "{name}: {target} is not there");
        }
    }
}
