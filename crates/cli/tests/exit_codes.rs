//! How the command ends when something is wrong.

mod common;

use common::Bench;

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

#[test]
fn wrong_usage_is_2() {
    let bench = Bench::new();
    assert_eq!(bench.line("remesh").code, 2);
    assert_eq!(bench.line("knit sample:torus").code, 2);
    let both = bench.line("remesh sample:torus -o out.obj --quads 100 --scale 2");
    both.fails_with(2, &["--quads", "--scale"]);
    bench.line("remesh sample:teacup -o out.obj").fails_with(2, &["teacup", "samples"]);
    bench.line("remesh sample:torus -o out.obj --quads 0").fails_with(2, &["--quads"]);
    bench.line("remesh sample:torus -o out.obj --adaptivity 3").fails_with(2, &["--adaptivity"]);
    bench.line("remesh sample:torus -o out.obj --threads 0").fails_with(2, &["--threads"]);
    for seconds in ["-1", "0", "nan", "inf", "soon"] {
        let line = format!("remesh sample:torus -o out.obj --time-limit {seconds}");
        bench.line(&line).fails_with(2, &["--time-limit", "above 0"]);
        bench.line(&line.replace("remesh", "field").replace("obj", "rosy")).fails_with(2, &["--time-limit"]);
    }
    bench.line("remesh sample:torus -o out.obj --curl-correction 2").fails_with(2, &["--curl-correction"]);
    assert!(bench.files().is_empty());
}

#[test]
fn limits_of_no_consequence_are_taken() {
    let bench = Bench::new();
    let ran = bench.line("remesh sample:torus -o out.obj --quads 300 --tolerance 30 --time-limit 1e30 --threads 9999");
    ran.succeeds();
    assert!(ran.stderr.contains("threads are used"), "{}", ran.stderr);
}

#[test]
fn no_file_is_written_over_another_one_of_the_run() {
    let bench = Bench::new();
    bench.line("convert sample:torus t.obj").succeeds();
    std::fs::create_dir(bench.path("sub")).expect("a folder");
    let before = bench.read("t.obj");
    bench.write("f.txt", "0 1\n");
    let refused = |line: &str, words: &[&str]| bench.line(line).fails_with(2, words);
    // 1. Over what is read.
    refused("remesh t.obj -o t.obj", &["t.obj", "the quads (-o)", "the input", "another name"]);
    refused("remesh t.obj -o sub/../t.obj", &["the input"]);
    refused("remesh t.obj -o out.obj --write-map t.obj", &["--write-map", "the input"]);
    refused("remesh t.obj -o out.obj --features f.txt --report f.txt", &["--report", "--features"]);
    refused("remesh t.obj -o out.obj --singularities f.txt --report f.txt", &["--report", "--singularities"]);
    refused("field t.obj -o t.rosy --singularities f.txt --write-singularities f.txt", &["--write-singularities"]);
    refused("convert t.obj ./t.obj", &["the output", "the input"]);
    // 2. Over what is written.
    refused("remesh sample:torus -o a.obj --report ./a.obj", &["--report", "-o", "a file of its own"]);
    refused("remesh sample:torus -o a.rosy.obj --write-field a.rosy", &["the surface of the field", "-o"]);
    refused("field t.obj -o x.rosy --write-singularities x.rosy", &["--write-singularities", "the field (-o)"]);
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(bench.path("t.obj"), bench.path("link.obj")).expect("a link");
        refused("remesh t.obj -o link.obj", &["link.obj", "the input"]);
        std::fs::remove_file(bench.path("link.obj")).expect("the link");
    }
    assert_eq!(bench.files(), ["f.txt", "sub", "t.obj"]);
    // 3. The surface of a field is beside it under a name of its own.
    bench.line("remesh t.obj -o out.obj --quads 300 --tolerance 30 --write-field t.rosy").succeeds();
    assert_eq!(bench.files(), ["f.txt", "out.obj", "sub", "t.obj", "t.rosy", "t.rosy.obj"]);
    assert_eq!(bench.read("t.obj"), before);
}

#[cfg(target_os = "linux")]
#[test]
fn a_file_that_cannot_be_written_leaves_all_others_alone() {
    let bench = Bench::new();
    bench.write("out.obj", "the old one");
    let full = bench.line("remesh sample:torus -o out.obj --quads 300 --tolerance 30 --report /dev/full");
    full.fails_with(3, &["/dev/full", "nothing was changed"]);
    bench.line("remesh sample:lattice -o out.obj --view /proc/x.html").fails_with(3, &["/proc/x.html"]);
    assert_eq!(bench.read("out.obj"), b"the old one");
    assert_eq!(bench.files(), ["out.obj"]);
}

#[test]
fn sizes_beyond_computing_and_surfaces_without_area_are_4() {
    let bench = Bench::new();
    bench.line("convert sample:torus t.obj").succeeds();
    let text = String::from_utf8(bench.read("t.obj")).expect("text");
    let scaled = |exponent: i32| -> String {
        let line = |line: &str| match line.strip_prefix("v ") {
            Some(rest) => {
                let words: Vec<String> = rest
                    .split(' ')
                    .map(|w| format!("{:e}", w.parse::<f64>().expect("a number") * 10f64.powi(exponent)))
                    .collect();
                format!("v {}\n", words.join(" "))
            }
            None => format!("{line}\n"),
        };
        text.lines().map(line).collect()
    };
    for (exponent, words) in [(160, "coordinates up to"), (300, "coordinates up to"), (-200, "an extent of")] {
        bench.write("scaled.obj", scaled(exponent));
        bench.line("remesh scaled.obj -o out.obj").fails_with(4, &["scaled.obj", words, "1e-40 to 1e40", "scale"]);
        bench.line("field scaled.obj -o out.rosy").fails_with(4, &["scaled.obj", words]);
    }
    for exponent in [12, -12] {
        bench.write("scaled.obj", scaled(exponent));
        bench.line("remesh scaled.obj -o out.obj --quads 300 --tolerance 30").succeeds();
    }
    std::fs::remove_file(bench.path("out.obj")).expect("the output");
    bench.write("line.obj", "v 0 0 0\nv 1 0 0\nv 3 0 0\nf 1 2 3\n");
    bench.line("remesh line.obj -o out.obj").fails_with(4, &["line.obj", "none of the 1 faces has an area"]);
    bench.line("field line.obj -o out.rosy").fails_with(4, &["line.obj", "none of the 1 faces has an area"]);
    bench.write("both.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 0 0\nv 6 0 0\nv 8 0 0\nf 1 2 3\nf 4 5 6\n");
    bench.line("remesh both.obj -o out.obj").fails_with(4, &["both.obj", "without area", "face 1"]);
    assert!(!bench.path("out.obj").exists());
}

#[test]
fn unreadable_input_is_3() {
    let bench = Bench::new();
    bench.line("remesh missing.obj -o out.obj").fails_with(3, &["missing.obj", "no such file"]);
    bench.write("empty.obj", "");
    bench.line("remesh empty.obj -o out.obj").fails_with(3, &["empty.obj", "empty"]);
    let junk: Vec<u8> = (0..4096u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    bench.write("junk.obj", junk);
    bench.line("remesh junk.obj -o out.obj").fails_with(3, &["junk.obj"]);
    bench.write("points.obj", "v 0 0 0\nv 1 0 0\n");
    bench.line("remesh points.obj -o out.obj").fails_with(3, &["points.obj", "no face"]);
    bench.write("cut.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n");
    bench.line("remesh cut.obj -o out.obj").fails_with(3, &["cut.obj", "line 4", "9"]);
    bench.write("nan.obj", "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n");
    bench.line("remesh nan.obj -o out.obj").fails_with(3, &["nan.obj", "line 2"]);
    bench.write("cut.stl", [b"solid".as_slice(), &[0; 10]].concat());
    bench.line("remesh cut.stl -o out.obj").fails_with(3, &["cut.stl"]);
    std::fs::create_dir(bench.path("folder.obj")).expect("a folder");
    bench.line("remesh folder.obj -o out.obj").fails_with(3, &["folder.obj", "folder"]);
    assert!(!bench.path("out.obj").exists());
}

#[test]
fn unwritable_output_is_3_and_found_before_anything_is_computed() {
    let bench = Bench::new();
    bench.line("remesh sample:lattice -o nowhere/out.obj").fails_with(3, &["nowhere", "folder"]);
    bench.line("remesh sample:lattice -o out.obj --report nowhere/r.json").fails_with(3, &["nowhere"]);
    assert!(bench.files().is_empty());
    std::fs::create_dir(bench.path("sub")).expect("a folder");
    std::fs::create_dir(bench.path("sub.obj")).expect("a folder");
    for (line, suffix) in [
        ("remesh sample:lattice -o sub", ".vtu"),
        ("remesh sample:lattice -o sub.obj", ".vtu"),
        ("convert sample:lattice sub/", ".vtu"),
        ("field sample:lattice -o sub", ".rosy"),
        ("view sample:lattice -o sub", ".html"),
        ("remesh sample:lattice -o out.obj --report sub", "any name"),
    ] {
        bench.line(line).fails_with(3, &["sub", "this is a folder; name a file in it", suffix]);
    }
    assert_eq!(bench.files(), ["sub", "sub.obj"]);
}

#[test]
fn suffixes_that_are_not_written_are_2_and_name_those_that_are() {
    let bench = Bench::new();
    for (line, words) in [
        ("remesh sample:lattice -o out.xyz", ["out.xyz", ".xyz files are not written here", ".vtu"]),
        ("remesh sample:lattice -o out", ["out", "no suffix", ".vtu"]),
        ("remesh sample:lattice -o out.obj --view v.txt", ["v.txt", ".txt files", ".html"]),
        ("remesh sample:lattice -o out.obj --write-field f.txt", ["f.txt", ".txt files", ".rosy"]),
        ("remesh sample:lattice -o out.obj --write-map m.ply", ["m.ply", ".ply files", ".obj"]),
        ("view sample:lattice -o v.obj", ["v.obj", ".obj files", ".html"]),
        ("convert sample:lattice out.dae", ["out.dae", ".dae files", ".glb"]),
        ("field sample:lattice -o out", ["out", "no suffix", ".rawfield"]),
    ] {
        bench.line(line).fails_with(2, &words);
    }
    assert!(bench.files().is_empty());
}

#[test]
fn values_out_of_range_are_2_and_name_the_range() {
    let bench = Bench::new();
    for (option, values, range) in [
        ("--quads", "0 -1 1e9 many", "a whole number from 1"),
        ("--edge-length", "0 -1 nan inf long", "a finite number above 0"),
        ("--scale", "0 -1 nan inf", "a finite number above 0"),
        ("--tolerance", "0 -1 nan inf", "a finite number above 0"),
        ("--adaptivity", "2 -0.1 nan", "a number from 0 to 1"),
        ("--anisotropy", "2 -0.1 nan", "a number from 0 to 1"),
        ("--curl-correction", "2 -0.1 nan", "a number from 0 to 1"),
        ("--sharp-angle", "0 181 nan sharp", "degrees above 0 and up to 180, or off"),
        ("--seed", "-1 0.5", "a whole number from 0"),
    ] {
        for value in values.split(' ') {
            let ran = bench.line(&format!("remesh sample:lattice -o out.obj {option} {value}"));
            ran.fails_with(2, &[option, value, range]);
        }
    }
    bench.line("field sample:lattice -o out.rosy --sharp-angle 200").fails_with(2, &["up to 180"]);
    assert!(bench.files().is_empty());
}

#[test]
fn what_sizes_follow_is_refused_where_they_do_not_vary() {
    let bench = Bench::new();
    bench.line("remesh sample:lattice -o out.obj --adapt-to feature-size").fails_with(2, &["--adaptivity"]);
    let varied = "remesh sample:torus -o out.obj --quads 300 --tolerance 90 --adapt-to feature-size --adaptivity 0.5";
    bench.line(varied).succeeds();
}

#[test]
fn ties_that_cannot_be_name_the_option_the_vertex_and_the_count() {
    let bench = Bench::new();
    let cube = common::read_count(&bench, "cube");
    let numbers = [format!("has {cube}"), format!("from 0 to {}", cube - 1)];
    let words = ["--tie 0,99999", "no vertex 99999", &numbers[0], &numbers[1], "name one of those"];
    bench.line("remesh sample:cube -o out.obj --tie 0,99999").fails_with(4, &words);
    let apart =
        format!("remesh sample:two_spheres -o out.obj --tie 0,{}", common::read_count(&bench, "two_spheres") - 1);
    bench.line(&apart).fails_with(4, &["--tie 0,", "components 1 and 2", "one component"]);
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 5 5 5\nf 1 2 3\nf 1 3 4\n";
    bench.write("loose.obj", text);
    bench.line("remesh loose.obj -o out.obj --tie 0,4").fails_with(4, &["--tie 0,4", "vertex 4", "on no face"]);
    assert!(!bench.path("out.obj").exists());
}

#[test]
fn a_field_that_is_none_is_told_what_is_read() {
    let bench = Bench::new();
    bench.line("convert sample:torus t.obj").succeeds();
    bench.write("hello.txt", "hello\n");
    for name in ["t.obj", "hello.txt"] {
        let ran = bench.line(&format!("remesh sample:torus -o out.obj --field {name}"));
        ran.fails_with(3, &[name, ".rosy", ".rawfield"]);
    }
    bench.write("broken.rosy", "hello\n");
    bench.line("remesh sample:torus -o out.obj --field broken.rosy").fails_with(3, &["broken.rosy", "line 1", "hello"]);
}

#[test]
fn a_surface_with_one_side_is_4() {
    let bench = Bench::new();
    // A Moebius strip of five quads, as triangles.
    let mut text = String::new();
    for i in 0..5 {
        let (sin, cos) = (f64::from(i) * std::f64::consts::TAU / 5.0).sin_cos();
        text += &format!("v {cos} {sin} 0\nv {} {} 1\n", 0.8 * cos, 0.8 * sin);
    }
    for i in 0..5 {
        let (a, b) = (2 * i + 1, 2 * i + 2);
        let (c, d) = if i == 4 { (2, 1) } else { (2 * i + 3, 2 * i + 4) };
        text += &format!("f {a} {c} {d}\nf {a} {d} {b}\n");
    }
    bench.write("moebius.obj", text);
    bench.line("remesh moebius.obj -o out.obj").fails_with(4, &["moebius.obj", "orientable", "edge"]);
    bench.line("remesh moebius.obj -o out.obj --quiet").fails_with(4, &["orientable"]);
    // No cure is promised that there is none.
    let check = bench.line("check moebius.obj");
    assert_eq!(check.code, 4);
    let field = bench.line("field moebius.obj -o out.rosy");
    field.fails_with(4, &["moebius.obj", "no repair helps", "cut the surface"]);
    assert!(!field.stderr.contains("repairs them"), "{}", field.stderr);
    assert!(check.stdout.contains("cannot repair") && !check.stdout.contains("repairs this"), "{}", check.stdout);
    assert!(!bench.path("out.obj").exists());
}

#[test]
fn files_that_do_not_fit_the_input_are_refused() {
    let bench = Bench::new();
    bench.write("short.rosy", "1\n4\n1 0 0\n");
    bench
        .line("remesh sample:cube -o out.obj --field short.rosy")
        .fails_with(4, &["short.rosy", "cross field", "1 vectors"]);
    bench.write("far.txt", "99999999 1\n");
    bench.line("remesh sample:cube -o out.obj --singularities far.txt").fails_with(4, &["99999999"]);
    bench.line("remesh sample:cube -o out.obj --tie 0,99999999").fails_with(4, &["--tie", "99999999"]);
    bench.write("pairs.txt", "# edges\n0 1\n\n3 99999999\n");
    let line = ["pairs.txt", "line 4", "vertex 99999999"];
    bench.line("remesh sample:cube -o out.obj --features pairs.txt").fails_with(4, &line);
    bench.line("field sample:cube -o out.rosy --features pairs.txt").fails_with(4, &line);
    bench.line("remesh sample:cube -o out.obj --ties pairs.txt").fails_with(4, &["99999999"]);
    bench.write("one.sharp", "1\n1,99999999,0\n");
    bench.line("remesh sample:cube -o out.obj --features one.sharp").fails_with(4, &["one.sharp", "line 2"]);
    assert!(!bench.path("out.obj").exists());
}

#[test]
fn curves_that_cannot_be_read_name_line_and_element() {
    let bench = Bench::new();
    bench.write("lines.obj", "v 0 0 0\nv 1 0 0\nl 1 9\n");
    let curve = ["lines.obj", "line 3", "vertex 9", "polyline"];
    for option in ["--features", "--guides"] {
        let ran = bench.line(&format!("remesh sample:cube -o out.obj {option} lines.obj"));
        ran.fails_with(3, &curve);
        assert!(!ran.stderr.contains("face"), "{}", ran.stderr);
    }
    bench.write("short.json", "[\n [[0,0,0],[1,0,0]],\n [[0,0,0],\n  {\"point\":[1,2]}]\n]\n");
    let element = ["short.json", "line 4", "curve 2, point 2", "[[[x, y, z]"];
    bench.line("remesh sample:cube -o out.obj --guides short.json").fails_with(3, &element);
    bench.write("object.json", "{\"curves\": []}");
    bench.line("remesh sample:cube -o out.obj --guides object.json").fails_with(3, &["object.json", "[[[x, y, z]"]);
}

#[test]
fn ties_of_a_vertex_to_itself_are_refused_at_once() {
    let bench = Bench::new();
    bench.line("remesh sample:lattice -o out.obj --tie 0").fails_with(2, &["--tie", "17,204"]);
    bench.line("remesh sample:lattice -o out.obj --tie 5,5").fails_with(2, &["--tie", "vertex 5"]);
    bench.write("ties.txt", "# both ends\n3 4\n5 5\n");
    bench.line("remesh sample:lattice -o out.obj --ties ties.txt").fails_with(3, &["ties.txt", "line 3", "vertex 5"]);
    assert!(!bench.path("out.obj").exists());
}

#[test]
fn lists_of_singular_vertices_that_no_quad_mesh_has_are_refused_at_once() {
    let bench = Bench::new();
    let refused = |list: &str, words: &[&str]| {
        bench.write("list.txt", list);
        bench.line("remesh sample:torus -o out.obj --singularities list.txt").fails_with(4, words);
        bench.line("field sample:torus -o out.rosy --singularities list.txt").fails_with(4, words);
    };
    refused("4 -1\n", &["sum to -1 quarters", "needs 0", "--other-singularities"]);
    refused("4 1\n9 1\n", &["sum to 2 quarters", "needs 0"]);
    refused("4 1\n4 -1\n", &["vertex 4", "twice"]);
    refused("4 4\n9 -4\n", &["vertex 4", "valence 0"]);
    refused("4 1\n900 -1\n", &["no quad mesh of a torus"]);
    refused("4 1\n99999999 -1\n", &["99999999"]);
    bench.write("list.txt", "9 1\n");
    bench.line("remesh sample:sphere -o out.obj --singularities list.txt").fails_with(4, &["sum to 1", "needs 8"]);
    let near: String = (0..4).map(|v| format!("{v} 1\n{} -1\n", v + 4)).collect();
    bench.write("list.txt", near);
    let close = bench.line("remesh sample:torus -o out.obj --quads 500 --singularities list.txt");
    close.fails_with(4, &["nearer to each other"]);
    bench.line("remesh sample:torus -o out.obj --other-singularities").fails_with(2, &["--singularities"]);
    assert_eq!(bench.files(), ["list.txt"]);
}

#[test]
fn a_time_limit_is_7_and_leaves_nothing() {
    let bench = Bench::new();
    let begin = std::time::Instant::now();
    bench.line("remesh sample:lattice -o out.obj --quads 40000 --time-limit 0.2").fails_with(7, &["time limit"]);
    assert!(begin.elapsed().as_secs_f64() < 10.0, "ended after {:?}", begin.elapsed());
    assert!(bench.files().is_empty());
}

#[cfg(unix)]
#[test]
fn an_interrupt_is_130_and_leaves_nothing() {
    let bench = Bench::new();
    let mut command =
        bench.command(&["remesh", "sample:lattice", "-o", "out.obj", "--quads", "40000", "--progress", "json"]);
    let mut child = command.stderr(std::process::Stdio::piped()).spawn().expect("the built command");
    // The first line of progress says that the handler is in place.
    let mut stderr = std::io::BufReader::new(child.stderr.take().expect("piped"));
    let mut line = String::new();
    std::io::BufRead::read_line(&mut stderr, &mut line).expect("a line");
    let killed = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill");
    assert!(killed.success());
    let mut rest = String::new();
    std::io::Read::read_to_string(&mut stderr, &mut rest).expect("text");
    let status = child.wait().expect("an end");
    assert_eq!(status.code(), Some(130), "{rest}");
    assert!(rest.contains("error: cancelled"), "{rest}");
    assert!(bench.files().is_empty());
}

#[test]
fn an_existing_output_survives_failure() {
    let bench = Bench::new();
    bench.write("out.obj", "the old one");
    bench.write("moved.obj", TRIANGLE.replace("f 1 2 3", "f 1 2 7"));
    assert_eq!(bench.line("remesh moved.obj -o out.obj").code, 3);
    assert_eq!(bench.line("remesh sample:lattice -o out.obj --quads 40000 --time-limit 0.1").code, 7);
    assert_eq!(bench.read("out.obj"), b"the old one");
    assert_eq!(bench.files(), ["moved.obj", "out.obj"]);
}
