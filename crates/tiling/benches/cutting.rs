//! Cutting generated surfaces: one tile and its quadrangles, by method, search and size.
//!
//! `cargo bench -p quadloom-tiling`

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use quadloom_mesh::{Progress, shapes};
use quadloom_tiling::{CutOptions, EdgeCosts, Method, QuadOptions, SearchMode, cut_into_cylinders, cut_to_disk};
use std::hint::black_box;

fn cutting(c: &mut Criterion) {
    let progress = Progress::none();
    let mut group = c.benchmark_group("quadrangles");
    group.sample_size(10);
    for (genus, level) in [(1, 2), (2, 2), (4, 1)] {
        let mesh = shapes::genus_series(genus, level);
        let costs = EdgeCosts::euclidean(&mesh);
        for method in [Method::Shortest, Method::SinglePoint, Method::Intermediate] {
            for search in [SearchMode::Fast, SearchMode::Exact] {
                let name = format!("genus {genus}, {method:?}, {search:?}");
                group.bench_function(BenchmarkId::new(name, mesh.vertex_count()), |b| {
                    b.iter(|| {
                        let options = CutOptions { search, base: None };
                        let mut cutting = cut_to_disk(&mesh, &costs, method, &options, &progress).expect("a disk");
                        cutting.quadrangulate(&QuadOptions { search, ..Default::default() }).expect("quadrangles");
                        black_box(cutting.cost())
                    });
                });
            }
        }
    }
    group.finish();
    let mesh = shapes::genus_series(4, 1);
    let costs = EdgeCosts::euclidean(&mesh);
    c.bench_function("cylinders, genus 4", |b| {
        b.iter(|| cut_into_cylinders(&mesh, &costs, &CutOptions::default(), &progress).expect("cylinders").cost());
    });
    let holes = shapes::many_holes(100, 100_000);
    let costs = EdgeCosts::euclidean(&holes);
    let mut group = c.benchmark_group("many handles");
    group.sample_size(10);
    group.bench_function("genus 100, 100,000 vertices", |b| {
        b.iter(|| {
            let method = Method::SinglePoint;
            let mut cutting = cut_to_disk(&holes, &costs, method, &CutOptions::default(), &progress).expect("a disk");
            cutting.quadrangulate(&QuadOptions::default()).expect("quadrangles");
            black_box(cutting.tiling().expect("a tiling").complex.cells.len())
        });
    });
    group.finish();
}

criterion_group!(benches, cutting);
criterion_main!(benches);
