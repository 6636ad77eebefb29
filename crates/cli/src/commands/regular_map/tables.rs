//! Verbs of `quadloom regular-map` that print tables or JSON.

use super::spec;
use crate::commands::{done, use_threads};
use crate::console::Console;
use crate::map_args::{InfoArgs, ListArgs, MatchArgs, SearchArgs};
use crate::watchdog;
use quadloom::RemeshError;
use quadloom::io::IoError;
use quadloom::regular_map::{self as maps, ChiralReport, MapReport, MatchReport};
use quadloom::regular_maps::Pole;
use quadloom::regular_maps::catalogue::COMPLETE;
use serde::Serialize;
use std::io::{ErrorKind, Write};
use std::ops::RangeInclusive;
use std::process::ExitCode;

/// Lists maps.
pub fn list(args: &ListArgs) -> Result<ExitCode, RemeshError> {
    let found = maps::list(args.genus.clone(), args.kind)?;
    note_gaps(args.genus.as_ref());
    print(if args.json { json(&found) } else { map_table(&found) })
}

/// Says where a list is not all there is.
fn note_gaps(genera: Option<&RangeInclusive<usize>>) {
    let Some(genera) = genera else { return };
    if genera.start() < COMPLETE.start() {
        eprintln!("note: lists begin at genus 2; maps on the sphere and the torus go by names (cube, {{4,4}}_(3,0))");
    }
    if genera.end() > COMPLETE.end() {
        let (start, end) = (COMPLETE.start(), COMPLETE.end());
        eprintln!("note: the list is complete for genus {start} to {end}; `quadloom regular-map search` goes on");
    }
}

/// Prints what is known about a map.
pub fn info(args: &InfoArgs) -> Result<ExitCode, RemeshError> {
    let facts = maps::info(&maps::find_map(&spec(&args.source))?);
    let row = |(name, value): (&str, String)| format!("{name:>24}  {value}\n");
    print(if args.json { json(&facts) } else { facts.rows().into_iter().map(row).collect() })
}

/// Lists the targets of a map.
pub fn find(args: &MatchArgs) -> Result<ExitCode, RemeshError> {
    let source = maps::find_map(&spec(&args.source))?;
    let found = maps::matches(&source)?;
    if found.is_empty() {
        eprintln!(
            "note: {} matches no tube surface; its own edges can be tubes (`quadloom regular-map tubify`), and it can be drawn \
             flat (`quadloom regular-map tile`)",
            source.name
        );
    }
    print(if args.json { json(&found) } else { match_table(&found) })
}

/// Searches maps.
pub fn search(args: &SearchArgs) -> Result<ExitCode, RemeshError> {
    let fewer = use_threads(args.run.threads);
    let progress = watchdog::start(args.run.time_limit);
    let (console, progress) = Console::new(&args.run, progress);
    fewer.iter().for_each(|note| console.note(note));
    let genera = args.genus.clone();
    let text = if args.chiral {
        let found = maps::search_chiral(genera, args.kind, &progress)?;
        if args.json { json(&found) } else { chiral_table(&found) }
    } else {
        let found = maps::search(genera, args.kind, &progress)?;
        if args.json { json(&found) } else { map_table(&found) }
    };
    drop(console);
    print(text)
}

fn map_table(found: &[MapReport]) -> String {
    let row = |map: &MapReport| {
        let name = if map.name == map.identifier { "" } else { &map.name };
        let MapReport { identifier, genus, order, vertices, edges, faces, .. } = map;
        format!("{name:<10} {identifier:<18} {genus:>6} {order:>6} {vertices:>6} {edges:>6} {faces:>6}\n")
    };
    let head =
        format!("{:<10} {:<18} {:>6} {:>6} {:>6} {:>6} {:>6}\n", "name", "identifier", "genus", "order", "V", "E", "F");
    head + &found.iter().map(row).collect::<String>() + &count(found.len())
}

fn chiral_table(found: &[ChiralReport]) -> String {
    let row = |map: &ChiralReport| {
        let ChiralReport { p, q, genus, rotations, vertices, edges, faces, presentation } = map;
        let kind = format!("{{{p},{q}}}");
        format!("{kind:<10} {genus:>6} {rotations:>9} {vertices:>6} {edges:>6} {faces:>6}  {presentation}\n")
    };
    let head = format!("{:<10} {:>6} {:>9} {:>6} {:>6} {:>6}  group\n", "type", "genus", "rotations", "V", "E", "F");
    head + &found.iter().map(row).collect::<String>() + &count(found.len())
}

fn count(maps: usize) -> String {
    if maps == 1 { "1 map\n".into() } else { format!("{maps} maps\n") }
}

fn match_table(found: &[MatchReport]) -> String {
    let row = |m: &MatchReport| {
        let kind = format!("{{{},{}}}_{}", m.target.p, m.target.q, m.target.petrie);
        let pole = match m.pole {
            Pole::Face => "face",
            Pole::Vertex => "vertex",
        };
        let twist = if m.twisted { ", half-twisted tubes" } else { "" };
        format!(
            "{:<20} {kind:<12} {:>6} {:>9} {:>7} {:>6}  {pole}{twist}\n",
            m.target.name, m.index, m.junctions, m.valence, m.tubes
        )
    };
    let head = format!(
        "{:<20} {:<12} {:>6} {:>9} {:>7} {:>6}  pole\n",
        "target", "type", "index", "junctions", "valence", "tubes"
    );
    head + &found.iter().map(row).collect::<String>()
}

fn json<T: Serialize + ?Sized>(value: &T) -> String {
    serde_json::to_string_pretty(value).unwrap_or_default() + "\n"
}

/// Prints to stdout; a reader that has seen enough may close its end.
fn print(text: String) -> Result<ExitCode, RemeshError> {
    match std::io::stdout().lock().write_all(text.as_bytes()) {
        Err(source) if source.kind() != ErrorKind::BrokenPipe => {
            Err(IoError::Unwritable { path: "stdout".into(), source }.into())
        }
        _ => done(),
    }
}
