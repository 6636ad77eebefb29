//! The evaluation of `quadloom regular-map`: counts, groups, matchings, surfaces with maps on them, solids, threads.
//!
//! In: the built command, the tables of `../shared/research/regular-maps` where they are there. Out: one table per question.
//! Holds: surfaces are judged as maps by `xtask/scripts/drawn_map.py` and as solids by `xtask/scripts/solid.py`, which share
//! no code with the command. Missed aims are bold; a command that fails where no aim counts it fails the evaluation.
//! `--only` takes parts: counts, orders, matchings, realize, large, tubify, solids, page, threads.

mod tools;

use super::Settings;
use super::runner::example;
use super::table::{Evaluation, Sheet, number, text_of};
use crate::shell::root;
use serde_json::{Value, json};
use std::process::Command;
use std::time::Instant;
use tools::{Bench, Made, Named, Open3d, by_open3d, is_clean, said};

/// Maps per genus from 2 on, up to duality: the published count.
const COUNTS: [usize; 23] = [6, 12, 12, 16, 13, 12, 11, 32, 24, 14, 11, 22, 12, 23, 17, 40, 14, 35, 13, 40, 18, 11, 17];

/// Sources with a target that is asked for (or the command's choice), and the rotations that the surface must have.
const SURFACES: [(&str, &str, &str); 13] = [
    ("R3.1", "", "T"),
    ("R3.2", "", ""),
    ("R3.4", "", ""),
    ("R5.1", "", ""),
    ("R5.4", "", "O"),
    ("R4.3", "", ""),
    ("R5.3", "", ""),
    ("R5.8", "R2.4", ""),
    ("R9.3′", "R2.1′", ""),
    ("R11.1", "", "I"),
    ("R13.2′", "R3.4′", ""),
    ("R19.3", "", ""),
    ("R21.3′", "R5.2′", ""),
];

/// [Razafindrazaka2015] §9.6: source, target, junctions.
const PAIRS: [(&str, &str, u64); 5] = [
    ("R3.1", "tetrahedron", 4),
    ("R5.8", "R2.4", 1),
    ("R9.3′", "R2.1′", 16),
    ("R13.2′", "R3.4′", 12),
    ("R21.3′", "R5.2′", 40),
];

/// Genus and junctions of [Razafindrazaka2015] Fig. 9.21.
const LARGE: [(u64, u64); 3] = [(41, 80), (61, 120), (85, 84)];

const TARGETLESS: [&str; 11] =
    ["R2.1", "R2.2", "R2.3", "R2.4", "R2.5", "R2.6", "R3.1", "R3.2", "R3.3", "R3.4", "R2.1′"];

/// Most seconds of the command for one surface.
const MOST_SECONDS: f64 = 60.0;

/// Makes all tables.
pub fn run(settings: &Settings) -> Result<Evaluation, String> {
    let mut bench = Bench { settings, sheet: Sheet::default() };
    if bench.wants("counts") {
        bench.counts();
    }
    if bench.wants("orders") {
        bench.orders()?;
    }
    if bench.wants("matchings") {
        bench.matchings()?;
    }
    if bench.wants("realize") {
        bench.surfaces();
    }
    if bench.wants("large") {
        bench.large();
    }
    if bench.wants("tubify") {
        bench.targetless();
    }
    if bench.wants("solids") {
        bench.solids();
    }
    if bench.wants("page") {
        bench.page();
    }
    if bench.wants("threads") {
        bench.threads();
    }
    let outro = "Maps are judged by `xtask/scripts/drawn_map.py` from the file alone: a closed manifold, every face one disk, \
                 V, E, F, p, q and Petrie length those of the source, and automorphisms that make it regular. Solids are \
                 judged by `xtask/scripts/solid.py`: trimesh, open3d, own counts. Seconds are those of the whole command.";
    Ok(bench.sheet.evaluation("Regular maps", "`quadloom regular-map`, one run at a time.", outro))
}

fn numbers(map: &Value) -> Vec<String> {
    let keys = ["genus", "p", "q", "petrie", "order", "vertices", "edges", "faces"];
    let of_both = [&map["multiplicities"][0], &map["multiplicities"][1], &map["self_dual"]];
    keys.iter().map(|k| &map[*k]).chain(of_both).map(text_of).collect()
}

impl Bench<'_> {
    /// Line 1 of the aims: searches, and the list row by row.
    fn counts(&mut self) {
        let mut rows = Vec::new();
        for (last, most) in [(15, Some(20.0)), (24, None)] {
            let begin = Instant::now();
            let found = self.ask(&["search", "--genus", &format!("2..{last}"), "--threads", "1", "--json"]);
            let seconds = begin.elapsed().as_secs_f64();
            let found = found.as_array().cloned().unwrap_or_default();
            let counts: Vec<usize> =
                (2..=last).map(|genus| found.iter().filter(|m| m["genus"] == genus).count()).collect();
            let text = counts.iter().map(usize::to_string).collect::<Vec<_>>().join(" ");
            rows.push(vec![
                format!("2 to {last}"),
                found.len().to_string(),
                self.sheet.aim(text, counts == COUNTS[..counts.len()]),
                match most {
                    Some(most) => self.sheet.aim(format!("{seconds:.2} (≤ {most:.0})"), seconds <= most),
                    None => format!("{seconds:.2}"),
                },
            ]);
            self.sheet.runs.push(json!({ "part": "counts", "last": last, "counts": counts, "seconds": seconds }));
        }
        let head = ["genus", "maps", "per genus, up to duality", "seconds, one thread"];
        self.sheet.section("Enumeration", "`search`, single thread.", &head, &rows);
        self.rows_of_the_list();
    }

    fn rows_of_the_list(&mut self) {
        let Some(table) = self.oracle("regular_maps_g02_24.tsv") else { return };
        let list = self.ask(&["list", "--genus", "2..24", "--json"]).as_array().cloned().unwrap_or_default();
        let mut wanted: Vec<Vec<String>> = table.iter().map(|r| r[3..14].to_vec()).collect();
        let mut found: Vec<Vec<String>> = list.iter().map(numbers).collect();
        let named = table.iter().filter(|row| !row[1].contains('|'));
        let agree = |row: &&Vec<String>| list.iter().any(|m| m["name"] == *row[1] && numbers(m) == row[3..14]);
        let (names, same_names) = (named.clone().count(), named.filter(agree).count());
        wanted.sort();
        found.sort();
        let same = wanted.iter().filter(|row| found.binary_search(row).is_ok()).count();
        let whole = self.sheet.aim(format!("{same} of {}", wanted.len()), found == wanted);
        self.sheet.text.push_str(&format!(
            "\nRows of `list` that agree with the table in genus, type, Petrie length, order, V, E, F, multiplicities and \
             self-duality: {whole}. Names that the table calls certain, on the same row: {same_names} of {names}.\n"
        ));
        self.sheet.runs.push(json!({
            "part": "list", "rows": wanted.len(), "same": same, "names": names, "same_names": same_names,
        }));
    }

    /// Line 2: coset enumeration.
    fn orders(&mut self) -> Result<(), String> {
        if self.oracle("large_maps.tsv").is_none() {
            return Ok(());
        }
        let measured = self.example("orders")?;
        let mut rows = Vec::new();
        for (table, most) in [("listed", 0.5), ("large", 0.5)] {
            let part = &measured[table];
            let (count, wrong) = (part["presentations"].as_u64().unwrap_or(0), part["wrong"].as_array().map(Vec::len));
            let seconds = part["seconds"].as_f64().unwrap_or(f64::INFINITY);
            let right = count - wrong.unwrap_or(0) as u64;
            rows.push(vec![
                table.to_string(),
                count.to_string(),
                self.sheet.aim(right.to_string(), wrong == Some(0) && count >= 4),
                self.sheet.aim(format!("{seconds:.3} (≤ {most})"), seconds <= most),
            ]);
        }
        self.sheet.runs.push(json!({ "part": "orders", "measured": measured }));
        let head = ["table", "presentations", "of the stated order", "seconds together, best of three"];
        self.sheet.section("Coset enumeration", "Over the trivial subgroup, in one process.", &head, &rows);
        Ok(())
    }

    fn example(&self, name: &str) -> Result<Value, String> {
        let folder = self.settings.shared.join("research/regular-maps");
        let text = example("quadloom-regular-maps", name, &[&folder.to_string_lossy()])?;
        serde_json::from_str(&text).map_err(|e| format!("example {name}: {e}"))
    }

    /// Line 3: matchings of the tables, the thesis' pairs, the large maps.
    fn matchings(&mut self) -> Result<(), String> {
        let Some(large) = self.oracle("large_maps.tsv") else { return Ok(()) };
        let found = self.example("matchings")?;
        let missing = |key: &str| found[key].as_array().is_some_and(Vec::is_empty);
        let seconds = found["seconds"].as_f64().unwrap_or(f64::INFINITY);
        let both = |key: &str| format!("{} ({} listed)", found[key]["found"], found[key]["listed"]);
        let row = vec![
            text_of(&found["maps"]),
            self.sheet.aim(both("sources"), missing("lost")),
            self.sheet.aim(both("pairs"), missing("missing")),
            self.sheet.aim(format!("{seconds:.2} (≤ 3)"), seconds <= 3.0),
        ];
        let head = ["maps", "with a match", "pairs", "seconds together, best of three"];
        let text = "Every listed pair is looked for by pole, target, index, junctions, tubes and sides.";
        self.sheet.section("Matchings", text, &head, &[row]);
        self.sheet.runs.push(json!({ "part": "matchings", "measured": found }));
        let mut rows = Vec::new();
        for (source, target, junctions) in PAIRS {
            rows.push(self.pair(&Named::of(source), &format!("on {target}"), junctions, |m| m["name"] == target));
        }
        for row in &large {
            let genus: u64 = row[0].parse().unwrap_or(0);
            let junctions = LARGE.iter().find(|l| l.0 == genus).map_or(24, |l| l.1);
            let is_wanted = |m: &Value| genus != 37 || (m["p"] == 6 && m["q"] == 5 && m["petrie"] == 10);
            let text = if genus == 37 { "on {6,5}_10" } else { "on any" };
            rows.push(self.pair(&large_map(row), text, junctions, is_wanted));
        }
        let head = ["source", "asked for", "junctions", "found"];
        self.sheet.section("Pairs of the thesis", "By `match`.", &head, &rows);
        Ok(())
    }

    fn pair(&mut self, map: &Named, asked: &str, junctions: u64, is_wanted: impl Fn(&Value) -> bool) -> Vec<String> {
        let matches = self.matches(map);
        let found = matches.iter().find(|m| is_wanted(&m["target"]) && m["junctions"] == junctions);
        let text = match found {
            Some(m) => format!("{}, index {}, {} tubes", text_of(&m["target"]["name"]), m["index"], m["tubes"]),
            None => "nothing".into(),
        };
        self.sheet.runs.push(json!({ "part": "pair", "source": map.name, "matches": matches }));
        vec![map.name.clone(), asked.into(), junctions.to_string(), self.sheet.aim(text, found.is_some())]
    }

    /// Line 4: realised maps.
    fn surfaces(&mut self) {
        let mut rows = Vec::new();
        for (name, target, group) in SURFACES {
            rows.push(self.surface(&Named::of(name), target, group));
        }
        if let Some(large) = self.oracle("large_maps.tsv")
            && let Some(row) = large.iter().find(|row| row[0] == "37")
        {
            rows.push(self.surface(&large_map(row), "{6,5}_10", ""));
        }
        let text = "Drawn without edges as OBJ. Maps on the tubes of a target that is asked for, or of the command's choice. \
                    open3d looks at pairs of triangles without a common vertex; where there are more than 120,000 triangles \
                    it is not asked.";
        self.sheet.section("Maps in space", text, &SURFACE_HEAD, &rows);
        let mut rows = Vec::new();
        for genus in 2..=15 {
            match self.first_matched(genus) {
                Some(name) => rows.push(self.surface(&Named::of(&name), "", "")),
                None => self.sheet.broken.push(format!("no map of genus {genus} has a match")),
            }
        }
        self.sheet.section("The first matched map of each genus", "In the order of `list`.", &SURFACE_HEAD, &rows);
    }

    fn first_matched(&mut self, genus: usize) -> Option<String> {
        let list = self.ask(&["list", "--genus", &genus.to_string(), "--json"]);
        let maps = list.as_array().cloned().unwrap_or_default();
        let named = maps.iter().find(|m| !self.matches(&Named::of(&text_of(&m["identifier"]))).is_empty())?;
        Some(text_of(&named["name"]))
    }

    fn surface(&mut self, map: &Named, target: &str, group: &str) -> Vec<String> {
        let on = if target.is_empty() { String::new() } else { format!("--on {target}") };
        let made = self.make("realize", map, "obj", &format!("--edges none {on}"));
        if !made.is_written() {
            self.record("realize", map, &made, Value::Null);
            let mut row = vec![map.name.clone(), self.sheet.aim(made.message.clone(), false)];
            row.resize(SURFACE_HEAD.len(), "–".into());
            return row;
        }
        let (report, drawn) = (&made.report, self.judge_map(&made));
        let solid = self.judge_solid(&made, &report["source"]["genus"], Open3d::WhereQuick);
        let symmetry = text_of(&report["surface_of"]["symmetry"]["group"]);
        let own = counts_agree(&made);
        let crossings = &report["surface"]["self_intersections"];
        let row = vec![
            map.name.clone(),
            text_of(&report["surface_of"]["target"]["name"]),
            format!("{} / {}", report["surface_of"]["junctions"], report["surface_of"]["tubes"]),
            text_of(&report["surface_of"]["skeleton"]),
            if group.is_empty() {
                symmetry
            } else {
                self.sheet.aim(format!("{symmetry} ({group})"), symmetry == group)
            },
            text_of(&report["surface"]["faces"]),
            self.sheet.aim(text_of(crossings), *crossings == 0),
            self.sheet.aim(if own { "agrees" } else { "differs" }, own),
            self.sheet.aim(said(&drawn), is_clean(&drawn)),
            self.sheet.aim(said(&solid), is_clean(&solid)),
            by_open3d(&solid),
            self.sheet.aim(made.seconds_text(), made.seconds <= MOST_SECONDS),
        ];
        self.record("realize", map, &made, json!({ "map": drawn, "solid": solid }));
        row
    }

    /// Line 5: the large maps, which may intersect themselves.
    fn large(&mut self) {
        let Some(table) = self.oracle("large_maps.tsv") else { return };
        let (mut rows, mut free) = (Vec::new(), 0);
        for (genus, junctions) in LARGE {
            let Some(row) = table.iter().find(|row| row[0] == genus.to_string()) else { continue };
            let map = large_map(row);
            let matches = self.matches(&map);
            let Some(target) = matches.iter().find(|m| m["junctions"] == junctions) else {
                let mut row = vec![map.name.clone(), self.sheet.aim("no match", false)];
                row.resize(LARGE_HEAD.len(), "–".into());
                rows.push(row);
                continue;
            };
            let on = text_of(&target["target"]["identifier"]);
            let made = self.make("realize", &map, "obj", &format!("--edges none --allow-intersections --on {on}"));
            let drawn = if made.is_written() { self.judge_map(&made) } else { Value::Null };
            let solid = if made.is_written() {
                self.judge_solid(&made, &made.report["source"]["genus"], Open3d::WhereQuick)
            } else {
                Value::Null
            };
            let report = &made.report;
            let own = made.is_written() && counts_agree(&made);
            let closed = solid["watertight"] == true && solid["genus"] == genus;
            free += u32::from(made.exit == Some(0) && report["surface"]["self_intersections"] == 0);
            rows.push(vec![
                map.name.clone(),
                text_of(&target["target"]["name"]),
                format!("{junctions} / {}", target["tubes"]),
                text_of(&report["surface_of"]["symmetry"]["group"]),
                text_of(&report["surface"]["faces"]),
                self.sheet.aim(if closed { "holds" } else { "fails" }, closed),
                self.sheet.aim(if own { "agrees" } else { "differs" }, own),
                self.sheet.aim(if made.is_written() { said(&drawn) } else { made.message.clone() }, is_clean(&drawn)),
                text_of(&report["surface"]["self_intersections"]),
                made.seconds_text(),
                number(made.peak.map(|bytes| bytes / 1e6), 0),
            ]);
            self.record("large", &map, &made, json!({ "map": drawn, "solid": solid }));
        }
        let at_least_one = self.sheet.aim(format!("{free} of {}", LARGE.len()), free >= 1);
        let text = format!(
            "From presentations, `--allow-intersections`; at most 1000 pairs of triangles that meet are counted. Free of \
             self-intersection (at least one): {at_least_one}."
        );
        self.sheet.section("Large maps", &text, &LARGE_HEAD, &rows);
    }

    /// Line 6: tubes of a map's own edges.
    fn targetless(&mut self) {
        let mut rows = Vec::new();
        for name in TARGETLESS {
            let map = Named::of(name);
            let made = self.make("tubify", &map, "obj", "--allow-intersections");
            if !made.is_written() {
                self.record("tubify", &map, &made, Value::Null);
                let mut row = vec![name.to_string(), self.sheet.aim(made.message.clone(), false)];
                row.resize(TUBES_HEAD.len(), "–".into());
                rows.push(row);
                continue;
            }
            let tubes = &made.report["tubes"];
            let genus = tubes["tubes"].as_i64().unwrap_or(0) - tubes["junctions"].as_i64().unwrap_or(0) + 1;
            let solid = self.judge_solid(&made, &json!(genus), Open3d::WhereQuick);
            let closed = solid["watertight"] == true && solid["winding_consistent"] == true && solid["shells"] == 1;
            let crossings = &made.report["surface"]["self_intersections"];
            let must_be_free = ["R2.1′", "R2.4"].contains(&name);
            let free = *crossings == 0;
            rows.push(vec![
                name.to_string(),
                format!("{} / {}", tubes["junctions"], tubes["tubes"]),
                text_of(&tubes["symmetry"]["group"]),
                self.sheet.aim(if closed { "holds" } else { "fails" }, closed),
                self.sheet.aim(format!("{} ({genus})", solid["genus"]), solid["genus"] == genus),
                if must_be_free { self.sheet.aim(format!("{crossings} (0)"), free) } else { text_of(crossings) },
                if must_be_free { self.sheet.aim(by_open3d(&solid), is_clean(&solid)) } else { by_open3d(&solid) },
                made.seconds_text(),
            ]);
            self.record("tubify", &map, &made, json!({ "solid": solid }));
        }
        let text = "`tubify`: the map's own edge graph, relaxed. Genus by own count from the file, aim E − V + 1.";
        self.sheet.section("Targetless surfaces", text, &TUBES_HEAD, &rows);
    }

    /// Line 7: files for printing.
    fn solids(&mut self) {
        let mut rows = Vec::new();
        for name in ["R3.1", "R13.2′"] {
            let map = Named::of(name);
            let made = self.make("realize", &map, "stl", "--size 100");
            let solid = if made.is_written() {
                self.judge_solid(&made, &made.report["source"]["genus"], Open3d::Always)
            } else {
                Value::Null
            };
            let tight = solid["watertight"] == true && solid["winding_consistent"] == true;
            let free = solid["self_intersecting"] == false;
            rows.push(vec![
                name.to_string(),
                text_of(&solid["faces"]),
                self.sheet.aim(if tight { "watertight" } else { "open" }, tight),
                self.sheet.aim(by_open3d(&solid), free),
                self.sheet.aim(text_of(&solid["genus"]), solid["genus"] == made.report["source"]["genus"]),
                self.sheet.aim(if made.is_written() { said(&solid) } else { made.message.clone() }, is_clean(&solid)),
                number(solid["volume"].as_f64().map(|v| v / 1000.0), 1),
                number(solid["size"].as_array().and_then(|s| s.iter().filter_map(Value::as_f64).reduce(f64::max)), 2),
            ]);
            self.record("solids", &map, &made, json!({ "solid": solid }));
        }
        let head = [
            "map",
            "triangles",
            "trimesh",
            "self-intersection, open3d",
            "genus",
            "all of solid.py",
            "cm³",
            "largest extent, mm (100)",
        ];
        self.sheet.section("Solids", "STL with the map as relief, `--size 100`.", &head, &rows);
    }

    /// Line 8: whether the page works in a browser; `cargo xtask viewer` makes the same test.
    fn page(&mut self) {
        let (surface, page) = (self.settings.work.join("page.obj"), self.settings.work.join("page.html"));
        let made = Command::new(&self.settings.binary)
            .args(["regular-map", "realize", "R3.1", "--quiet", "-o"])
            .arg(&surface)
            .arg("--view")
            .arg(&page)
            .status();
        if !made.is_ok_and(|status| status.success()) {
            self.sheet.broken.push("the page of R3.1 was not written".into());
            return;
        }
        let script = root().join("tests/viewer/map.mjs");
        let output = Command::new("node").arg(script).arg(&page).current_dir(root()).output();
        let (passed, text) = match output {
            Err(_) => (None, "skipped: there is no node".into()),
            Ok(output) => {
                let text = String::from_utf8_lossy(&output.stdout).into_owned();
                match text.lines().find(|l| l.starts_with("skipped")) {
                    Some(line) => (None, line.to_string()),
                    None => (Some(output.status.success()), text),
                }
            }
        };
        let line = match passed {
            None => text,
            Some(passed) => {
                let checks = text.lines().filter(|l| l.starts_with("ok:")).count();
                let verdict = self.sheet.aim(if passed { "passed" } else { "failed" }, passed);
                format!("{verdict}, {checks} checks hold")
            }
        };
        self.sheet.runs.push(json!({ "part": "page", "passed": passed }));
        self.sheet.text.push_str(&format!(
            "\n## Page\n\nThe page of R3.1 in headless Chromium (`tests/viewer/map.mjs`, part of `cargo xtask viewer`): {line}.\n"
        ));
    }

    /// Line 9: one thread and two.
    fn threads(&mut self) {
        const RUNS: [(&str, &str, &str, &str); 9] = [
            ("realize", "R3.1", "obj", "--edges none"),
            ("realize", "R3.1", "stl", ""),
            ("realize", "R3.1", "glb", ""),
            ("realize", "R3.1", "ply", ""),
            ("realize", "R4.3", "obj", ""),
            ("realize", "R5.8", "obj", "--on R2.4"),
            ("realize", "R9.3′", "glb", "--on R2.1′"),
            ("realize", "R11.1", "stl", ""),
            ("tubify", "R2.4", "obj", ""),
        ];
        let mut rows = Vec::new();
        for (verb, name, ending, options) in RUNS {
            let map = Named::of(name);
            let files: Vec<Vec<u8>> = [1, 2]
                .into_iter()
                .filter_map(|threads| {
                    let made = self.make(verb, &map, ending, &format!("{options} --threads {threads}"));
                    if made.is_written() { std::fs::read(&made.file).ok() } else { None }
                })
                .collect();
            let (same, text) = match &files[..] {
                [one, two] if one == two => (true, format!("the same {} bytes", one.len())),
                [_, _] => (false, "differ".into()),
                _ => (false, "not written".into()),
            };
            self.sheet.runs.push(json!({
                "part": "threads", "verb": verb, "map": name, "ending": ending, "options": options, "same": same,
            }));
            rows.push(vec![verb.into(), name.into(), ending.to_uppercase(), self.sheet.aim(text, same)]);
        }
        let head = ["verb", "map", "file", "one thread and two"];
        self.sheet.section("Threads", "Files for `--threads 1` and `--threads 2`.", &head, &rows);
    }
}

const SURFACE_HEAD: [&str; 12] = [
    "map",
    "on the tubes of",
    "junctions / tubes",
    "skeleton",
    "rotations",
    "triangles",
    "self-intersections (0)",
    "counts of the report",
    "drawn_map.py",
    "solid.py",
    "self-intersection, open3d",
    "seconds (≤ 60)",
];

const LARGE_HEAD: [&str; 11] = [
    "map",
    "on the tubes of",
    "junctions / tubes",
    "rotations",
    "triangles",
    "closed, of the genus (solid.py)",
    "counts of the report",
    "drawn_map.py",
    "self-intersections",
    "seconds",
    "MB",
];

const TUBES_HEAD: [&str; 8] = [
    "map",
    "junctions / tubes",
    "rotations",
    "closed, wound, one shell (solid.py)",
    "genus",
    "self-intersections",
    "self-intersection, open3d",
    "seconds",
];

/// Whether the report's counts on the drawing are the source's, and its surface is closed and of the source's genus.
fn counts_agree(made: &Made) -> bool {
    let (source, drawn, surface) = (&made.report["source"], &made.report["map"], &made.report["surface"]);
    ["vertices", "edges", "faces"].iter().all(|k| source[*k].is_u64() && source[*k] == drawn[*k])
        && surface["closed"] == true
        && surface["genus"] == source["genus"]
}

/// The map of a row of `large_maps.tsv`: words there are indices of reflections. The one of genus 37 is wanted as its dual.
fn large_map(row: &[String]) -> Named {
    let is_dual = row[0] == "37";
    let letter = |digit: char| match (is_dual, digit) {
        (true, '0') => "r2".to_string(),
        (true, '2') => "r0".to_string(),
        (_, digit) => format!("r{digit}"),
    };
    let words = row[5].split(',').map(|digits| digits.trim().chars().map(letter).collect::<Vec<_>>().join("*"));
    let [p, q] = if is_dual { [&row[2], &row[1]] } else { [&row[1], &row[2]] };
    let relators: Vec<String> = [format!("R^{p}"), format!("S^{q}")].into_iter().chain(words).collect();
    let name = if is_dual { "R37.2′".into() } else { format!("genus {}, {{{p},{q}}}", row[0]) };
    Named::by_group(&name, relators.join(", "))
}
