//! The evaluation of `quadloom tile`: numbers of tiles, re-gluing by a judge of its own, speed, lengths, pants, maps.
//!
//! In: models, the built command, generated surfaces that the crate's examples write and time. Out: one table per question.
//! Holds: every file that the command writes is judged by `xtask/scripts/reglue.py`, which shares no code with it; a
//! defect that it finds, and a run that fails, make the evaluation fail once its tables are written. Missed aims are bold.

use super::Settings;
use super::runner::python;
use super::table::{Evaluation, Sheet, number, text_of};
use crate::shell::root;
use serde_json::{Value, json};
use std::ffi::OsStr;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::Command;
use std::time::Instant;

/// Closed models, and what the paper's surfaces are replaced by.
const CLOSED: [&str; 9] =
    ["3holes", "double_torus", "kitten", "botijo", "pegaso", "casting", "turbine", "lattice_genus91", "cheese"];
const BORDERED: [&str; 6] = ["beetle", "camelhead", "punctured_torus", "roof", "disk_planar", "bunny"];
const WITH_PANTS: [&str; 6] = ["3holes", "double_torus", "botijo", "casting", "punctured_torus", "bunny"];

/// [Favreau2009] Table 1: genus, vertices, seconds of Algorithms 1, 2 and 3 for a single tile (0 where none is printed).
const PAPER: [(u64, u64, [f64; 3]); 14] = [
    (1, 768, [0.19, 0.0, 0.0]),
    (1, 3072, [0.99, 1.04, 1.04]),
    (1, 12288, [11.35, 12.0, 11.98]),
    (1, 49152, [154.99, 169.6, 168.43]),
    (2, 830, [0.26, 0.16, 0.27]),
    (2, 3326, [2.41, 1.6, 2.55]),
    (2, 13310, [31.71, 19.51, 32.96]),
    (2, 53246, [445.99, 299.78, 499.0]),
    (3, 1724, [0.89, 0.55, 0.96]),
    (3, 6908, [7.83, 4.22, 8.63]),
    (3, 27644, [83.9, 47.51, 96.84]),
    (4, 2202, [1.55, 1.22, 1.68]),
    (4, 8826, [12.8, 7.8, 14.59]),
    (4, 35322, [137.84, 91.43, 166.2]),
];

/// Most seconds of an exact single tile: genus, vertices, limit.
const EXACT_LIMITS: [(u64, u64, f64); 3] = [(1, 49152, 5.0), (2, 53246, 10.0), (4, 35322, 10.0)];

/// What the document is made of.
struct Bench<'a> {
    settings: &'a Settings,
    sheet: Sheet,
}

/// One run of the command and what the judge says.
struct Ran {
    seconds: f64,
    report: Value,
    judged: Value,
}

/// Makes all tables.
pub fn run(settings: &Settings) -> Result<Evaluation, String> {
    std::fs::create_dir_all(&settings.work).map_err(|e| format!("{}: {e}", settings.work.display()))?;
    let mut bench = Bench { settings, sheet: Sheet::default() };
    example("table", &["write", &settings.work.to_string_lossy()])?;
    bench.closed();
    bench.bordered();
    let rows = rows_of(&example("table", &[])?);
    bench.table_1(&rows)?;
    bench.many_holes();
    bench.lengths(&rows);
    bench.pants();
    bench.maps()?;
    bench.threads()?;
    let outro = "All files were glued again by `xtask/scripts/reglue.py`.";
    Ok(bench.sheet.evaluation("Tiles", "`quadloom tile`, one run at a time.", outro))
}

/// What an example of the crate prints.
fn example(name: &str, args: &[&str]) -> Result<String, String> {
    super::runner::example("quadloom-tiling", name, args)
}

fn rows_of(text: &str) -> Vec<Value> {
    text.lines().filter_map(|line| serde_json::from_str(line).ok()).collect()
}

impl Bench<'_> {
    /// The file of a model: a given one, or a generated one.
    fn input(&self, name: &str) -> Option<PathBuf> {
        let given = self.settings.shared.join("models/tri").join(format!("{name}.obj"));
        let made = self.settings.work.join(format!("{name}.obj"));
        [given, made].into_iter().find(|path| path.is_file()).filter(|_| self.settings.wants(name))
    }

    /// Runs the command on a model and has the judge look at what it wrote.
    fn tile(&mut self, name: &str, options: &str) -> Option<Ran> {
        let Some(input) = self.input(name) else {
            eprintln!("skipped: there is no model {name}");
            return None;
        };
        let file = |ending: &str| self.settings.work.join(format!("out.{ending}"));
        let (out, layout, report) = (file("obj"), file("layout.json"), file("report.json"));
        let start = Instant::now();
        let done = Command::new(&self.settings.binary)
            .arg("tile")
            .arg(&input)
            .args(options.split_whitespace())
            .arg("-o")
            .arg(&out)
            .arg("--layout")
            .arg(&layout)
            .arg("--report")
            .arg(&report)
            .args(["--quiet"])
            .output();
        let seconds = start.elapsed().as_secs_f64();
        let failed = match &done {
            Ok(output) if matches!(output.status.code(), Some(0 | 6)) => None,
            Ok(output) => Some(String::from_utf8_lossy(&output.stderr).trim().to_string()),
            Err(e) => Some(e.to_string()),
        };
        if let Some(why) = failed {
            self.sheet.broken.push(format!("{name} {options}: {why}"));
            return None;
        }
        let report = std::fs::read(&report).ok().and_then(|b| serde_json::from_slice(&b).ok()).unwrap_or(Value::Null);
        let script = root().join("xtask/scripts/reglue.py");
        let words: [&OsStr; 4] = [script.as_ref(), out.as_ref(), layout.as_ref(), input.as_ref()];
        let judged = python(&words);
        match (&judged["error"], judged["defects"].as_array()) {
            (Value::String(error), _) => self.sheet.broken.push(format!("{name} {options}: the judge fails: {error}")),
            (_, Some(defects)) if defects.is_empty() => {}
            _ => self.sheet.broken.push(format!("{name} {options}: {}", judged["defects"])),
        }
        self.sheet.runs.push(json!({
            "model": name, "options": options, "seconds": seconds, "tiles": report["tiles"], "length": report["length"],
            "multipoints": report["multipoints"], "report_seconds": report["seconds"],
            "peak_bytes": report["peak_memory_bytes"], "judged": judged,
        }));
        eprintln!("{name} {options}: {seconds:.3} s, {} tiles, defects {}", report["tiles"], judged["defects"]);
        Some(Ran { seconds, report, judged })
    }

    fn closed(&mut self) {
        let generated = (1..=4).flat_map(|genus| (0..4).map(move |level| format!("genus{genus}_level{level}")));
        let names: Vec<String> = CLOSED.iter().map(ToString::to_string).chain(generated).collect();
        let mut rows = Vec::new();
        for name in &names {
            let Some(quads) = self.tile(name, "--into quads") else { continue };
            let (genus, tiles) = (quads.report["genus"].as_i64().unwrap_or(0), quads.report["tiles"].as_i64());
            let part = &quads.report["components"][0];
            let polygon = part["polygon"].as_i64();
            let all_quads = quads.judged["sides"].as_array().is_some_and(|s| s.iter().all(|n| n.as_i64() == Some(4)));
            let mut cells = vec![name.clone(), genus.to_string()];
            cells.push(self.sheet.aim(polygon.unwrap_or(0).to_string(), polygon == Some(4 * genus)));
            cells.push(self.sheet.aim(text_of(&quads.report["multipoints"]), quads.report["multipoints"] == 1));
            cells.push(self.sheet.aim(tiles.unwrap_or(0).to_string(), tiles == Some(2 * genus - 1) && all_quads));
            cells.push(self.sheet.aim(number(Some(quads.seconds), 3), quads.seconds <= 3.0));
            cells.push(format!("{} → {}", quads.report["vertices"][0], quads.report["vertices"][1]));
            for method in ["shortest", "intermediate"] {
                let Some(disk) = self.tile(name, &format!("--into disk --method {method}")) else { continue };
                let sides = disk.report["sides"][0].as_i64().unwrap_or(1);
                cells.push(self.sheet.aim(sides.to_string(), sides % 2 == 0 && disk.report["tiles"] == 1));
            }
            rows.push(cells);
        }
        let head = [
            "model",
            "genus",
            "sides (4g)",
            "multipoints",
            "quadrangles (2g−1)",
            "seconds, whole command (≤ 3)",
            "vertices",
            "sides, Algorithm 1",
            "sides, Algorithm 3",
        ];
        self.sheet.section("Closed surfaces", "Fast search; quadrangles from Algorithm 2.", &head, &rows);
    }

    fn bordered(&mut self) {
        let mut rows = Vec::new();
        for name in BORDERED {
            for method in ["shortest", "intermediate"] {
                let Some(disk) = self.tile(name, &format!("--into disk --method {method}")) else { continue };
                let one = disk.report["tiles"] == 1 && disk.judged["chi"] == disk.judged["chi_of_surface"];
                let mut cells = vec![name.to_string(), method.to_string(), text_of(&disk.report["boundary_loops"])];
                cells.push(self.sheet.aim(text_of(&disk.report["sides"][0]), one));
                let Some(quads) = self.tile(name, &format!("--into quads --method {method}")) else { continue };
                let four = quads.judged["sides"].as_array().is_some_and(|s| s.iter().all(|n| n.as_i64() == Some(4)));
                cells.push(text_of(&quads.report["components"][0]["quadrangles"]["added_nodes"]));
                cells.push(self.sheet.aim(text_of(&quads.report["tiles"]), four));
                cells.push(number(Some(quads.seconds), 3));
                rows.push(cells);
            }
        }
        let head = [
            "model",
            "method",
            "boundary loops",
            "sides of the disk",
            "nodes added",
            "quadrangles",
            "seconds, quadrangles",
        ];
        self.sheet.section("Surfaces with boundary", "Fast search.", &head, &rows);
    }

    /// [Favreau2009] Table 1, with a plot.
    fn table_1(&mut self, rows: &[Value]) -> Result<(), String> {
        let mut table = Vec::new();
        for (genus, vertices, paper) in PAPER {
            for (k, method) in ["shortest", "single-point", "intermediate"].into_iter().enumerate() {
                let find = |search: &str| {
                    rows.iter().find(|r| {
                        r["genus"] == genus
                            && r["vertices"] == vertices
                            && r["method"] == method
                            && r["search"] == search
                    })
                };
                let (Some(exact), Some(fast)) = (find("exact"), find("fast")) else { continue };
                let seconds = |row: &Value, what: &str| row[what].as_f64().unwrap_or(f64::INFINITY);
                let single = seconds(exact, "single_s");
                let limit = EXACT_LIMITS.iter().find(|l| (l.0, l.1) == (genus, vertices)).map(|l| l.2);
                let single_cell = match limit {
                    Some(limit) => self.sheet.aim(number(Some(single), 3), single <= limit),
                    None => number(Some(single), 3),
                };
                let quick = seconds(fast, "single_s") + seconds(fast, "quads_s");
                let quick_cell = self.sheet.aim(number(Some(quick), 3), quick <= 0.3);
                let defects = [exact, fast].iter().any(|r| r["defects"] != 0);
                if defects {
                    self.sheet
                        .broken
                        .push(format!("genus {genus}, {vertices} vertices, {method}: a tiling has defects"));
                }
                table.push(vec![
                    genus.to_string(),
                    vertices.to_string(),
                    method.into(),
                    if paper[k] > 0.0 { number(Some(paper[k]), 2) } else { "–".into() },
                    single_cell,
                    number(Some(seconds(exact, "quads_s")), 3),
                    quick_cell,
                ]);
            }
        }
        self.sheet.runs.extend(rows.iter().cloned());
        let head = [
            "genus",
            "vertices",
            "method",
            "paper, single tile",
            "exact, single tile",
            "exact, quadrangles",
            "fast, both (≤ 0.3)",
        ];
        let text = "Seconds, best of three. Aims of the exact search: 5 s at genus 1 with 49,152 vertices, 10 s at genus 2 \
                    with 53,246 and genus 4 with 35,322. Surfaces of the same genus and number of vertices are generated. \
                    ![Seconds against vertices](tiling.svg)";
        self.sheet.section("Table 1", text, &head, &table);
        let path = root().join("docs/results/tiling.svg");
        if self.settings.only.is_empty() {
            std::fs::write(&path, plot(rows)).map_err(|e| format!("{}: {e}", path.display()))?;
        }
        Ok(())
    }

    fn many_holes(&mut self) {
        let mut rows = Vec::new();
        for vertices in [31_250, 125_000, 500_000] {
            let Some(ran) = self.tile(&format!("holes100_{vertices}"), "--into quads") else { continue };
            let megabytes = ran.report["peak_memory_bytes"].as_f64().map_or(f64::INFINITY, |b| b / 1e6);
            let is_largest = vertices == 500_000;
            let tiles = self.sheet.aim(text_of(&ran.report["tiles"]), ran.report["tiles"] == 199);
            let seconds = self.sheet.aim(number(Some(ran.seconds), 2), !is_largest || ran.seconds <= 10.0);
            let memory = self.sheet.aim(number(Some(megabytes), 0), !is_largest || megabytes <= 3000.0);
            let cutting = number(ran.report["seconds"]["cutting"].as_f64(), 2);
            rows.push(vec![vertices.to_string(), tiles, cutting, seconds, memory]);
        }
        let head = ["vertices", "quadrangles (199)", "seconds, cutting", "seconds, whole command", "MB"];
        let text = "A plate with 100 holes; aims at 500,000 vertices: 10 s and 3 GB.";
        self.sheet.section("Genus 100", text, &head, &rows);
    }

    /// [Favreau2009] Figures 16 and 17.
    fn lengths(&mut self, rows: &[Value]) {
        let mut table = Vec::new();
        let mut first_loops = (f64::INFINITY, f64::INFINITY);
        for row in rows.iter().filter(|r| r["vertices"] == 830) {
            let limit = match row["method"].as_str() {
                Some("shortest") => 8,
                Some("single-point") => 3,
                _ => 4,
            };
            let quads = row["quadrangles"].as_i64().unwrap_or(i64::MAX);
            let first = row["first_loop"].as_f64().unwrap_or(f64::INFINITY);
            let side = if row["search"] == "exact" { &mut first_loops.0 } else { &mut first_loops.1 };
            *side = side.min(first);
            let count = self.sheet.aim(quads.to_string(), quads <= limit);
            let length = |what: &str| number(row[what].as_f64(), 4);
            table.push(vec![
                text_of(&row["method"]),
                text_of(&row["search"]),
                text_of(&row["sides"]),
                length("first_loop"),
                length("length"),
                count,
                length("greedy_diagonals"),
                length("optimal_diagonals"),
                length("quads_length"),
            ]);
        }
        let never_longer = self.sheet.aim("is not longer", first_loops.0 <= first_loops.1);
        let text = format!(
            "Genus 2, 830 vertices. Limits on quadrangles: 6g − 4 = 8, 2g − 1 = 3, 3g − 2 = 4. The first loop of the exact \
             search {never_longer} than that of the fast one."
        );
        let head = [
            "method",
            "search",
            "sides",
            "first loop",
            "length, single tile",
            "quadrangles",
            "greedy diagonals",
            "optimal diagonals",
            "length, quadrangles",
        ];
        self.sheet.section("Lengths", &text, &head, &table);
    }

    fn pants(&mut self) {
        let mut rows = Vec::new();
        for name in WITH_PANTS {
            for search in ["fast", "exact"] {
                let Some(pants) = self.tile(name, &format!("--into pants --search {search}")) else { continue };
                let chi = pants.report["chi"].as_i64().unwrap_or(0);
                let mut cells = vec![name.to_string(), search.to_string(), chi.to_string()];
                cells.push(self.sheet.aim(text_of(&pants.report["tiles"]), pants.report["tiles"] == -chi));
                cells.push(number(pants.report["length"].as_f64(), 4));
                cells.push(number(Some(pants.seconds), 3));
                let Some(belts) = self.tile(name, &format!("--into cylinders --search {search}")) else { continue };
                cells.push(self.sheet.aim(text_of(&belts.report["tiles"]), belts.report["tiles"] == -3 * chi));
                cells.push(number(Some(belts.seconds), 3));
                rows.push(cells);
            }
        }
        let head = ["model", "search", "χ", "pants (−χ)", "length", "seconds", "cylinders (−3χ)", "seconds"];
        let text = "The judge finds genus 0 and three or two boundaries for each.";
        self.sheet.section("Pants and cylinders", text, &head, &rows);
    }

    /// Maps of tiles: folds of every tile of every closed model, angles on known shapes.
    fn maps(&mut self) -> Result<(), String> {
        let mut rows = Vec::new();
        for name in CLOSED {
            let Some(ran) = self.tile(name, "--into quads --parametrize fixed") else { continue };
            let maps = ran.report["components"][0]["maps"].as_array().cloned().unwrap_or_default();
            let rounds = maps.iter().filter_map(|m| m["rounds"].as_i64()).max().unwrap_or(0);
            let folds = ran.judged["defects"].to_string().contains("folded");
            let mapped = ran.judged["mapped"] == ran.judged["faces"];
            let fine = self.sheet.aim(if folds { "folds" } else { "none" }, mapped && !folds);
            rows.push(vec![
                name.to_string(),
                maps.len().to_string(),
                fine,
                rounds.to_string(),
                number(ran.report["seconds"]["maps"].as_f64(), 3),
            ]);
        }
        let head = ["model", "tiles", "folds (exact test of the file)", "rounds of re-weighting", "seconds"];
        self.sheet.section(
            "Mean value maps",
            "Every quadrangle of every closed model, to the unit square.",
            &head,
            &rows,
        );
        let shapes = rows_of(&example("flatten_table", &[])?);
        let row = |r: &Value| {
            vec![
                text_of(&r["shape"]),
                text_of(&r["faces"]),
                text_of(&r["method"]),
                r["angle_mean_degrees"].as_f64().map_or(String::new(), |d| format!("{d:.1e}")),
                r["angle_largest_degrees"].as_f64().map_or(String::new(), |d| format!("{d:.1e}")),
                number(r["area_mean"].as_f64(), 3),
            ]
        };
        let table: Vec<Vec<String>> = shapes.iter().map(row).collect();
        self.sheet.runs.extend(shapes);
        let head = ["shape", "faces", "method", "angle error, mean, degrees", "largest", "area factor, mean"];
        let text = "Corners of the plane against corners of the surface. A conformal map of a smooth shape has none in the \
                    limit, but for the corners at a cone's tip; touching circles know nothing of the triangles' shapes.";
        self.sheet.section("Free borders on known shapes", text, &head, &table);
        Ok(())
    }

    fn threads(&mut self) -> Result<(), String> {
        let mut rows = Vec::new();
        for name in ["botijo", "cheese"] {
            let mut files: Vec<[Vec<u8>; 2]> = Vec::new();
            for threads in [1, 2] {
                if self.tile(name, &format!("--into quads --parametrize fixed --threads {threads}")).is_none() {
                    continue;
                }
                let read = |ending: &str| std::fs::read(self.settings.work.join(format!("out.{ending}")));
                let both = [read("obj"), read("layout.json")].map(|r| r.map_err(|e| e.to_string()));
                let [mesh, layout] = both;
                files.push([mesh?, layout?]);
            }
            if let [one, two] = &files[..] {
                let same = self.sheet.aim(if one == two { "the same bytes" } else { "differ" }, one == two);
                rows.push(vec![name.to_string(), same]);
            }
        }
        self.sheet.section(
            "Threads",
            "Mesh with maps, and layout, for one and two threads.",
            &["model", "files"],
            &rows,
        );
        Ok(())
    }
}

/// Seconds of single tiles against vertices, both in powers of ten, as SVG: Algorithm 1, exact and fast, and the paper's.
fn plot(rows: &[Value]) -> String {
    const COLOURS: [&str; 4] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7"];
    let (width, height, left, bottom) = (760.0, 480.0, 70.0, 50.0);
    let x = |n: f64| left + (n.log10() - 2.7) / (5.2 - 2.7) * (width - left - 170.0);
    let y = |s: f64| 20.0 + (3.0 - s.max(1e-4).log10()) / 7.0 * (height - bottom - 20.0);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" \
         font-size=\"13\">\n<rect width=\"{width}\" height=\"{height}\" fill=\"white\"/>\n"
    );
    for power in -4..=3 {
        let at = y(10f64.powi(power));
        let _ = writeln!(
            svg,
            "<line x1=\"{left}\" x2=\"{}\" y1=\"{at:.1}\" y2=\"{at:.1}\" stroke=\"#ddd\"/><text x=\"{}\" y=\"{:.1}\" \
             text-anchor=\"end\">10{}</text>",
            width - 170.0,
            left - 8.0,
            at + 4.0,
            superscript(power)
        );
    }
    for power in 3..=5 {
        let at = x(10f64.powi(power));
        let _ = writeln!(
            svg,
            "<line x1=\"{at:.1}\" x2=\"{at:.1}\" y1=\"20\" y2=\"{}\" stroke=\"#ddd\"/><text x=\"{at:.1}\" y=\"{}\" \
             text-anchor=\"middle\">10{}</text>",
            height - bottom,
            height - bottom + 18.0,
            superscript(power)
        );
    }
    let mut line = |points: &[(f64, f64)], colour: &str, dash: &str| {
        let path: Vec<String> = points.iter().map(|&(n, s)| format!("{:.1},{:.1}", x(n), y(s))).collect();
        let _ = writeln!(
            svg,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\" stroke-dasharray=\"{dash}\"/>",
            path.join(" ")
        );
        for &(n, s) in points {
            let _ = writeln!(svg, "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"3\" fill=\"{colour}\"/>", x(n), y(s));
        }
    };
    for genus in 1..=4u64 {
        let colour = COLOURS[genus as usize - 1];
        let paper: Vec<(f64, f64)> = PAPER.iter().filter(|p| p.0 == genus).map(|p| (p.1 as f64, p.2[0])).collect();
        line(&paper, colour, "2 5");
        for (search, dash) in [("exact", ""), ("fast", "8 4")] {
            let of = |r: &&Value| r["genus"] == genus && r["search"] == search && r["method"] == "shortest";
            let points: Vec<(f64, f64)> = rows
                .iter()
                .filter(of)
                .filter_map(|r| Some((r["vertices"].as_f64()?, r["single_s"].as_f64()?)))
                .collect();
            line(&points, colour, dash);
        }
    }
    for (k, colour) in COLOURS.iter().enumerate() {
        let at = 40.0 + 22.0 * k as f64;
        let _ = writeln!(
            svg,
            "<rect x=\"{}\" y=\"{}\" width=\"12\" height=\"12\" fill=\"{colour}\"/><text x=\"{}\" y=\"{}\">genus {}</text>",
            width - 155.0,
            at - 10.0,
            width - 137.0,
            at,
            k + 1
        );
    }
    for (k, (dash, name)) in [("2 5", "paper"), ("", "exact search"), ("8 4", "fast search")].into_iter().enumerate() {
        let at = 146.0 + 22.0 * k as f64;
        let _ = writeln!(
            svg,
            "<line x1=\"{}\" x2=\"{}\" y1=\"{at}\" y2=\"{at}\" stroke=\"black\" stroke-width=\"2\" \
             stroke-dasharray=\"{dash}\"/><text x=\"{}\" y=\"{}\">{name}</text>",
            width - 155.0,
            width - 120.0,
            width - 112.0,
            at + 4.0
        );
    }
    let _ = writeln!(
        svg,
        "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">vertices</text><text x=\"18\" y=\"{}\" \
         transform=\"rotate(-90 18 {})\" text-anchor=\"middle\">seconds, single tile, Algorithm 1</text>\n</svg>",
        left + 250.0,
        height - 8.0,
        height / 2.0,
        height / 2.0
    );
    svg
}

/// A power as superscript digits.
fn superscript(power: i32) -> String {
    let digit = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        c => char::from_u32('⁰' as u32 + c as u32 - '0' as u32).unwrap_or(c),
    };
    power.to_string().chars().map(digit).collect()
}
