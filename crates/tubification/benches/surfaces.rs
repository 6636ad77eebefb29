//! Tubes and drawings, stage by stage.
//!
//! `cargo bench -p quadloom-tubification`

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use quadloom_mesh::Progress;
use quadloom_regular_maps::catalogue::find;
use quadloom_regular_maps::{MatchOptions, RegularMap, TubeMatch, find_matches};
use quadloom_tubification::realize::tubify;
use quadloom_tubification::{DrawOptions, RealizeOptions, draw, skeleton};
use std::hint::black_box;

/// Sources of growing size whose targets have exact skeletons, so that no relaxation is measured with the rest.
const SOURCES: [&str; 3] = ["R3.1", "R5.1", "R11.1"];

fn map(name: &str) -> RegularMap {
    find(name).expect("a name of the catalogue").map().expect("its group")
}

/// The match with most junctions that has a spherical skeleton.
fn on_a_solid(source: &RegularMap) -> TubeMatch {
    let matches = find_matches(source, &MatchOptions::default());
    matches.into_iter().find(|m| skeleton::spherical(&m.target).is_some()).expect("a solid")
}

fn surfaces(c: &mut Criterion) {
    let progress = Progress::none();
    let options = RealizeOptions::default();
    let mut group = c.benchmark_group("surfaces");
    group.sample_size(10);
    for name in SOURCES {
        let source = map(name);
        let matched = on_a_solid(&source);
        group.bench_function(BenchmarkId::new("tubes", name), |b| {
            b.iter(|| black_box(tubify(&matched.target, &options, &progress).expect("tubes").surface.radius()));
        });
        let surface = tubify(&matched.target, &options, &progress).expect("tubes").surface;
        group.bench_function(BenchmarkId::new("drawing", name), |b| {
            b.iter(|| {
                let place = |flag, u, v| (surface.point(flag, u, v), surface.normal(flag, u, v));
                black_box(draw(&source, &matched, place, &DrawOptions::default()).expect("a drawing").1)
            });
        });
    }
    let bouquet = map("R2.4");
    group.bench_function("tubes of R2.4, relaxed", |b| {
        b.iter(|| black_box(tubify(&bouquet, &options, &progress).expect("tubes").surface.radius()));
    });
    group.finish();
}

criterion_group!(benches, surfaces);
criterion_main!(benches);
