//! Seconds of wavefronts on generated surfaces: from a vertex and from curves, exact and approximate, and refinement.
//!
//! Run with `cargo bench -p quadloom-geodesic`.
#![allow(missing_docs, reason = "made by a macro")]

use criterion::{Criterion, criterion_group, criterion_main};
use quadloom_geodesic::{IntrinsicSurface, Keep, Options, RefineOptions, Source, Wavefront, edge_sources};
use quadloom_mesh::metric::{dihedral_angle, edge_lengths};
use quadloom_mesh::shapes::{bracket, displace, torus};
use quadloom_mesh::{Progress, TriMesh, VertexId};

fn shapes() -> [(&'static str, TriMesh); 2] {
    let bumpy = displace(&torus(1.0, 0.4, 120, 60), |p| 0.05 * (9.0 * p.x).sin() * (7.0 * p.y).cos());
    [("torus", bumpy), ("bracket", bracket(0.08))]
}

fn sources(mesh: &TriMesh) -> Vec<(&'static str, Vec<Source>)> {
    let sharp = mesh.edges().filter(|&e| dihedral_angle(mesh, mesh.half_edge(e)).to_degrees() > 35.0);
    let mut all = vec![("vertex", vec![Source::vertex(VertexId(0))])];
    let curves = edge_sources(mesh, sharp, 0);
    if !curves.is_empty() {
        all.push(("sharp edges", curves));
    }
    all
}

fn wavefronts(c: &mut Criterion) {
    for (name, mesh) in shapes() {
        let lengths = edge_lengths(&mesh);
        let surface = IntrinsicSurface::new(&mesh, &lengths).expect("lengths of a mesh");
        let mut wave = Wavefront::new(&surface);
        for (from, sources) in sources(&mesh) {
            for epsilon in [0.0, 1e-3] {
                let options = Options { epsilon, keep: Keep::Vertices, ..Options::default() };
                c.bench_function(&format!("{name}, {} faces, {from}, epsilon {epsilon}", mesh.face_count()), |b| {
                    b.iter(|| wave.spread(&sources, &options, &Progress::none()))
                });
            }
        }
        wave.spread(&[Source::vertex(VertexId(0))], &Options::default(), &Progress::none()).expect("a vertex");
        let options = RefineOptions::within(1e-3);
        c.bench_function(&format!("{name}, refined to 1e-3"), |b| {
            b.iter(|| wave.field().refine(&options, &Progress::none()))
        });
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(10);
    targets = wavefronts
}
criterion_main!(benches);
