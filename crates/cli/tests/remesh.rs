//! What the command makes.

mod common;

use common::{Bench, read_quads, topology};

#[test]
fn a_torus_becomes_the_number_of_quads_asked_for() {
    let bench = Bench::new();
    bench.line("remesh sample:torus -o torus.obj --quads 500 --report torus.json").succeeds();
    let (points, quads) = read_quads(&bench.path("torus.obj"));
    assert_eq!(topology(points.len(), &quads), (0, 1, 0));
    assert!((450..=550).contains(&quads.len()), "{}", quads.len());
    let report: serde_json::Value = serde_json::from_slice(&bench.read("torus.json")).expect("JSON");
    assert_eq!(report["output"]["faces"], quads.len());
    assert_eq!(report["output"]["chi"], 0);
    assert_eq!(report["count"]["asked"], 500);
    assert_eq!(report["quality"]["inverted"], 0);
    assert!(report["quality"]["scaled_jacobian_min"].as_f64() > Some(0.0));
    assert!(report["seconds"]["cross field"].is_number());
    bench.line("check torus.obj --reference sample:torus").succeeds();
    bench.line("check torus.obj --reference sample:sphere").fails_by_check();
}

#[test]
fn boundaries_and_creases_are_kept() {
    let bench = Bench::new();
    bench.line("remesh sample:cylinder -o cylinder.obj --quads 400").succeeds();
    let (points, quads) = read_quads(&bench.path("cylinder.obj"));
    let (chi, components, boundary) = topology(points.len(), &quads);
    assert_eq!((chi, components), (0, 1));
    assert!(boundary > 0);
    bench.line("remesh sample:cube -o cube.obj --quads 300").succeeds();
    let (points, quads) = read_quads(&bench.path("cube.obj"));
    assert_eq!(topology(points.len(), &quads), (2, 1, 0));
    // Creases: the corners of the cube are among the vertices.
    let [low, high] = [f64::min as fn(f64, f64) -> f64, f64::max]
        .map(|pick| points.iter().fold(points[0], |a, p| [pick(a[0], p[0]), pick(a[1], p[1]), pick(a[2], p[2])]));
    for corner in 0..8 {
        let wanted: [f64; 3] = std::array::from_fn(|k| if corner >> k & 1 == 0 { low[k] } else { high[k] });
        let is_there = |p: &[f64; 3]| (0..3).all(|k| (p[k] - wanted[k]).abs() < 1e-9);
        assert!(points.iter().any(is_there), "{wanted:?}");
    }
}

#[test]
fn components_are_meshed_each() {
    let bench = Bench::new();
    bench.line("remesh sample:two_spheres -o spheres.obj --quads 600 --report report.json").succeeds();
    let (points, quads) = read_quads(&bench.path("spheres.obj"));
    assert_eq!(topology(points.len(), &quads), (4, 2, 0));
    let report: serde_json::Value = serde_json::from_slice(&bench.read("report.json")).expect("JSON");
    assert_eq!(report["components"].as_array().map(Vec::len), Some(2));
}

#[test]
fn threads_and_repetition_change_no_byte() {
    let bench = Bench::new();
    for (name, threads) in [("one", "1"), ("two", "2"), ("again", "2")] {
        let file = format!("{name}.obj");
        bench.run(&["remesh", "sample:two_spheres", "-o", &file, "--quads", "500", "--threads", threads]).succeeds();
    }
    assert_eq!(bench.read("one.obj"), bench.read("two.obj"));
    assert_eq!(bench.read("two.obj"), bench.read("again.obj"));
}

#[test]
fn the_default_size_is_said_aloud_and_quiet_is_quiet() {
    let bench = Bench::new();
    let loud = bench.line("remesh sample:sphere -o out.obj");
    assert!(matches!(loud.code, 0 | 6), "{}", loud.stderr);
    assert!(loud.stderr.contains("a quarter of the triangles"), "{}", loud.stderr);
    let quiet = bench.line("remesh sample:sphere -o out.obj --quiet");
    assert_eq!(quiet.code, loud.code);
    assert_eq!((quiet.stdout.as_str(), quiet.stderr.as_str()), ("", ""));
}

#[test]
fn progress_as_json_is_one_object_per_line() {
    let bench = Bench::new();
    let ran = bench.line("remesh sample:sphere -o out.obj --quads 500 --progress json --quiet");
    assert!(ran.stderr.lines().count() > 3, "{}", ran.stderr);
    for line in ran.stderr.lines() {
        let value: serde_json::Value = serde_json::from_str(line).expect("JSON");
        assert!(value["stage"].is_string() && value["fraction"].is_number(), "{line}");
    }
}

#[test]
fn dirt_is_cured_and_reported() {
    let bench = Bench::new();
    bench.line("convert sample:sphere clean.obj").succeeds();
    let clean = String::from_utf8(bench.read("clean.obj")).expect("text");
    let face = clean.lines().find(|l| l.starts_with("f ")).expect("a face").to_string();
    // A copy of a face, an unused vertex, a face that repeats a corner; all lines end in CRLF.
    let dirty = format!("v 9 9 9\n{clean}{face}\nf 2 2 3\n");
    let shifted: String = dirty
        .lines()
        .map(|line| match line.strip_prefix("f ") {
            Some(rest) if line != "f 2 2 3" => {
                let corners: Vec<String> = rest
                    .split(' ')
                    .map(|c| (c.split('/').next().unwrap_or("").parse::<u32>().expect("index") + 1).to_string())
                    .collect();
                format!("f {}\r\n", corners.join(" "))
            }
            _ => format!("{line}\r\n"),
        })
        .collect();
    bench.write("dirty.obj", shifted);
    let ran = bench.line("remesh dirty.obj -o out.obj --quads 400");
    ran.succeeds();
    for word in ["duplicate", "unused", "degenerate"] {
        assert!(ran.stderr.contains(word), "{word} is not in {}", ran.stderr);
    }
    let (points, quads) = read_quads(&bench.path("out.obj"));
    assert_eq!(topology(points.len(), &quads), (2, 1, 0));
}

#[test]
fn names_need_not_be_ascii() {
    let bench = Bench::new();
    bench.line("convert sample:sphere Körper_形.obj").succeeds();
    bench.run(&["remesh", "Körper_形.obj", "-o", "gewöhnlich α.obj", "--quads", "300"]).succeeds();
    assert!(bench.path("gewöhnlich α.obj").is_file());
}

#[test]
fn everything_asked_for_is_written() {
    let bench = Bench::new();
    bench
        .line("remesh sample:torus -o t.vtu --quads 300 --write-field t.rosy --write-map map.obj --report t.json --view t.html")
        .succeeds();
    assert_eq!(bench.files(), ["map.obj", "t.html", "t.json", "t.rosy", "t.rosy.obj", "t.vtu"]);
    let map = String::from_utf8(bench.read("map.obj")).expect("text");
    let faces = map.lines().filter(|l| l.starts_with("f ")).count();
    let rosy = String::from_utf8(bench.read("t.rosy")).expect("text");
    assert_eq!(rosy.lines().next().and_then(|l| l.trim().parse().ok()), Some(faces));
    assert!(map.lines().any(|l| l.starts_with("vt ")));
}

#[test]
fn check_accepts_what_remesh_accepted() {
    let bench = Bench::new();
    // Coarse quads on sharp edges: whether one faces along the surface depends on where its edges are.
    for shape in ["bracket", "cube", "cylinder"] {
        let ran = bench.line(&format!("remesh sample:{shape} -o out.obj --quads 200 --tolerance 90"));
        assert!(matches!(ran.code, 0 | 6), "{shape}: {}", ran.stderr);
        bench.line(&format!("check out.obj --reference sample:{shape}")).succeeds();
    }
}

#[test]
fn a_surface_that_was_cut_open_is_told() {
    let bench = Bench::new();
    // Three sheets of 4 by 4 squares that meet in a line.
    let mut text = String::new();
    for turn in 0..3 {
        let (sin, cos) = (f64::from(turn) * 2.0).sin_cos();
        let first = turn * 25 + 1;
        for (i, j) in (0..5).flat_map(|j| (0..5).map(move |i| (i, j))) {
            text += &format!("v {} {} {j}\n", f64::from(i) * cos, f64::from(i) * sin);
        }
        for (i, j) in (0..4).flat_map(|j| (0..4).map(move |i| (i, j))) {
            let at = |i: i32, j: i32| first + 5 * j + i;
            text += &format!("f {} {} {}\n", at(i, j), at(i + 1, j), at(i + 1, j + 1));
            text += &format!("f {} {} {}\n", at(i, j), at(i + 1, j + 1), at(i, j + 1));
        }
    }
    bench.write("sheets.obj", text);
    let ran = bench.line("remesh sheets.obj -o out.obj --quads 300 --tolerance 40 --report r.json");
    let told = "cut open at 4 edges with more than two faces: the result has 2 boundary loops instead of 1";
    assert!(ran.stderr.contains(told), "{}", ran.stderr);
    let report: serde_json::Value = serde_json::from_slice(&bench.read("r.json")).expect("JSON");
    assert_eq!(report["input_as_read"]["boundary_loops"], 1);
    assert_eq!(report["input_as_read"]["non_manifold_edges"], 4);
    assert_eq!(report["input"]["boundary_loops"], 2);
    // `check` compares with the same surface and says so.
    let check = bench.line("check out.obj --reference sheets.obj");
    assert!(check.code == 0 && check.stdout.contains(told), "{}", check.stdout);
}

impl common::Ran {
    #[track_caller]
    fn fails_by_check(&self) {
        assert_eq!(self.code, 4, "{}{}", self.stdout, self.stderr);
        assert!(self.stdout.contains("Euler characteristic"), "{}", self.stdout);
    }
}
