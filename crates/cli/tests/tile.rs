//! `quadloom tile`: files, options, exit codes.

mod common;

use common::Bench;
use serde_json::Value;
use std::collections::BTreeSet;

fn json(bench: &Bench, name: &str) -> Value {
    serde_json::from_slice(&bench.read(name)).unwrap()
}

fn text(bench: &Bench, name: &str) -> String {
    String::from_utf8(bench.read(name)).unwrap()
}

/// Groups with their number of faces, edges of faces, and edges of `l` lines.
type Read = (Vec<(String, usize)>, BTreeSet<[usize; 2]>, BTreeSet<[usize; 2]>);

fn read_obj(text: &str) -> Read {
    let (mut groups, mut edges, mut lines): Read = Default::default();
    let edge = |a: usize, b: usize| [a.min(b), a.max(b)];
    for line in text.lines() {
        let (kind, rest) = line.split_once(' ').unwrap_or((line, ""));
        let numbers = || -> Vec<usize> {
            rest.split_whitespace().map(|w| w.split('/').next().unwrap().parse().unwrap()).collect()
        };
        match kind {
            "g" => groups.push((rest.to_string(), 0)),
            "f" => {
                let f = numbers();
                assert_eq!(f.len(), 3);
                groups.last_mut().unwrap().1 += 1;
                edges.extend([edge(f[0], f[1]), edge(f[1], f[2]), edge(f[2], f[0])]);
            }
            "l" => lines.extend(numbers().windows(2).map(|p| edge(p[0], p[1]))),
            _ => {}
        }
    }
    (groups, edges, lines)
}

#[test]
fn tiles_of_every_kind_are_written() {
    // Sample, options, tiles, sides.
    let cases: [(&str, &str, usize, Option<usize>); 9] = [
        ("genus2", "--into quads", 3, Some(4)),
        ("genus2", "--into schema", 1, Some(8)),
        ("genus2", "--into pants", 2, Some(3)),
        ("genus2", "--into cylinders", 6, Some(3)),
        ("torus", "--into disk --method single-point", 1, Some(4)),
        ("sphere", "--into disk", 1, Some(2)),
        ("cylinder", "--into disk", 1, Some(4)),
        ("plate", "--into quads", 7, Some(4)),
        ("two_spheres", "--into disk", 2, Some(2)),
    ];
    for (sample, options, tiles, sides) in cases {
        let bench = Bench::new();
        bench
            .line(&format!("tile sample:{sample} {options} -o t.obj --layout t.json --report r.json --view v.html"))
            .succeeds();
        let (groups, edges, lines) = read_obj(&text(&bench, "t.obj"));
        let names: Vec<&str> = groups.iter().map(|g| g.0.as_str()).collect();
        let (last, tile_groups) = names.split_last().unwrap();
        assert_eq!((*last, tile_groups.len()), ("cuts", tiles), "{sample} {options}");
        assert!(groups[..tiles].iter().all(|g| g.1 > 0) && lines.is_subset(&edges) && !lines.is_empty());
        let report = json(&bench, "r.json");
        assert_eq!(report["tiles"], tiles);
        assert_eq!(report["sides"].as_array().unwrap().len(), tiles);
        if let Some(sides) = sides {
            assert!(report["sides"].as_array().unwrap().iter().all(|s| s == sides), "{sample} {options}: {report}");
        }
        for field in ["multipoints", "length", "chi"] {
            assert!(report[field].is_number(), "{field}");
        }
        bench.line("check t.obj --layout t.json").succeeds();
        assert!(!text(&bench, "v.html").contains("https://"));
    }
}

#[test]
fn words_are_those_of_the_surface() {
    let bench = Bench::new();
    bench.line("tile sample:genus3 --into schema -o t.obj --layout t.json --report r.json").succeeds();
    let report = json(&bench, "r.json");
    let word = report["word"].as_str().unwrap();
    let sides: Vec<&str> = word.split_whitespace().collect();
    let (there, back): (BTreeSet<&str>, BTreeSet<&str>) = (
        sides.iter().copied().filter(|s| !s.ends_with("⁻¹")).collect(),
        sides.iter().filter_map(|s| s.strip_suffix("⁻¹")).collect(),
    );
    assert!(sides.len() == 12 && there.len() == 6 && there == back, "{word}");
    assert_eq!(report["canonical_word"], "a1 b1 a1⁻¹ b1⁻¹ a2 b2 a2⁻¹ b2⁻¹ a3 b3 a3⁻¹ b3⁻¹");
    let layout = json(&bench, "t.json");
    assert_eq!(layout["tiles"][0]["word"].as_str().unwrap(), word);
    assert_eq!((layout["nodes"].as_array().unwrap().len(), layout["arcs"].as_array().unwrap().len()), (1, 6));
}

#[test]
fn steps_begin_uncut_and_end_with_the_result() {
    let bench = Bench::new();
    bench.line("tile sample:genus2 --into quads -o t.obj --layout t.json --steps steps").succeeds();
    // Four loops and two diagonals.
    for step in 0..=6 {
        bench.line(&format!("check steps/step_00{step}.obj --layout steps/step_00{step}.json")).succeeds();
    }
    let first = json(&bench, "steps/step_000.json");
    assert_eq!((first["tiles"][0]["genus"].as_i64(), first["arcs"].as_array().map(Vec::len)), (Some(2), Some(0)));
    assert_eq!(bench.read("steps/step_006.obj"), bench.read("t.obj"));
    bench.line("tile sample:torus -o t.obj --steps missing/steps").fails_with(3, &[]);
}

#[test]
fn a_spoilt_layout_is_refused() {
    let bench = Bench::new();
    bench.line("tile sample:torus --into quads -o t.obj --layout t.json").succeeds();
    let whole = text(&bench, "t.json");
    bench.write("genus.json", whole.replace("\"genus\":0", "\"genus\":1"));
    let ran = bench.line("check t.obj --layout genus.json");
    assert!(ran.code == 4 && ran.stdout.contains("chi"), "{}", ran.stdout);
    bench.write("none.json", "{}");
    bench.line("check t.obj --layout none.json").fails_with(4, &[]);
}

#[test]
fn maps_have_a_place_per_corner() {
    let bench = Bench::new();
    for kind in ["fixed", "conformal", "abf", "circles"] {
        bench
            .line(&format!("tile sample:genus2 --into quads --parametrize {kind} -o t.obj --report r.json"))
            .succeeds();
        let mesh = text(&bench, "t.obj");
        assert!(mesh.lines().filter(|l| l.starts_with("f ")).all(|l| l.matches('/').count() == 3));
        let maps = json(&bench, "r.json")["components"][0]["maps"].clone();
        assert!(maps.as_array().unwrap().iter().all(|m| m["folded"].as_array().unwrap().is_empty()));
        if kind == "fixed" {
            let places = mesh.lines().filter_map(|l| l.strip_prefix("vt "));
            let inside = |w: &str| (0.0..=1.0).contains(&w.parse::<f64>().unwrap());
            assert!(places.flat_map(|p| p.split_whitespace()).all(inside));
        }
    }
    bench.line("tile sample:genus2 --into pants --parametrize fixed -o t2.obj").fails_with(4, &[]);
}

/// A torus as an ASCII PLY with an attribute, which is `odd` at vertex 3.
fn torus_with_attribute(odd: &str) -> String {
    let (m, n) = (12, 8);
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
         property double w\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        m * n,
        2 * m * n
    );
    for i in 0..m {
        for j in 0..n {
            let (a, b) = (i as f64 / m as f64 * std::f64::consts::TAU, j as f64 / n as f64 * std::f64::consts::TAU);
            let r = 2.0 + 0.7 * b.cos();
            let w = if i * n + j == 3 { odd } else { "1" };
            text += &format!("{} {} {} {w}\n", r * a.cos(), r * a.sin(), 0.7 * b.sin());
        }
    }
    for i in 0..m {
        for j in 0..n {
            let at = |i: usize, j: usize| (i % m) * n + j % n;
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            text += &format!("3 {a} {b} {c}\n3 {a} {c} {d}\n");
        }
    }
    text
}

#[test]
fn costs_bases_and_forbidden_vertices_are_looked_up() {
    let bench = Bench::new();
    bench.write("t.ply", torus_with_attribute("0"));
    bench.line("tile t.ply --cost attribute:w -o a.obj").succeeds();
    bench.line("tile t.ply --cost curvature:0.8 --search exact -o a.obj").succeeds();
    bench.line("tile t.ply --into quads --base 17 -o a.obj --layout a.json").succeeds();
    assert_eq!(json(&bench, "a.json")["nodes"][0]["vertex"], 17);
    let ran = bench.line("tile t.ply --cost attribute:nope -o b.obj");
    ran.fails_with(4, &[]);
    assert!(ran.stderr.contains("nope") && ran.stderr.contains('w'), "{}", ran.stderr);
    bench.line("tile t.ply --base 96 -o b.obj").fails_with(4, &[]);
    for bad in ["-2", "nan"] {
        bench.write("bad.ply", torus_with_attribute(bad));
        bench.line("tile bad.ply --cost attribute:w -o b.obj").fails_with(4, &[]);
    }
    // Only vertex 3 may be cut through: there is no way.
    bench.line("tile t.ply --forbid w -o b.obj").fails_with(5, &[]);
    bench.line("tile t.ply --cost curvature:2 -o b.obj").fails_with(2, &[]);
    assert!(!bench.path("b.obj").exists());
}

#[test]
fn given_cuts_are_disks_or_refused() {
    let bench = Bench::new();
    bench.write("t.ply", torus_with_attribute("1"));
    let ring = |points: Vec<usize>| -> String {
        let next = points.iter().cycle().skip(1);
        points.iter().zip(next).map(|(a, b)| format!("{a} {b}\n")).collect()
    };
    let (through, around) = (ring((0..8).collect()), ring((0..12).map(|i| 8 * i).collect()));
    bench.write("one.txt", through.clone());
    bench.write("both.txt", format!("{through}{around}"));
    bench.line("tile t.ply --cut both.txt --into quads -o a.obj --report r.json").succeeds();
    assert_eq!(json(&bench, "r.json")["sides"], serde_json::json!([4]));
    let ran = bench.line("tile t.ply --cut one.txt -o b.obj");
    ran.fails_with(4, &[]);
    assert!(ran.stderr.contains("2 boundaries"), "{}", ran.stderr);
    bench.write("far.txt", "0 50\n");
    bench.line("tile t.ply --cut far.txt -o b.obj").fails_with(4, &[]);
    bench.line("tile t.ply --cut both.txt --into pants -o b.obj").fails_with(4, &[]);
}

#[test]
fn what_cannot_be_tiled_says_what_to_use_instead() {
    let bench = Bench::new();
    for (line, code, says) in [
        ("tile sample:sphere --into quads -o a.obj", 4, "remesh"),
        ("tile sample:sphere --into schema -o a.obj", 4, "Algorithm 1"),
        ("tile sample:torus --into pants -o a.obj", 4, "chi = 0"),
        ("tile sample:plate --method single-point -o a.obj", 4, "Algorithms 1 and 3"),
        ("tile sample:two_spheres --into quads -o a.obj", 4, "component 0"),
        ("tile sample:torus -o a.ply", 2, ".obj"),
        ("tile sample:torus --into nonsense -o a.obj", 2, "pants"),
    ] {
        let ran = bench.line(line);
        ran.fails_with(code, &[]);
        assert!(ran.stderr.contains(says), "{line}: {}", ran.stderr);
    }
    // A Möbius band has no two sides.
    let mut band = String::new();
    for i in 0..8 {
        let a = f64::from(i) / 8.0 * std::f64::consts::TAU;
        for s in [-0.3, 0.3] {
            let r = 1.0 + s * (0.5 * a).cos();
            band += &format!("v {} {} {}\n", r * a.cos(), r * a.sin(), s * (0.5 * a).sin());
        }
    }
    for i in 0..8 {
        let (a, b) = (2 * i + 1, 2 * i + 2);
        let (c, d) = if i < 7 { (2 * i + 3, 2 * i + 4) } else { (2, 1) };
        band += &format!("f {a} {c} {b}\nf {b} {c} {d}\n");
    }
    bench.write("band.obj", band);
    let ran = bench.line("tile band.obj -o a.obj");
    ran.fails_with(4, &[]);
    assert!(ran.stderr.contains("not orientable"), "{}", ran.stderr);
    assert!(!bench.path("a.obj").exists());
}

#[test]
fn threads_change_no_byte_and_limits_leave_no_file() {
    let bench = Bench::new();
    for threads in [1, 2] {
        bench
            .line(&format!("tile sample:holes --into quads --parametrize fixed -o t{threads}.obj --threads {threads}"))
            .succeeds();
    }
    assert_eq!(bench.read("t1.obj"), bench.read("t2.obj"));
    bench
        .line("tile sample:lattice --into cylinders --search exact --time-limit 0.000001 -o late.obj")
        .fails_with(7, &[]);
    assert!(!bench.path("late.obj").exists());
}
