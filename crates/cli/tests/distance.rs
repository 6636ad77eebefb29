//! `quadloom distance`: files, options, exit codes.

mod common;

use common::Bench;
use serde_json::Value;

/// Vertices and triangles of a square of `n` by `n` cells of side 1, as an OBJ.
fn square(n: usize) -> String {
    let mut text = String::new();
    for k in 0..(n + 1) * (n + 1) {
        text += &format!("v {} {} 0\n", k % (n + 1), k / (n + 1));
    }
    for k in 0..n * n {
        let a = k / n * (n + 1) + k % n + 1;
        text += &format!("f {a} {} {}\nf {a} {} {}\n", a + 1, a + n + 2, a + n + 2, a + n + 1);
    }
    text
}

/// Rows of a file of distances: vertex, distance, source.
fn rows(bench: &Bench, name: &str) -> Vec<(usize, f64, Option<usize>)> {
    let text = String::from_utf8(bench.read(name)).unwrap();
    let (head, rest) = text.split_once('\n').unwrap();
    assert_eq!(head, "vertex,distance,source");
    let row = |line: &str| {
        let mut cells = line.split(',');
        let mut next = || cells.next().unwrap();
        (next().parse().unwrap(), next().parse().unwrap(), next().parse().ok())
    };
    rest.lines().map(row).collect()
}

fn report(bench: &Bench, name: &str) -> Value {
    serde_json::from_slice(&bench.read(name)).unwrap()
}

#[test]
fn rows_are_those_of_the_input() {
    let bench = Bench::new();
    // An unused vertex first, and a second component that no source reaches.
    let plane = square(6).replace("f ", "f +").lines().map(shifted).collect::<Vec<_>>().join("\n");
    bench.write("in.obj", format!("v 9 9 9\n{plane}\nv 20 0 0\nv 21 0 0\nv 20 1 0\nf 51 52 53\n"));
    let ran = bench.line("distance in.obj --from vertices:1 --from point:6,6,0 --start 0,2 -o d.csv --report r.json");
    ran.succeeds();
    assert!(ran.stderr.contains("without a source"), "{}", ran.stderr);
    let rows = rows(&bench, "d.csv");
    assert_eq!(rows.len(), 53);
    for (k, &(vertex, distance, source)) in rows.iter().enumerate() {
        assert_eq!(vertex, k);
        if k == 0 || k > 49 {
            assert!(distance.is_infinite() && source.is_none(), "{k}: {distance} {source:?}");
            continue;
        }
        let (x, y) = (((k - 1) % 7) as f64, ((k - 1) / 7) as f64);
        let both = [x.hypot(y), 2.0 + (6.0 - x).hypot(6.0 - y)];
        assert!((distance - both[0].min(both[1])).abs() < 1e-12, "{k}: {distance} {both:?}");
        assert!((both[source.unwrap()] - distance).abs() < 1e-12);
    }
    let report = report(&bench, "r.json");
    assert_eq!(report["distance"]["unreached"], 3);
    assert_eq!(report["distance"]["sources"][1]["start"], 2.0);
}

/// A line of an OBJ with its corners one higher.
fn shifted(line: &str) -> String {
    match line.strip_prefix("f +") {
        None => line.to_string(),
        Some(corners) => {
            let corners = corners.split_whitespace().map(|c| (c.parse::<usize>().unwrap() + 1).to_string());
            format!("f {}", corners.collect::<Vec<_>>().join(" "))
        }
    }
}

#[test]
fn curves_come_from_obj_and_json() {
    let bench = Bench::new();
    bench.write("in.obj", square(8));
    bench.write("line.obj", "v 0 3 0\nv 8 3 0\nl 1 2\n");
    bench.write("line.json", "[[[0, 3, 0], {\"point\": [5, 3, 0]}, {\"face\": 126, \"weights\": [0, 1, 0]}]]");
    bench.line("distance in.obj --from curve:line.obj -o a.csv").succeeds();
    bench.line("distance in.obj --from curve:line.json -o b.csv").succeeds();
    for (k, distance, _) in rows(&bench, "a.csv") {
        assert!((distance - ((k / 9) as f64 - 3.0).abs()).abs() < 1e-12, "{k}: {distance}");
    }
    // Face 126 is the last cell's first: its second corner is (8, 7).
    for (k, distance, _) in rows(&bench, "b.csv") {
        let (x, y) = ((k % 9) as f64, (k / 9) as f64);
        let t = (((x - 5.0) * 3.0 + (y - 3.0) * 4.0) / 25.0).clamp(0.0, 1.0);
        let second = (x - 5.0 - 3.0 * t).hypot(y - 3.0 - 4.0 * t);
        let first = (x - 5.0).max(0.0).hypot(y - 3.0);
        assert!((distance - first.min(second)).abs() < 1e-12, "{k}: {distance} {first} {second}");
    }
}

#[test]
fn boundary_and_sharp_edges() {
    let bench = Bench::new();
    bench.write("in.obj", square(8));
    bench.line("distance in.obj --from boundary -o d.csv").succeeds();
    for (k, distance, _) in rows(&bench, "d.csv") {
        let (x, y) = ((k % 9) as f64, (k / 9) as f64);
        assert!((distance - x.min(y).min(8.0 - x).min(8.0 - y)).abs() < 1e-12);
    }
    bench.line("distance sample:cube --from features -o c.csv --report r.json").succeeds();
    // The cube's middle points are half a side from its edges.
    let side = report(&bench, "r.json")["distance"]["largest_distance"].as_f64().unwrap();
    assert!((side - 0.5).abs() < 0.05, "{side}");
    bench.line("distance sample:sphere --from boundary -o x.csv").fails_with(4, &["no boundary", "name vertices"]);
    bench.line("distance sample:sphere --from features -o x.csv").fails_with(4, &["35 degrees", "smaller angle"]);
}

#[test]
fn refinement_keeps_the_vertices_of_the_input() {
    let bench = Bench::new();
    bench.write("in.obj", square(7));
    bench.line("distance in.obj --from boundary -o fine.obj --refine 0.01 --report r.json").succeeds();
    let refinement = report(&bench, "r.json")["distance"]["refinement"].clone();
    assert!(refinement["reached"] == true && refinement["largest_error"].as_f64() <= Some(0.01), "{refinement}");
    assert!(refinement["new_smallest_angle"].as_f64() >= Some(1.0) && refinement["faces_before"] == 98);
    let fine = String::from_utf8(bench.read("fine.obj")).unwrap();
    let vertices: Vec<&str> = fine.lines().filter(|l| l.starts_with("v ")).collect();
    assert_eq!(Some(vertices.len() as u64), refinement["vertices"].as_u64());
    assert!(vertices[9].starts_with("v 1 1 0"), "{}", vertices[9]);
    bench.line("check fine.obj").succeeds();
    bench.line("distance in.obj --from boundary -o fine.vtu --refine 0.01").succeeds();
    assert!(String::from_utf8_lossy(&bench.read("fine.vtu")).contains("distance"));
    bench.line("distance in.obj --from boundary -o fine.ply --refine 0.01").succeeds();
    // The rows of a table stay those of the input.
    bench.line("distance in.obj --from boundary -o fine.csv --refine 0.01").succeeds();
    assert_eq!(rows(&bench, "fine.csv").len(), 64);
}

#[test]
fn lines_paths_and_pages() {
    let bench = Bench::new();
    bench.write("in.obj", square(8));
    let common = "distance in.obj --from vertices:0 -o d.csv";
    bench
        .line(&format!(
            "{common} --isolines 4 --path-from vertices:80 --path-from point:8,0,0 --view p.html --report r.json"
        ))
        .succeeds();
    assert_eq!(bench.files(), ["d.csv", "d.isolines.obj", "d.paths.obj", "in.obj", "p.html", "r.json"]);
    let lengths = report(&bench, "r.json")["distance"]["path_lengths"].clone();
    assert!((lengths[0].as_f64().unwrap() - 128f64.sqrt()).abs() < 1e-12 && lengths[1].as_f64() == Some(8.0));
    // Isolines of a point are circles: their points are as far as their value.
    let lines = String::from_utf8(bench.read("d.isolines.obj")).unwrap();
    let numbers = |l: &str| -> Vec<f64> { l.split_whitespace().skip(1).map(|x| x.parse().unwrap()).collect() };
    let points: Vec<Vec<f64>> = lines.lines().filter(|l| l.starts_with("v ")).map(numbers).collect();
    let values: Vec<f64> = lines.lines().filter_map(|l| l.strip_prefix("# ")).map(|v| v.parse().unwrap()).collect();
    assert_eq!(values.len(), 4);
    let step = 128f64.sqrt() / 5.0;
    for p in &points {
        let (d, k) = (p[0].hypot(p[1]), (p[0].hypot(p[1]) / step).round());
        assert!((d - k * step).abs() < 0.06 * step, "{p:?}");
    }
    bench
        .line(&format!("{common} --isolines 2.5 --isolines-to lines.svg --paths-to p.svg --path-from vertices:8"))
        .succeeds();
    assert!(bench.read("lines.svg").starts_with(b"<svg") && bench.read("p.svg").starts_with(b"<svg"));
}

#[test]
fn the_bytes_do_not_depend_on_threads() {
    let bench = Bench::new();
    for threads in ["1", "2"] {
        let line = format!("distance sample:bumpy_torus --from vertices:5 --from boundaryless --threads {threads}");
        bench.line(&line).fails_with(2, &["curve:FILE"]);
        let line = format!(
            "distance sample:bumpy_torus --from vertices:5 --from point:1,0,0 --snap 1 --refine 0.01 -o t{threads}.ply \
             --isolines 9 --view t{threads}.html --threads {threads}"
        );
        bench.line(&line).succeeds();
    }
    assert_eq!(bench.read("t1.ply"), bench.read("t2.ply"));
    assert_eq!(bench.read("t1.isolines.obj"), bench.read("t2.isolines.obj"));
}

#[test]
fn an_approximation_is_within_its_promise() {
    let bench = Bench::new();
    bench.line("distance sample:bumpy_sphere --from vertices:3 -o exact.csv").succeeds();
    bench.line("distance sample:bumpy_sphere --from vertices:3 -o near.csv --epsilon 0.01").succeeds();
    for ((_, exact, _), (_, near, _)) in rows(&bench, "exact.csv").into_iter().zip(rows(&bench, "near.csv")) {
        assert!(near <= exact * (1.0 + 1e-12) && near >= exact * 0.99 - 1e-15, "{near} for {exact}");
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let bench = Bench::new();
    bench.write("in.obj", square(4));
    bench.write("far.json", "[[[0, 0, 0], [90, 0, 0]]]");
    bench.write("bad.json", "[[[0, 0, \"x\"]]]");
    bench.write("two.obj", format!("{}v 20 0 0\nv 21 0 0\nv 20 1 0\nf 26 27 28\n", square(4)));
    bench.write("across.json", "[[[0, 0, 0], [20, 0, 0]]]");
    let refused = |code: i32, line: &str, words: &[&str]| bench.line(line).fails_with(code, words);
    // 1. Usage.
    refused(2, "distance in.obj -o d.csv", &["--from"]);
    refused(2, "distance in.obj --from vertices:0 -o d.txt", &["d.txt", ".csv"]);
    refused(2, "distance in.obj --from vertices:x -o d.csv", &["vertex numbers"]);
    refused(2, "distance in.obj --from vertices:0 -o d.csv --epsilon 1", &["--epsilon"]);
    refused(2, "distance in.obj --from vertices:0 -o d.csv --refine 0", &["--refine"]);
    refused(2, "distance in.obj --from vertices:0 -o d.csv --isolines 0", &["--isolines"]);
    refused(2, "distance in.obj --from vertices:0 --start 0,1 -o d.csv", &["--start", "one number for each --from"]);
    refused(2, "distance in.obj --from vertices:0 -o in.obj", &["in.obj", "the input"]);
    // 2. Files.
    refused(3, "distance none.obj --from vertices:0 -o d.csv", &["none.obj"]);
    refused(3, "distance in.obj --from curve:none.json -o d.csv", &["none.json"]);
    // 3. What does not fit the input.
    refused(4, "distance in.obj --from vertices:0,25 -o d.csv", &["no vertex 25", "the last one is 24"]);
    refused(4, "distance in.obj --from point:0,0,9 -o d.csv", &["away from the surface", "--snap"]);
    refused(4, "distance in.obj --from curve:far.json -o d.csv", &["away from the surface"]);
    refused(4, "distance two.obj --from curve:across.json -o d.csv", &["different components"]);
    refused(4, "distance in.obj --from vertices:0 --path-from boundary -o d.csv", &["--path-from", "points"]);
    assert_eq!(bench.line("distance in.obj --from curve:bad.json -o d.csv").code / 3, 1, "3 or 4");
    assert!(!bench.files().iter().any(|f| f.ends_with(".csv")), "{:?}", bench.files());
    // 4. What misses a request is written.
    let missed = bench.line("distance two.obj --from vertices:0 --path-from vertices:26 -o d.csv");
    assert_eq!(missed.code, 6, "{}", missed.stderr);
    assert!(missed.stderr.contains("no source reaches") && bench.files().contains(&"d.csv".into()));
}
