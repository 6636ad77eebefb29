//! Markdown tables.

use super::runner::Run;
use serde_json::Value;
use std::fmt::Write as _;

/// What an evaluation hands back.
pub struct Evaluation {
    /// The document: headline figures and the table.
    pub markdown: String,
    /// Everything measured.
    pub runs: Vec<Value>,
    /// Promises that were broken: the tables are written, and the evaluation fails.
    pub broken: Vec<String>,
}

/// A document in the making: a table per question, aims met or missed.
#[derive(Default)]
pub struct Sheet {
    /// The tables.
    pub text: String,
    /// Everything measured.
    pub runs: Vec<Value>,
    /// Promises that were broken.
    pub broken: Vec<String>,
    aims: (usize, usize),
}

impl Sheet {
    /// A cell with an aim: bold where it is missed.
    pub fn aim(&mut self, text: impl Into<String>, is_met: bool) -> String {
        let text = text.into();
        self.aims.1 += 1;
        self.aims.0 += usize::from(is_met);
        if is_met { text } else { format!("**{text}**") }
    }

    /// Adds a table under a title.
    pub fn section(&mut self, title: &str, text: &str, head: &[&str], rows: &[Vec<String>]) {
        let _ = write!(self.text, "\n## {title}\n\n{text}\n\n{}", grid(head, rows));
    }

    /// The document: title and `intro`, how many aims are met, what is broken, `outro`, the tables.
    pub fn evaluation(self, title: &str, intro: &str, outro: &str) -> Evaluation {
        let (met, all) = self.aims;
        let broken: String = self.broken.iter().map(|why| format!("- failed: {why}\n")).collect();
        let head = format!("# {title}\n\n{intro} Aims met: {met} of {all}; missed ones are bold. {outro}\n{broken}");
        Evaluation { markdown: head + &self.text, runs: self.runs, broken: self.broken }
    }
}

/// A column: its heading, and the cell of a run.
pub type Column = (&'static str, fn(&Run) -> String);

/// A Markdown table with one line per run.
pub fn table(runs: &[Run], columns: &[Column]) -> String {
    let head: Vec<&str> = columns.iter().map(|c| c.0).collect();
    let rows: Vec<Vec<String>> = runs.iter().map(|r| columns.iter().map(|c| (c.1)(r)).collect()).collect();
    grid(&head, &rows)
}

/// A Markdown table of cells.
pub fn grid(head: &[&str], rows: &[Vec<String>]) -> String {
    let mut text = format!("| {} |\n|{}\n", head.join(" | "), "---|".repeat(head.len()));
    for row in rows {
        text.push_str(&format!("| {} |\n", row.join(" | ")));
    }
    text
}

/// A number with `digits` decimals, or a dash.
pub fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| "–".into(), |v| format!("{v:.digits$}"))
}

/// A whole number, or a dash.
pub fn count(value: &Value) -> String {
    value.as_i64().map_or_else(|| "–".into(), |v| v.to_string())
}

/// A string as it is, anything else as JSON.
pub fn text_of(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), String::from)
}

/// The columns that every table starts with.
pub const BASICS: [Column; 6] = [
    ("model", |r| r.job.model.clone()),
    ("run", |r| r.job.variant.clone()),
    ("exit", |r| r.exit.map_or("–".into(), |c| c.to_string())),
    ("seconds", |r| format!("{:.2}", r.seconds)),
    ("quads", |r| count(&r.judge["faces"])),
    ("verdict", verdict),
];

/// In a word what the judge and the exit code say.
pub fn verdict(run: &Run) -> String {
    match run.exit {
        Some(0 | 6) if run.is_good() => "good".into(),
        Some(0 | 6) if run.is_valid() => "**inverted**".into(),
        Some(0 | 6) => "**invalid**".into(),
        None => "**hung or killed**".into(),
        _ => "refused".into(),
    }
}

/// The columns about shape.
pub const SHAPE: [Column; 8] = [
    ("irregular", |r| count(&r.judge["irregular"])),
    ("SJ min", |r| number(r.judged("sj_min"), 3)),
    ("SJ mean", |r| number(r.judged("sj_mean"), 4)),
    ("inverted", |r| count(&r.judge["inverted"])),
    ("against", |r| count(&r.orientation["facing_against"])),
    ("angle", |r| number(r.judged("angle_mean"), 2)),
    ("distance max %", |r| number(r.judged("distance_max"), 3)),
    ("message", |r| r.message.replace('|', "/")),
];
