//! Running the built command in a folder of its own.
#![allow(dead_code, reason = "each test file uses a part of it")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// A temporary folder and the command that runs in it.
pub struct Bench {
    folder: tempfile::TempDir,
}

/// What a run left behind.
pub struct Ran {
    /// Exit code.
    pub code: i32,
    /// Standard output.
    pub stdout: String,
    /// Standard error.
    pub stderr: String,
}

impl Bench {
    /// An empty folder.
    pub fn new() -> Self {
        Self { folder: tempfile::tempdir().expect("a temporary folder") }
    }

    /// A path in it.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes a file into it.
    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        std::fs::write(&path, content).expect("a file in a temporary folder");
        path
    }

    /// Reads a file of it.
    pub fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// Names of its files, sorted.
    pub fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.folder.path()).expect("the folder");
        let mut names: Vec<String> =
            entries.filter_map(|e| Some(e.ok()?.file_name().to_string_lossy().into_owned())).collect();
        names.sort();
        names
    }

    /// The command with these words, in the folder.
    pub fn command(&self, words: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_quadloom"));
        command.args(words).current_dir(self.folder.path()).stdin(Stdio::null());
        command
    }

    /// Runs it.
    pub fn run(&self, words: &[&str]) -> Ran {
        let output = self.command(words).output().expect("the built command");
        Ran::of(&output)
    }

    /// Runs a line of words separated by blanks.
    pub fn line(&self, line: &str) -> Ran {
        self.run(&line.split_whitespace().collect::<Vec<_>>())
    }
}

impl Ran {
    /// What a finished process left.
    pub fn of(output: &Output) -> Self {
        Self {
            code: output.status.code().unwrap_or(-1),
            stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
            stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
        }
    }

    /// Checks the exit code and that every word is in the message.
    #[track_caller]
    pub fn fails_with(&self, code: i32, words: &[&str]) {
        assert_eq!(self.code, code, "{}", self.stderr);
        assert!(self.stderr.starts_with("error: ") || code == 2, "{}", self.stderr);
        for word in words {
            assert!(self.stderr.contains(word), "{word} is not in: {}", self.stderr);
        }
        assert!(!self.stderr.contains("panicked"), "{}", self.stderr);
    }

    /// Checks that there is a result that misses a request, and that every word is in the message.
    #[track_caller]
    pub fn fails_by_missing(&self, words: &[&str]) {
        assert_eq!(self.code, 6, "{}", self.stderr);
        for word in words {
            assert!(self.stderr.contains(word), "{word} is not in: {}", self.stderr);
        }
    }

    /// Checks for success.
    #[track_caller]
    pub fn succeeds(&self) {
        assert_eq!(self.code, 0, "{}{}", self.stdout, self.stderr);
    }
}

/// Vertices and quads of an OBJ file, read without the project's own reader.
pub fn read_quads(path: &Path) -> (Vec<[f64; 3]>, Vec<[usize; 4]>) {
    let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let (mut points, mut quads) = (Vec::new(), Vec::new());
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["v", x, y, z, ..] => points.push([x, y, z].map(|w| w.parse().expect("a number"))),
            ["f", ref corners @ ..] => {
                let index = |w: &&str| w.split('/').next().and_then(|i| i.parse::<usize>().ok()).expect("an index") - 1;
                let quad: Vec<usize> = corners.iter().map(index).collect();
                quads.push(quad.try_into().unwrap_or_else(|f| panic!("not a quad: {f:?}")));
            }
            _ => {}
        }
    }
    (points, quads)
}

/// Number of vertices of a generated shape.
pub fn read_count(bench: &Bench, sample: &str) -> usize {
    let name = format!("{sample}.off");
    bench.line(&format!("convert sample:{sample} {name}")).succeeds();
    let text = String::from_utf8(bench.read(&name)).expect("text");
    text.split_whitespace().nth(1).and_then(|n| n.parse().ok()).expect("a count after the word OFF")
}

/// V - E + F, number of components and of boundary edges; panics where an edge has more than two faces or is
/// passed twice in one direction.
pub fn topology(points: usize, quads: &[[usize; 4]]) -> (i64, usize, usize) {
    use std::collections::{BTreeMap, BTreeSet};
    let mut sides = BTreeSet::new();
    for quad in quads {
        for k in 0..4 {
            assert!(sides.insert((quad[k], quad[(k + 1) % 4])), "a side is passed twice");
        }
    }
    let edges: BTreeSet<(usize, usize)> = sides.iter().map(|&(a, b)| (a.min(b), a.max(b))).collect();
    let boundary = sides.iter().filter(|&&(a, b)| !sides.contains(&(b, a))).count();
    let mut root: BTreeMap<usize, usize> = (0..points).map(|v| (v, v)).collect();
    fn find(root: &mut BTreeMap<usize, usize>, v: usize) -> usize {
        let mut at = v;
        while root[&at] != at {
            at = root[&at];
        }
        root.insert(v, at);
        at
    }
    for &(a, b) in &edges {
        let (a, b) = (find(&mut root, a), find(&mut root, b));
        root.insert(a.max(b), a.min(b));
    }
    let components = (0..points).filter(|&v| root[&v] == v).count();
    (points as i64 - edges.len() as i64 + quads.len() as i64, components, boundary)
}
