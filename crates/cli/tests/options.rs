//! What the options of `remesh` do to the quads.

mod common;

use common::{Bench, read_quads, topology};
use serde_json::Value;

/// Points and triangles of a generated shape.
fn shape(bench: &Bench, name: &str) -> (Vec<[f64; 3]>, Vec<Vec<usize>>) {
    bench.line(&format!("convert sample:{name} {name}.obj")).succeeds();
    let text = String::from_utf8(bench.read(&format!("{name}.obj"))).expect("text");
    let (mut points, mut faces) = (Vec::new(), Vec::new());
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["v", x, y, z] => points.push([x, y, z].map(|w| w.parse().expect("a number"))),
            ["f", ref corners @ ..] => {
                let index = |w: &&str| w.split('/').next().and_then(|i| i.parse::<usize>().ok()).expect("an index") - 1;
                faces.push(corners.iter().map(index).collect());
            }
            _ => {}
        }
    }
    (points, faces)
}

fn write_obj(bench: &Bench, name: &str, points: &[[f64; 3]], faces: &[Vec<usize>]) {
    let mut text: String = points.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
    for face in faces {
        text += &format!("f {}\n", face.iter().map(|v| (v + 1).to_string()).collect::<Vec<_>>().join(" "));
    }
    bench.write(name, text);
}

fn report(bench: &Bench, name: &str) -> Value {
    serde_json::from_slice(&bench.read(name)).expect("JSON")
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn norm(a: [f64; 3]) -> f64 {
    a.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Centre, and the mean lengths of both pairs of opposite sides, longer first.
fn measure(points: &[[f64; 3]], quad: &[usize; 4]) -> ([f64; 3], [f64; 2]) {
    let p = quad.map(|v| points[v]);
    let centre = [0, 1, 2].map(|k| p.iter().map(|q| q[k]).sum::<f64>() / 4.0);
    let side = |k: usize| norm(sub(p[(k + 1) % 4], p[k]));
    let pair = [0.5 * (side(0) + side(2)), 0.5 * (side(1) + side(3))];
    (centre, [pair[0].max(pair[1]), pair[0].min(pair[1])])
}

/// A tube around the z axis, twice as wide at one end as in the middle and half as wide at the other.
fn horn(bench: &Bench) {
    let (points, faces) = shape(bench, "cylinder");
    let [low, high] =
        [f64::min as fn(f64, f64) -> f64, f64::max].map(|pick| points.iter().map(|p| p[2]).fold(points[0][2], pick));
    let width = |z: f64| 0.4 + 1.2 * (z - low) / (high - low);
    let bent: Vec<[f64; 3]> = points.iter().map(|p| [p[0] * width(p[2]), p[1] * width(p[2]), 2.0 * p[2]]).collect();
    write_obj(bench, "horn.obj", &bent, &faces);
}

/// Mean length of the quads' sides in the lowest and in the highest quarter along z.
fn sizes_at_the_ends(bench: &Bench, name: &str) -> [f64; 2] {
    let (points, quads) = read_quads(&bench.path(name));
    let z = |pick: fn(f64, f64) -> f64| points.iter().map(|p| p[2]).fold(points[0][2], pick);
    let (low, high) = (z(f64::min), z(f64::max));
    let quarter = 0.25 * (high - low);
    let mean = |inside: &dyn Fn(f64) -> bool| {
        let sizes: Vec<f64> = quads
            .iter()
            .map(|q| measure(&points, q))
            .filter(|(c, _)| inside(c[2]))
            .map(|(_, [a, b])| (a * b).sqrt())
            .collect();
        sizes.iter().sum::<f64>() / sizes.len() as f64
    };
    [mean(&|z| z < low + quarter), mean(&|z| z > high - quarter)]
}

#[test]
fn sizes_follow_the_local_feature_size() {
    let bench = Bench::new();
    horn(&bench);
    // Rows around the horn are wider at its wide end whatever is asked for; along it, only graded quads are longer.
    let ratio = |options: &str| {
        bench.line(&format!("remesh horn.obj -o out.obj --quads 1200 --tolerance 30 {options}")).succeeds();
        let [thin, wide] = sizes_at_the_ends(&bench, "out.obj");
        wide / thin
    };
    let (even, graded) = (ratio(""), ratio("--adaptivity 1 --adapt-to feature-size"));
    assert!(graded > 1.2 * even, "{even} {graded}");
}

#[test]
fn sizes_follow_a_vertex_attribute() {
    let bench = Bench::new();
    let (points, faces) = shape(&bench, "torus");
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\nproperty \
         double wanted\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        points.len(),
        faces.len()
    );
    for [x, y, z] in &points {
        text += &format!("{x} {y} {z} {}\n", if *x > 0.0 { 4.0 } else { 1.0 });
    }
    for f in &faces {
        text += &format!("3 {} {} {}\n", f[0], f[1], f[2]);
    }
    bench.write("torus.ply", text);
    bench.line("remesh torus.ply -o out.obj --quads 1000 --tolerance 30 --density wanted").succeeds();
    let (points, quads) = read_quads(&bench.path("out.obj"));
    let right = quads.iter().filter(|q| measure(&points, q).0[0] > 0.0).count();
    assert!(right as f64 > 1.6 * (quads.len() - right) as f64, "{right} of {}", quads.len());
    bench.line("remesh torus.ply -o out.obj --density height").fails_with(4, &["height", "wanted"]);
    for bad in ["-1", "nan"] {
        let text = std::fs::read_to_string(bench.path("torus.ply")).expect("the file").replacen(
            " 4\n",
            &format!(" {bad}\n"),
            1,
        );
        bench.write("bad.ply", text);
        bench
            .line("remesh bad.ply -o out.obj --density wanted")
            .fails_with(4, &["`wanted`", "at vertex 0", "zero and more"]);
    }
}

#[test]
fn quads_stretch_along_straight_directions() {
    let bench = Bench::new();
    let aspect = |name: &str| {
        let (points, quads) = read_quads(&bench.path(name));
        quads.iter().map(|q| measure(&points, q).1).map(|[a, b]| a / b).sum::<f64>() / quads.len() as f64
    };
    bench.line("remesh sample:cylinder -o square.obj --quads 800 --tolerance 30").succeeds();
    bench.line("remesh sample:cylinder -o long.obj --quads 800 --tolerance 30 --anisotropy 1").succeeds();
    let [square, long] = ["square.obj", "long.obj"].map(aspect);
    assert!(square < 1.3 && long > 1.5, "{square} {long}");
}

#[test]
fn a_drawn_curve_is_followed() {
    let bench = Bench::new();
    let arc: Vec<String> = (0..=24)
        .map(|i| f64::from(i) * 0.1)
        .map(|t| format!("{{\"point\":[{},{},{}]}}", t.cos() * 0.8, t.sin() * 0.8, 0.6))
        .collect();
    bench.write("arc.json", format!("[[{}]]", arc.join(",")));
    bench
        .line("remesh sample:sphere -o out.obj --quads 800 --tolerance 30 --guides arc.json --report r.json")
        .succeeds();
    let features = &report(&bench, "r.json")["features"];
    assert!(features["chains"].as_u64() > Some(0), "{features}");
    assert_eq!(features["chains"], features["chains_kept"]);
}

#[test]
fn prescribed_singular_vertices_are_the_irregular_ones() {
    let bench = Bench::new();
    let (points, _) = shape(&bench, "sphere");
    // The corners of a cube, turned so that no symmetry of the sphere's triangles helps.
    let mut text = String::new();
    let mut wanted = Vec::new();
    for corner in 0..8 {
        let [x, y, z] = [0, 1, 2].map(|k| if corner >> k & 1 == 0 { -1.0 } else { 1.0 } / 3.0_f64.sqrt());
        let (sin, cos) = 0.4_f64.sin_cos();
        let goal = [cos * x - sin * y, sin * x + cos * y, z];
        let near = |p: &[f64; 3]| norm(sub(*p, goal));
        let (v, p) = points.iter().enumerate().min_by(|a, b| near(a.1).total_cmp(&near(b.1))).expect("a vertex");
        text += &format!("{v} 1\n");
        wanted.push(*p);
    }
    bench.write("corners.txt", text);
    bench.line("remesh sample:sphere -o out.obj --quads 600 --singularities corners.txt").succeeds();
    let (points, quads) = read_quads(&bench.path("out.obj"));
    let mut valence = vec![0; points.len()];
    quads.iter().flatten().for_each(|&v| valence[v] += 1);
    let irregular: Vec<usize> = (0..points.len()).filter(|&v| valence[v] != 4).collect();
    assert_eq!(irregular.len(), 8);
    for v in irregular {
        let off = wanted.iter().map(|&w| norm(sub(points[v], w))).fold(f64::INFINITY, f64::min);
        assert!(off < 1e-9, "an irregular vertex {off} from the next prescribed one");
    }
}

#[test]
fn a_written_list_of_singular_vertices_can_be_given_back() {
    let bench = Bench::new();
    bench.line("field sample:genus2 -o g.rosy --write-singularities g.sing").succeeds();
    bench.line("remesh sample:genus2 -o out.obj --quads 1500 --singularities g.sing --report r.json").succeeds();
    let summary = &report(&bench, "r.json")["singularities"];
    let given = summary["given"].as_array().expect("a list");
    assert!(given.len() >= 8 && summary["others"] == 0, "{summary}");
    // Seen in the quads without the project's own reader.
    let (points, quads) = read_quads(&bench.path("out.obj"));
    let mut valence = vec![0; points.len()];
    quads.iter().flatten().for_each(|&v| valence[v] += 1);
    assert_eq!(valence.iter().filter(|&&n| n != 4).count(), given.len());
    // There are no curves on it, so that each is exactly where it was given.
    let (surface, _) = shape(&bench, "genus2");
    for s in given {
        let at = surface[s["vertex"].as_u64().expect("a number") as usize];
        let wanted = 4 - s["quarters"].as_i64().expect("an index");
        let there = |v: &usize| i64::from(valence[*v]) == wanted && norm(sub(points[*v], at)) < 1e-9;
        assert!((0..points.len()).any(|v| there(&v)), "{s}");
    }
}

#[test]
fn singular_vertices_that_nobody_listed_are_told_unless_they_are_welcome() {
    let bench = Bench::new();
    // A tube with one vertex of valence 3 needs others: both boundaries are straight in the field.
    let (points, _) = shape(&bench, "cylinder");
    let height = |pick: fn(f64, f64) -> f64| points.iter().map(|p| p[2]).fold(points[0][2], pick);
    let middle = 0.5 * (height(f64::min) + height(f64::max));
    let off = |v: &usize| (points[*v][2] - middle).abs();
    let v = (0..points.len()).min_by(|a, b| off(a).total_cmp(&off(b))).expect("a vertex");
    bench.write("one.txt", format!("{v} 1\n"));
    let line = "remesh sample:cylinder -o out.obj --quads 600 --tolerance 30 --singularities one.txt";
    let ran = bench.line(line);
    ran.fails_by_missing(&["besides the given ones", "--other-singularities"]);
    bench.line(&format!("{line} --other-singularities --report r.json")).succeeds();
    let summary = &report(&bench, "r.json")["singularities"];
    assert_eq!(summary["given"][0]["found"], true, "{summary}");
    assert!(summary["others"].as_u64() > Some(0), "{summary}");
}

#[test]
fn ties_come_from_a_file_too() {
    let bench = Bench::new();
    bench.write("ties.txt", "# a torus has nothing to tie\n5, 77\n9 100\n");
    let ran = bench.line("remesh sample:torus -o out.obj --quads 400 --ties ties.txt --tie 1,2 --report r.json");
    ran.fails_by_missing(&["vertices 5 and 77", "no irregular vertex", "vertices 1 and 2"]);
    let report = report(&bench, "r.json");
    assert_eq!(report["ties"].as_array().map(Vec::len), Some(3));
    assert_eq!(report["ties"][1]["missed"], "nothing_irregular");
    assert!(report["units"]["distance"].as_str().is_some_and(|u| u.contains("percent")), "{}", report["units"]);
}

#[test]
fn a_default_count_says_why_it_is_that() {
    let bench = Bench::new();
    bench.write("one.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let ran = bench.line("remesh one.obj -o out.obj");
    assert!(ran.stderr.contains("aimed at 500 quads, the fewest"), "{}", ran.stderr);
    let ran = bench.line("remesh sample:torus -o out.obj");
    assert!(ran.stderr.contains("a quarter of the triangles"), "{}", ran.stderr);
}

#[test]
fn distances_have_their_unit() {
    let bench = Bench::new();
    bench.line("remesh sample:torus -o out.obj --quads 400").succeeds();
    let ran = bench.line("stats out.obj --reference sample:torus");
    ran.succeeds();
    assert!(ran.stdout.contains("% of the reference's diagonal"), "{}", ran.stdout);
    let ran = bench.line("stats out.obj --reference sample:torus --json");
    let stats: Value = serde_json::from_str(&ran.stdout).expect("JSON");
    assert!(stats["distance"]["unit"].as_str().is_some_and(|u| u.contains("percent")), "{stats}");
    let largest = stats["distance"]["to_reference"]["max"].as_f64().expect("a number");
    assert!(largest > 0.0 && largest < 2.0, "{largest}");
    bench.line("stats sample:sphere --reference sample:torus").fails_with(4, &["--reference", "quads"]);
}

#[test]
fn quads_in_a_format_of_triangles_are_split_aloud() {
    let bench = Bench::new();
    bench.line("remesh sample:torus -o out.obj --quads 400").succeeds();
    for name in ["out.stl", "out.glb"] {
        let ran = bench.line(&format!("convert out.obj {name}"));
        ran.succeeds();
        assert!(ran.stderr.contains("triangles only") && ran.stderr.contains("were split"), "{}", ran.stderr);
    }
}

#[test]
fn a_written_field_can_be_given_back() {
    let bench = Bench::new();
    bench.line("remesh sample:genus2 -o first.obj --quads 800 --write-field field.rosy").succeeds();
    bench.line("remesh field.rosy.obj --field field.rosy -o second.obj --quads 800 --report r.json").succeeds();
    let field = &report(&bench, "r.json")["field"];
    assert_eq!(field["singularities_kept"], true, "{field}");
    assert!(field["given_singularities"].as_u64() >= Some(8), "{field}");
}

#[test]
fn lengths_and_scales_are_means() {
    let bench = Bench::new();
    let (points, faces) = shape(&bench, "cube");
    let sides = faces.iter().flat_map(|f| [[f[0], f[1]], [f[1], f[2]], [f[2], f[0]]]);
    let mean = sides.map(|[a, b]| norm(sub(points[a], points[b]))).sum::<f64>() / (3 * faces.len()) as f64;
    let area = 6.0
        * (points.iter().map(|p| p[0]).fold(0.0, f64::max) - points.iter().map(|p| p[0]).fold(0.0, f64::min)).powi(2);
    for (size, length) in [("--edge-length 0.2", 0.2), ("--scale 4", 4.0 * mean)] {
        bench.line(&format!("remesh sample:cube -o out.obj {size} --report r.json")).succeeds();
        let (_, quads) = read_quads(&bench.path("out.obj"));
        let wanted = area / (length * length);
        let asked = report(&bench, "r.json")["count"]["asked"].as_f64().expect("a count");
        assert!((asked - wanted).abs() <= 0.5 + 1e-6 * wanted, "{size}: {asked} for {wanted}");
        assert!((quads.len() as f64 / asked - 1.0).abs() <= 0.1, "{size}: {} of {asked}", quads.len());
    }
}

#[test]
fn a_tighter_tolerance_is_met_or_missed_aloud() {
    let bench = Bench::new();
    let ran = bench.line("remesh sample:torus -o out.obj --quads 700 --tolerance 2");
    let (_, quads) = read_quads(&bench.path("out.obj"));
    let met = (quads.len() as f64 / 700.0 - 1.0).abs() <= 0.02;
    assert_eq!(ran.code, if met { 0 } else { 6 }, "{} quads: {}", quads.len(), ran.stderr);
    assert_eq!(ran.stderr.contains("instead of 700"), !met, "{}", ran.stderr);
}

#[test]
fn free_boundaries_and_direct_rounding_keep_the_topology() {
    let bench = Bench::new();
    for options in ["--keep-boundary false", "--method direct"] {
        bench.line(&format!("remesh sample:cylinder -o out.obj --quads 400 --tolerance 30 {options}")).succeeds();
        let (points, quads) = read_quads(&bench.path("out.obj"));
        let (chi, components, boundary) = topology(points.len(), &quads);
        assert_eq!((chi, components), (0, 1), "{options}");
        assert!(boundary > 0, "{options}");
    }
}

#[test]
fn components_get_shares_by_their_area() {
    let bench = Bench::new();
    let (points, faces) = shape(&bench, "sphere");
    let (mut all, mut sides) = (Vec::new(), Vec::new());
    for (i, radius) in [1.0, 2.0, 3.0].into_iter().enumerate() {
        all.extend(points.iter().map(|p| [radius * p[0] + 8.0 * i as f64, radius * p[1], radius * p[2]]));
        sides.extend(faces.iter().map(|f| f.iter().map(|v| v + i * points.len()).collect::<Vec<_>>()));
    }
    write_obj(&bench, "three.obj", &all, &sides);
    bench.line("remesh three.obj -o out.obj --quads 1400 --report r.json").succeeds();
    let report = report(&bench, "r.json");
    let reached: Vec<f64> = report["components"]
        .as_array()
        .expect("components")
        .iter()
        .map(|c| c["reached"].as_f64().expect("a count"))
        .collect();
    for (reached, share) in reached.iter().zip([100.0, 400.0, 900.0]) {
        assert!((reached / share - 1.0).abs() < 0.2, "{reached} quads for a share of {share}");
    }
    let (points, quads) = read_quads(&bench.path("out.obj"));
    assert_eq!(topology(points.len(), &quads), (6, 3, 0));
}

#[test]
fn sizes_that_no_machine_holds_are_refused() {
    let bench = Bench::new();
    for size in ["--quads 99999999999", "--edge-length 1e-9"] {
        bench.line(&format!("remesh sample:torus -o torus.obj {size}")).fails_with(2, &["more than", "longer edges"]);
    }
}

#[test]
fn an_empty_list_asks_for_no_singular_vertex() {
    let bench = Bench::new();
    bench.write("none.sing", "4 0\n");
    bench.write("none.txt", "# none\n");
    bench.write("empty.txt", "");
    for list in ["none.sing", "none.txt", "empty.txt"] {
        let line = format!("remesh sample:torus -o out.obj --quads 400 --singularities {list} --report r.json");
        bench.line(&line).succeeds();
        let (points, quads) = read_quads(&bench.path("out.obj"));
        let mut valence = vec![0; points.len()];
        quads.iter().flatten().for_each(|&v| valence[v] += 1);
        assert!(valence.iter().all(|&n| n == 4), "{list}");
        let summary = &report(&bench, "r.json")["singularities"];
        assert_eq!((summary["given"].as_array().map(Vec::len), &summary["others"]), (Some(0), &Value::from(0)));
    }
    let refused = ["empty.txt", "sum to 0 quarters", "needs 8"];
    bench.line("remesh sample:sphere -o out.obj --singularities empty.txt").fails_with(4, &refused);
    bench.line("field sample:sphere -o out.rosy --singularities empty.txt").fails_with(4, &refused[1..]);
    bench.write("turns.txt", "0 1.0\n");
    let turns = bench.line("remesh sample:torus -o out.obj --singularities turns.txt");
    turns.fails_with(3, &["turns.txt", "line 1", "whole number of quarters"]);
}

#[test]
fn curves_that_are_elsewhere_and_edges_that_are_not_there_are_told() {
    let bench = Bench::new();
    bench.write("far.json", "[[[0,0,90],[9,0,90]]]");
    let line = "remesh sample:torus -o out.obj --quads 300 --tolerance 90 --report r.json --guides";
    bench.line(&format!("{line} far.json")).fails_by_missing(&["1 of 1 drawn curves (--guides) are far"]);
    assert!(report(&bench, "r.json")["warnings"].to_string().contains("guide_far"));
    // One that holds beside one that does not.
    let meridian: Vec<String> = (0..=24)
        .map(|i| f64::from(i) * std::f64::consts::TAU / 24.0)
        .map(|t| format!("[{},0,{}]", 1.0 + 0.4 * t.cos(), 0.4 * t.sin()))
        .collect();
    bench.write("one.json", format!("[[{}]]", meridian.join(",")));
    bench.line(&format!("{line} one.json")).succeeds();
    bench.write("both.json", format!("[[{}],[[0,0,90],[9,0,90]]]", meridian.join(",")));
    bench.line(&format!("{line} both.json")).fails_by_missing(&["1 of 2 drawn curves", "of curve 2 is"]);
    bench.write("dot.json", "[[[1.4,0,0],[1.4,0.0001,0]]]");
    bench.line(&format!("{line} dot.json")).fails_by_missing(&["1 of 1 drawn curves", "shorter than the triangles"]);
    // Along a face of two triangles there is only its diagonal.
    bench.write("coarse.obj", BOX_OF_TWELVE);
    bench.write("across.json", "[[[0.1,0.3,1],[0.9,0.6,1]]]");
    let coarse = bench.line("remesh coarse.obj -o out.obj --quads 500 --guides across.json");
    coarse.fails_by_missing(&["1 of 1 drawn curves", "not followed closely", "refine the surface"]);
    bench.write("none.json", "[]");
    bench.line("remesh sample:torus -o out.obj --guides none.json").fails_with(3, &["none.json", "no curve"]);
    bench.write("pairs.txt", "# edges\n7 300\n");
    let line = "remesh sample:torus -o out.obj --quads 300 --tolerance 90 --features pairs.txt";
    let words = ["first: vertices 7 and 300", "pairs.txt, line 2"];
    bench.line(line).fails_by_missing(&words);
    bench.line("field sample:torus -o out.rosy --features pairs.txt").fails_by_missing(&words);
}

#[test]
fn what_was_asked_for_or_is_not_missed_is_no_warning() {
    let bench = Bench::new();
    let free = bench.line("remesh sample:cylinder -o out.obj --quads 400 --tolerance 30 --keep-boundary false");
    assert!(!free.stderr.contains("no quad edge along"), "{}", free.stderr);
    let vtu = bench.line("remesh sample:torus -o out.vtu --quads 300 --tolerance 30");
    assert!(!vtu.stderr.contains("warning"), "{}", vtu.stderr);
}

#[test]
fn a_default_count_that_is_missed_is_told_with_both_figures() {
    let bench = Bench::new();
    // No map has exactly the number of quads aimed at but by chance.
    let ran = bench.line("remesh sample:torus -o out.obj --tolerance 0.0001 --report r.json");
    let count = &report(&bench, "r.json")["count"];
    if count["error_percent"].as_f64() != Some(0.0) {
        assert_eq!(ran.code, 0, "{}", ran.stderr);
        let both = format!("{} quads were made where {} were aimed at", count["reached"], count["asked"]);
        assert!(ran.stderr.contains(&both), "{both} is not in {}", ran.stderr);
    }
}

#[test]
fn seconds_are_those_of_the_clock() {
    let bench = Bench::new();
    let begin = std::time::Instant::now();
    let ran = bench.line("remesh sample:two_spheres -o out.obj --quads 500 --report r.json");
    ran.succeeds();
    let most = begin.elapsed().as_secs_f64();
    let report = report(&bench, "r.json");
    let total = report["total_seconds"].as_f64().expect("seconds");
    // Milliseconds in the report, hundredths on the screen, both rounded.
    assert!(total > 0.0 && total <= most + 5e-4, "{total} of {most}");
    let said = ran.stderr.lines().last().and_then(|l| l.rsplit(", ").next()?.strip_suffix(" s")?.parse::<f64>().ok());
    assert!(said.is_some_and(|s| s + 0.01 >= total && s <= most + 5e-3), "{} of {most}", ran.stderr);
    assert!(report["units"]["seconds"].as_str().is_some_and(|u| u.contains("summed over components")));
}

#[test]
fn a_tiny_component_beside_a_large_one_has_a_map_and_costs_no_exit_code() {
    let bench = Bench::new();
    let (mut points, mut faces) = shape(&bench, "sphere");
    let count = points.len();
    let small: Vec<[f64; 3]> = points.iter().map(|p| [3.0 + 0.02 * p[0], 0.02 * p[1], 0.02 * p[2]]).collect();
    let copies: Vec<Vec<usize>> = faces.iter().map(|f| f.iter().map(|v| v + count).collect()).collect();
    points.extend(small);
    faces.extend(copies);
    write_obj(&bench, "two.obj", &points, &faces);
    bench.line("remesh two.obj -o out.obj --quads 1000 --report r.json").succeeds();
    let report = report(&bench, "r.json");
    for component in report["components"].as_array().expect("a list") {
        assert_eq!(component["made_by"], "integer-grid map", "{component}");
    }
    let error = report["count"]["error_percent"].as_f64().expect("a number");
    assert!(error.abs() <= 10.0, "{error}");
}

#[test]
fn a_check_knows_the_sharp_edges_that_were_asked_for() {
    let bench = Bench::new();
    bench.line("remesh sample:cube -o out.obj --quads 300 --tolerance 90 --sharp-angle off").succeeds();
    bench.line("check out.obj --reference sample:cube --sharp-angle off").succeeds();
    bench.line("check out.obj --sharp-angle 20").fails_with(2, &["--reference"]);
    bench.line("check out.obj --reference sample:cube --sharp-angle 500").fails_with(2, &["up to 180"]);
}

#[test]
fn warnings_of_attempts_that_were_not_used_say_so() {
    let bench = Bench::new();
    bench.line("remesh sample:plate -o out.obj --quads 80 --tolerance 90 --report r.json").succeeds();
    let report = report(&bench, "r.json");
    let warnings = report["warnings"].as_array().expect("a list");
    let (retried, others): (Vec<&Value>, Vec<&Value>) = warnings.iter().partition(|w| w["code"] == "retried");
    assert!(!retried.is_empty(), "{warnings:?}");
    for message in retried.iter().filter_map(|w| w["message"].as_str()) {
        assert!(message.starts_with("an attempt at ") && message.contains("was not used: "), "{message}");
        // What is wrong with the attempt that was used is told once.
        let told = |w: &&Value| w["message"].as_str().is_some_and(|other| message.ends_with(other));
        assert!(!others.iter().any(told), "{warnings:?}");
    }
    assert_eq!(report["map"]["flips"], 0);
}

/// A unit cube of twelve triangles.
const BOX_OF_TWELVE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1
f 1 3 2\nf 1 4 3\nf 5 6 7\nf 5 7 8\nf 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\nf 3 4 8\nf 3 8 7\nf 4 1 5\nf 4 5 8\n";
