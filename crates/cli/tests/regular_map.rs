//! `quadloom regular-map`: what is listed, found, drawn and built, and what is said of bad input.

mod common;

use common::{Bench, Ran};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};

fn json(bench: &Bench, name: &str) -> Value {
    serde_json::from_slice(&bench.read(name)).unwrap()
}

fn text(bench: &Bench, name: &str) -> String {
    String::from_utf8(bench.read(name)).unwrap()
}

/// Runs words after `regular-map`; blanks inside a word are kept.
fn run(bench: &Bench, words: &[&str]) -> Ran {
    bench.run(&[&["regular-map"], words].concat())
}

fn printed(bench: &Bench, line: &str) -> Value {
    let ran = bench.line(&format!("regular-map {line} --json"));
    ran.succeeds();
    serde_json::from_str(&ran.stdout).unwrap()
}

#[test]
fn lists_have_both_ends_and_no_duals() {
    let bench = Bench::new();
    let count = |line: &str| printed(&bench, &format!("list {line}")).as_array().unwrap().len();
    assert_eq!(
        ["2", "3", "2..3", "2..=3", "2..15"].map(|genera| count(&format!("--genus {genera}"))),
        [6, 12, 18, 18, 220]
    );
    assert_eq!([count("--type 3,7 --genus 2..8"), count("--type 7,3 --genus 2..8")], [2, 2]);
    assert!(count("") >= 425);
    let maps = printed(&bench, "list --genus 3");
    let klein = &maps[0];
    for (field, value) in [
        ("p", 3),
        ("q", 7),
        ("petrie", 8),
        ("order", 336),
        ("genus", 3),
        ("vertices", 24),
        ("edges", 84),
        ("faces", 56),
    ] {
        assert_eq!(klein[field], value, "{field}");
    }
    assert_eq!([&klein["name"], &klein["identifier"]], ["R3.1", "{3,7}_8#3.1"]);
    assert_eq!([&klein["multiplicities"], &klein["self_dual"]], [&serde_json::json!([1, 1]), &Value::Bool(false)]);
    for map in maps.as_array().unwrap() {
        let number = |field: &str| map[field].as_u64().unwrap();
        assert!(number("p") <= number("q") && number("order") == 4 * number("edges"), "{map}");
        // The group that is printed is the one that was meant.
        let again = run(&bench, &["info", "--json", "--presentation", map["presentation"].as_str().unwrap()]);
        let again: Value = serde_json::from_str(&again.stdout).unwrap();
        assert_eq!([&again["identifier"], &again["order"]], [&map["identifier"], &map["order"]]);
    }
    let table = bench.line("regular-map list --genus 2");
    assert!(table.stdout.contains("R2.4") && table.stdout.ends_with("6 maps\n"), "{}", table.stdout);
    assert!(bench.line("regular-map list --genus 24..30").stderr.contains("search"));
}

#[test]
fn maps_go_by_many_names() {
    let bench = Bench::new();
    for (typed, name) in [
        ("R3.1", "R3.1"),
        ("{3,7}_8", "R3.1"),
        ("{3,7}_8#3.1", "R3.1"),
        ("R3.1'", "R3.1′"),
        ("R3.1′", "R3.1′"),
        ("{7,3}_8", "R3.1′"),
        ("cube", "cube"),
        ("cube'", "octahedron"),
        ("{4,4}_(3,0)", "{4,4}_(3,0)"),
    ] {
        let found = run(&bench, &["info", typed, "--json"]);
        found.succeeds();
        let found: Value = serde_json::from_str(&found.stdout).unwrap();
        assert_eq!(found["name"], name, "{typed}");
    }
    let rows = bench.line("regular-map info R3.1").stdout;
    assert!(["R3.1", "336", "24, 84, 56", "R^3, S^7"].iter().all(|word| rows.contains(word)), "{rows}");
    let half_a_cube = run(&bench, &["info", "--presentation", "⟨R, S, T | R^4, S^3, (R*S*T)^3⟩"]);
    half_a_cube.succeeds();
    assert!(half_a_cube.stdout.contains("crosscaps  1"), "{}", half_a_cube.stdout);
}

#[test]
fn targets_are_found() {
    let bench = Bench::new();
    let found = printed(&bench, "match R5.8");
    let best = &found[0];
    assert_eq!([&best["target"]["name"], &best["pole"]], ["R2.4", "vertex"]);
    for (field, value) in [("index", 2), ("junctions", 1), ("valence", 10), ("tubes", 5)] {
        assert_eq!(best[field], value, "{field}");
    }
    assert!(bench.line("regular-map match R3.1").stdout.contains("tetrahedron"));
    let none = bench.line("regular-map match R3.12 --json");
    none.succeeds();
    assert!(none.stdout.trim() == "[]" && none.stderr.contains("tubify"), "{}", none.stderr);
}

#[test]
fn pictures_are_svg_and_png() {
    let bench = Bench::new();
    bench.line("regular-map tile R3.1 -o disc.svg").succeeds();
    let svg = text(&bench, "disc.svg");
    assert!(svg.starts_with("<svg") || svg.starts_with("<?xml"));
    assert_eq!(svg.matches("data-face=").count(), 56);
    assert!(svg.contains("R3.1"));
    bench
        .line("regular-map tile R3.1 -o disc.png --size 300 --numbers --triangles --centre vertex --model klein")
        .succeeds();
    let png = bench.read("disc.png");
    assert_eq!(&png[..8], b"\x89PNG\r\n\x1a\n");
    assert_eq!(png[16..24], [0, 0, 1, 44, 0, 0, 1, 44], "300 × 300");
    for (map, colors) in [("cube", "triangle"), ("{4,4}_(3,0)", "petrie"), ("R2.1'", "block:R,T")] {
        bench.line(&format!("regular-map tile {map} -o a.svg --colors {colors} --model jemisphere")).succeeds();
    }
}

/// Corners of the triangles of a binary STL, as numbers of points that are equal to the last bit.
fn read_stl(bytes: &[u8]) -> (Vec<[f32; 3]>, Vec<[usize; 3]>) {
    let float = |at: usize| f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    let count = u32::from_le_bytes(bytes[80..84].try_into().unwrap()) as usize;
    assert_eq!(bytes.len(), 84 + 50 * count);
    let (mut number, mut points) = (BTreeMap::new(), Vec::new());
    let mut corner = |at: usize| {
        let p = [float(at), float(at + 4), float(at + 8)];
        *number.entry(p.map(f32::to_bits)).or_insert_with(|| {
            points.push(p);
            points.len() - 1
        })
    };
    let triangles = (0..count).map(|t| [0, 1, 2].map(|k| corner(84 + 50 * t + 12 + 12 * k))).collect();
    (points, triangles)
}

#[test]
fn kleins_quartic_is_a_watertight_solid() {
    let bench = Bench::new();
    bench.line("regular-map realize R3.1 -o k.stl --size 60 --report r.json --view v.html").succeeds();
    let (points, triangles) = read_stl(&bench.read("k.stl"));
    let sides: BTreeSet<(usize, usize)> = triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
    assert_eq!(sides.len(), 3 * triangles.len(), "a side is passed twice");
    assert!(sides.iter().all(|&(a, b)| a != b && sides.contains(&(b, a))), "the surface is open");
    let chi = points.len() as i64 - sides.len() as i64 / 2 + triangles.len() as i64;
    assert_eq!(chi, -4);
    let extent = |k: usize| {
        let all = || points.iter().map(|p| p[k]);
        all().fold(f32::MIN, f32::max) - all().fold(f32::MAX, f32::min)
    };
    let largest = [0, 1, 2].map(extent).into_iter().fold(0.0, f32::max);
    assert!((largest - 60.0).abs() < 1e-3, "{largest}");
    let volume: f64 = triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|v| points[v].map(f64::from));
            (a[0] * (b[1] * c[2] - b[2] * c[1])
                + a[1] * (b[2] * c[0] - b[0] * c[2])
                + a[2] * (b[0] * c[1] - b[1] * c[0]))
                / 6.0
        })
        .sum();
    assert!(volume > 0.0, "it is inside out");

    let report = json(&bench, "r.json");
    assert_eq!(report["source"]["name"], "R3.1");
    assert_eq!(report["map"], serde_json::json!({ "vertices": 24, "edges": 84, "faces": 56, "chi": -4 }));
    let surface = &report["surface"];
    assert_eq!([&surface["faces"], &surface["vertices"]], [triangles.len(), points.len()]);
    assert_eq!([&surface["chi"], &surface["genus"], &surface["self_intersections"]], [-4, 3, 0]);
    assert_eq!([&surface["closed"], &report["dual"]], [true, false]);
    let tubes = &report["surface_of"];
    assert_eq!(
        [&tubes["target"]["name"], &tubes["skeleton"], &tubes["symmetry"]["group"]],
        ["tetrahedron", "sphere", "T"]
    );
    assert_eq!([&tubes["junctions"], &tubes["tubes"], &tubes["symmetry"]["order"]], [4, 6, 12]);
    assert_eq!(tubes["cage"], serde_json::json!([20, 48, 24]));
    assert!(tubes["symmetry"]["error"].as_f64().unwrap() < 1e-9 && tubes["radius"].as_f64().unwrap() > 1.0);
    let orbits = report["face_orbits"].as_array().unwrap();
    let sizes: Vec<usize> = orbits.iter().map(|orbit| orbit.as_array().unwrap().len()).collect();
    assert_eq!(sizes, [12, 12, 12, 12, 4, 4]);
    assert_eq!([&report["colors"], &report["index"]], [56, 7]);
    assert_eq!(report["size"], 60.0);
    let page = text(&bench, "v.html");
    assert!(page.contains("R3.1") && page.contains("data-face") && !page.contains("https://"));
}

#[test]
fn every_format_holds_the_surface() {
    let bench = Bench::new();
    for format in ["glb", "ply", "obj", "off", "vtu"] {
        bench.line(&format!("regular-map realize R3.1 -o k.{format}")).succeeds();
    }
    let glb = bench.read("k.glb");
    assert!(&glb[..4] == b"glTF" && String::from_utf8_lossy(&glb).contains("COLOR_0"));
    assert!(String::from_utf8_lossy(&bench.read("k.ply")).contains("red"));
    assert!(text(&bench, "k.vtu").contains("face"));
    let obj = text(&bench, "k.obj");
    let groups: BTreeSet<&str> = obj.lines().filter_map(|line| line.strip_prefix("g ")).collect();
    assert_eq!((groups.len(), groups.contains("edges"), groups.contains("face_55")), (57, true, true));
    let off = bench.line("stats k.off --json");
    let stats: Value = serde_json::from_str(&off.stdout).unwrap();
    assert!(off.stdout.contains("\"genus\": 3") || stats.to_string().contains("\"genus\":3"), "{}", off.stdout);
}

#[test]
fn the_dual_and_all_edges_and_colours_are_drawn() {
    let bench = Bench::new();
    bench.line("regular-map realize R3.1 --dual -o d.obj --report d.json --view d.html").succeeds();
    let dual = json(&bench, "d.json");
    assert_eq!(dual["map"], serde_json::json!({ "vertices": 56, "edges": 84, "faces": 24, "chi": -4 }));
    assert_eq!([&dual["dual"], &dual["surface"]["self_intersections"]], [&Value::Bool(true), &0.into()]);
    // The same map by its name.
    bench.line("regular-map realize R3.1' -o e.obj --report e.json").succeeds();
    assert_eq!(json(&bench, "e.json")["map"], dual["map"]);
    for edges in ["none", "bands", "tubes", "relief"] {
        bench.line(&format!("regular-map realize R3.1 -o e.stl --edges {edges}")).succeeds();
    }
    for (colors, count) in [
        ("face", 56),
        ("vertex", 24),
        ("edge", 84),
        ("triangle", 2),
        ("petrie", 21),
        ("tube", 6),
        ("junction", 4),
        ("half-tube", 12),
        ("quarter-tube", 24),
        ("symmetry", 6),
        ("orbit:R", 20),
        ("block:R,T", 56),
        ("orbit:R,S", 1),
    ] {
        let line = format!("regular-map realize R3.1 -o c.ply --colors {colors} --report c.json --view c.html");
        bench.line(&line).succeeds();
        assert_eq!(json(&bench, "c.json")["colors"], count, "{colors}");
    }
}

#[test]
fn targets_can_be_chosen() {
    let bench = Bench::new();
    for target in ["tetrahedron", "{3,3}", "{3,3}_4"] {
        bench.line(&format!("regular-map realize R3.1 --on {target} -o a.off --report a.json")).succeeds();
        assert_eq!(json(&bench, "a.json")["surface_of"]["target"]["name"], "tetrahedron");
    }
    bench.line("regular-map realize R3.1 --on {4,3}_3 -o a.off --report a.json").succeeds();
    assert_eq!(json(&bench, "a.json")["surface_of"]["target"]["orientable"], false);
    bench.line("regular-map realize R3.1 -o b.off --thickness 0.5 --report b.json").succeeds();
    let radius = |name: &str| json(&bench, name)["surface_of"]["radius"].as_f64().unwrap();
    bench.line("regular-map realize R3.1 -o a.off --report a.json").succeeds();
    assert!(radius("b.json") < 0.7 * radius("a.json"));
}

#[test]
fn a_maps_own_edges_become_tubes() {
    let bench = Bench::new();
    bench.line("regular-map tubify R2.4 -o t.obj --report t.json").succeeds();
    let (points, quads) = common::read_quads(&bench.path("t.obj"));
    assert_eq!(common::topology(points.len(), &quads), (-8, 1, 0));
    let report = json(&bench, "t.json");
    assert_eq!([&report["surface"]["genus"], &report["surface"]["self_intersections"]], [5, 0]);
    assert_eq!([&report["tubes"]["target"]["name"], &report["tubes"]["skeleton"]], ["R2.4", "relaxed"]);
    assert_eq!(report["tubes"]["tubes"], 5);
    bench.line("regular-map tubify tetrahedron -o t.stl --size 40").succeeds();
    let (points, triangles) = read_stl(&bench.read("t.stl"));
    assert_eq!(points.len() as i64 - triangles.len() as i64 / 2, -4);
}

#[test]
fn searches_find_what_is_listed() {
    let bench = Bench::new();
    let [searched, listed] = ["search", "list"].map(|verb| printed(&bench, &format!("{verb} --genus 2..6")));
    assert_eq!(searched.as_array().unwrap().len(), 59);
    let names = |maps: &Value| -> Vec<String> {
        maps.as_array().unwrap().iter().map(|m| m["identifier"].as_str().unwrap().into()).collect()
    };
    assert_eq!(names(&searched), names(&listed));
    assert_eq!(printed(&bench, "search --genus 2..8 --type 7,3").as_array().unwrap().len(), 2);
    let chiral = printed(&bench, "search --genus 7 --chiral");
    assert_eq!([&chiral[0]["p"], &chiral[0]["q"], &chiral[0]["rotations"]], [6, 9, 54]);
    let progress = bench.line("regular-map search --genus 2..4 --progress json");
    assert!(progress.stderr.contains("\"stage\":\"regular maps\""), "{}", progress.stderr);
}

#[test]
fn bad_names_and_groups_are_explained() {
    let bench = Bench::new();
    let named = |name: &str, code: i32, words: &[&str]| run(&bench, &["info", name]).fails_with(code, words);
    named("R3.99", 2, &["R3.99", "12 maps", "R3.12"]);
    named("R3.5", 2, &["{4,8}_8#3.5, {4,8}_8#3.6"]);
    named("{3,7}", 2, &["5 maps", "{3,7}_18#7.1"]);
    named("banana", 2, &["banana", "R3.1", "cube"]);
    named("{4,4}_(2,1)", 2, &["chiral"]);
    let group = |text: &str, code: i32, words: &[&str]| {
        run(&bench, &["realize", "-o", "x.stl", "--presentation", text]).fails_with(code, words);
    };
    group("R^3, S^7, (R*Q)^4", 2, &["character 4", "'Q'"]);
    group("R^3, S^7, (R*S^-2", 2, &["character 8", "bracket"]);
    group("R^3, S^7", 2, &["2000000 cosets", "infinite or too large"]);
    group("R^3, T^2", 2, &["S^n"]);
    group("R^9, S^3, R^3*S*R^-3*S^-1", 2, &["R^9", "order of R 3"]);
    group("R^3, S^7, (R*S^-2)^5", 2, &["--presentation", "no regular map", "exponents"]);
    group("R^4, S^3, (R*S*T)^3", 4, &["not orientable"]);
    run(&bench, &["match", "--presentation", "R^4, S^3, (R*S*T)^3"]).fails_with(4, &["not orientable"]);
    run(&bench, &["info", "R3.1", "--presentation", "R^3, S^7"]).fails_with(2, &["--presentation"]);
    run(&bench, &["info"]).fails_with(2, &["--presentation"]);
    assert!(bench.files().is_empty());
}

#[test]
fn what_cannot_be_built_is_explained() {
    let bench = Bench::new();
    let fails = |line: &str, code: i32, words: &[&str]| {
        bench.line(&format!("regular-map {line}")).fails_with(code, words);
    };
    fails("realize R3.12 -o x.stl", 4, &["R3.12", "tubify", "tile"]);
    fails("realize cube -o x.stl", 4, &["cube", "tubify"]);
    fails("realize R3.12 --on cube -o x.stl", 4, &["R3.12", "tubify"]);
    fails("realize R3.1 --on cube -o x.stl", 4, &["\"cube\"", "tetrahedron {3,3}_4", "{4,3}_3", "match"]);
    fails("realize R3.1 --on banana -o x.stl", 4, &["banana", "tetrahedron"]);
    fails("realize R3.1 --skeleton drawn -o x.stl", 5, &["drawn", "auto"]);
    fails("tubify R2.4 --symmetry I -o x.obj", 4, &["rotations I"]);
    fails("tubify {2,5} --symmetry Z -o x.obj", 2, &["--symmetry", "T, O, I"]);
    fails("realize R3.1 --colors mauve -o x.stl", 2, &["--colors", "petrie", "orbit:WORDS"]);
    fails("realize R3.1 --colors orbit:R*Q -o x.stl", 2, &["--colors", "character 3"]);
    fails("tile R3.1 --colors tube -o x.svg", 2, &["--colors", "flat picture"]);
    fails("tile R3.1 --size 3 -o x.svg", 2, &["--size", "16"]);
    fails("list --genus 5..2", 2, &["--genus", "larger"]);
    fails("list --genus a..b", 2, &["--genus"]);
    fails("list --genus 0..1", 2, &["--genus", "genus 2", "cube"]);
    fails("list --type 3", 2, &["--type", "3,7"]);
    fails("search --genus 1", 2, &["--genus"]);
    fails("realize R3.1 --size -1 -o x.stl", 2, &["--size", "above 0"]);
    fails("realize R3.1 --thickness 0 -o x.stl", 2, &["--thickness", "above 0"]);
    fails("realize R3.1 --edge-width 2 -o x.stl", 2, &["--edge-width", "0.9"]);
    fails("realize R3.1 --edges dots -o x.stl", 2, &["--edges", "relief"]);
    fails("realize R3.1 -o x.foo", 2, &["x.foo", ".stl"]);
    fails("tile R3.1 -o x.gif", 2, &["x.gif", ".svg or .png"]);
    fails("realize R3.1 -o x.stl --view x.txt", 2, &["x.txt", ".html"]);
    fails("realize R3.1 -o x.stl --report x.stl", 2, &["one file"]);
    fails("realize R3.1 -o missing/x.stl", 3, &["missing"]);
    assert!(bench.files().is_empty(), "{:?}", bench.files());
}

#[test]
fn time_limits_leave_no_file() {
    let bench = Bench::new();
    for line in ["realize R9.3' -o x.stl --report r.json", "tubify R2.4 -o x.obj", "search --genus 2..20"] {
        bench.line(&format!("regular-map {line} --time-limit 0.000001")).fails_with(7, &[]);
    }
    assert!(bench.files().is_empty());
}

#[test]
fn threads_change_no_byte() {
    let bench = Bench::new();
    for threads in [1, 2] {
        bench
            .line(&format!("regular-map realize R4.3 -o a{threads}.glb --view a{threads}.html --threads {threads}"))
            .succeeds();
        bench.line(&format!("regular-map tubify R2.4 -o t{threads}.obj --threads {threads}")).succeeds();
    }
    for [one, two] in [["a1.glb", "a2.glb"], ["a1.html", "a2.html"], ["t1.obj", "t2.obj"]] {
        assert!(bench.read(one) == bench.read(two), "{one} and {two} differ");
    }
}

#[test]
fn every_verb_has_help_with_an_example() {
    let bench = Bench::new();
    assert!(bench.line("regular-map --help").stdout.contains("Example: quadloom regular-map"));
    for verb in ["list", "info", "tile", "match", "realize", "tubify", "search"] {
        let help = bench.line(&format!("regular-map {verb} --help"));
        help.succeeds();
        assert!(help.stdout.contains(&format!("Example: quadloom regular-map {verb}")), "{}", help.stdout);
    }
}

#[test]
fn a_symmetry_that_is_asked_for_is_had_or_refused() {
    let bench = Bench::new();
    let told = "regular-map realize R3.1 --symmetry D9 -o none.obj";
    bench.line(told).fails_with(4, &["D9"]);
    assert!(!bench.path("none.obj").exists());
    bench.line("regular-map realize R3.1 --symmetry C3 -o c3.obj --report c3.json").succeeds();
    let order = json(&bench, "c3.json")["surface_of"]["symmetry"]["order"].as_u64().unwrap();
    assert_eq!(order % 3, 0);
}
