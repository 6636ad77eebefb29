//! Enumeration, groups, matching.
//!
//! `cargo bench -p quadloom-regular-maps`

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use quadloom_mesh::Progress;
use quadloom_regular_maps::catalogue::{entries, find};
use quadloom_regular_maps::enumerate::enumerate_maps;
use quadloom_regular_maps::{CosetLimit, MatchOptions, RegularMap, enumerate_cosets, find_matches};
use std::hint::black_box;

/// Sources of growing size.
const SOURCES: [&str; 3] = ["R3.1", "R5.1", "R11.1"];

fn map(name: &str) -> RegularMap {
    find(name).expect("a name of the catalogue").map().expect("its group")
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

criterion_group!(benches, groups);
criterion_main!(benches);
