//! Distances of all vertices from one, as text: `vertex_field IN VERTEX EPSILON OUT`.
use quadloom_geodesic::{IntrinsicSurface, Options, Source, Wavefront};
use quadloom_mesh::{Progress, metric, repair};
use std::time::Instant;
#[allow(clippy::print_stdout)]
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let soup = quadloom_io::read_soup(&args[1]).unwrap();
    let repaired = repair::repair(&soup, &repair::RepairOptions { zero_area_rel: 0.0, ..Default::default() }).unwrap();
    let mesh = &repaired.mesh;
    let t = Instant::now();
    let length = metric::edge_lengths(mesh);
    let surface = IntrinsicSurface::new(mesh.connectivity(), &length).unwrap();
    let mut wave = Wavefront::new(&surface);
    let v = repaired.vertex_of_input[args[2].parse::<usize>().unwrap()].unwrap();
    let t1 = Instant::now();
    wave.spread(
        &[Source::vertex(v)],
        &Options {
            epsilon: args[3].parse().unwrap(),
            keep: if std::env::var("KEEPV").is_ok() {
                quadloom_geodesic::Keep::Vertices
            } else {
                quadloom_geodesic::Keep::Windows
            },
            ..Options::default()
        },
        &Progress::none(),
    )
    .unwrap();
    let t2 = Instant::now();
    let d = wave.field().vertex_distances();
    println!(
        "{} faces setup {:?} spread {:?} windows {} wpe {:.2} {:?} max {}",
        mesh.face_count(),
        t1 - t,
        t2 - t1,
        wave.field().window_count(),
        wave.field().window_count() as f64 / mesh.edge_count() as f64,
        wave.field().counts(),
        d.values().iter().copied().fold(0.0, f64::max)
    );
    if std::env::var("AUDIT").is_ok() {
        wave.audit();
    }
    if let Some(out) = args.get(4) {
        let text: Vec<String> =
            repaired.vertex_of_input.iter().map(|v| v.map_or("inf".into(), |v| format!("{:e}", d[v]))).collect();
        std::fs::write(out, text.join("\n")).unwrap();
    }
}
