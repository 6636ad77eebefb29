//! From enumeration to a drawn surface, stage by stage.
//!
//! `cargo bench -p quadloom-regular-maps`

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use quadloom_mesh::Progress;
use quadloom_regular_maps::catalogue::{entries, find};
use quadloom_regular_maps::enumerate::enumerate_maps;
use quadloom_regular_maps::realize::tubify;
use quadloom_regular_maps::{
    CosetLimit, DrawOptions, MatchOptions, RealizeOptions, RegularMap, TubeMatch, draw, enumerate_cosets, find_matches,
    skeleton,
};
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

fn groups(c: &mut Criterion) {
    let mut group = c.benchmark_group("groups");
    group.sample_size(10);
    group.bench_function("enumeration, genus 2 to 6", |b| {
        b.iter(|| black_box(enumerate_maps(2..=6, &Progress::none()).expect("maps").len()));
    });
    let relators: Vec<_> = entries().iter().map(|e| e.presentation.relators()).collect();
    group.bench_function(BenchmarkId::new("cosets of the catalogue", relators.len()), |b| {
        b.iter(|| {
            let order = |words| enumerate_cosets(words, &[], CosetLimit::default()).expect("a finite group").len();
            black_box(relators.iter().map(|words| order(words)).sum::<usize>())
        });
    });
    for name in SOURCES {
        let source = map(name);
        group.bench_function(BenchmarkId::new("matching", name), |b| {
            b.iter(|| black_box(find_matches(&source, &MatchOptions::default()).len()));
        });
    }
    group.finish();
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

criterion_group!(benches, groups, surfaces);
criterion_main!(benches);
