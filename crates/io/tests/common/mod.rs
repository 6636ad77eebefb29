//! Surfaces to write, and where the shared test models are.
#![allow(dead_code, reason = "each test binary uses a part")]

use proptest::collection::vec;
use proptest::prelude::*;
use quadloom_io::SurfaceOut;
use quadloom_mesh::{DVec3, FaceSoup};
use std::io::Write;
use std::path::PathBuf;

/// So many random cases; a failure is printed, smallest first, and becomes a named test.
pub fn config(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() }
}

/// Any finite double, each exponent as likely as any other; zeros and integers are commoner than by chance.
pub fn finite() -> impl Strategy<Value = f64> {
    prop_oneof![
        6 => any::<u64>().prop_map(f64::from_bits).prop_filter("finite", |x| x.is_finite()),
        1 => prop_oneof![Just(0.0), Just(-0.0), Just(f64::MAX), Just(f64::MIN_POSITIVE), Just(5e-324)],
        1 => (-1000i32..1000).prop_map(f64::from),
    ]
}

/// A finite double in single precision's range.
pub fn single() -> impl Strategy<Value = f64> {
    any::<u32>().prop_map(f32::from_bits).prop_filter("finite", |x| x.is_finite()).prop_map(f64::from)
}

fn named(n: usize) -> impl Strategy<Value = Vec<(String, Vec<f64>)>> {
    let value = prop_oneof![9 => finite(), 1 => Just(f64::NAN), 1 => Just(f64::INFINITY)];
    vec(vec(value, n), 0..3)
        .prop_map(|lists| lists.into_iter().enumerate().map(|(k, list)| (format!("q<{k}>&"), list)).collect())
}

fn colors(n: usize) -> impl Strategy<Value = Option<Vec<[f32; 3]>>> {
    let bytes = any::<[u8; 3]>().prop_map(|c| c.map(|x| (f64::from(x) / 255.0) as f32));
    let fractions = [0.0f32..=1.0, 0.0..=1.0, 0.0..=1.0];
    prop_oneof![Just(None), vec(bytes, n).prop_map(Some), vec(fractions, n).prop_map(Some)]
}

/// A surface with everything a [`SurfaceOut`] can hold.
pub fn surface(coordinate: impl Strategy<Value = f64>) -> impl Strategy<Value = SurfaceOut> {
    const MOST: usize = 12;
    let faces = vec(proptest::sample::subsequence((0..MOST as u32).collect::<Vec<_>>(), 3..=7), 1..20);
    let polylines = vec(vec(0..MOST as u32, 2..5), 0..3);
    let positions =
        vec(coordinate, 3 * MOST).prop_map(|x| x.as_chunks().0.iter().map(|p| DVec3::from(*p)).collect::<Vec<_>>());
    (positions, faces, polylines, colors(MOST), named(MOST)).prop_flat_map(
        |(positions, faces, polylines, vertex_colors, vertex_attributes)| {
            let mapped: Vec<_> = faces
                .iter()
                .map(|f| prop_oneof![3 => vec([finite(), finite()], f.len()), 1 => Just(Vec::new())])
                .collect();
            (proptest::option::of(mapped), named(faces.len())).prop_map(move |(corner_uv, face_attributes)| {
                SurfaceOut {
                    positions: positions.clone(),
                    faces: faces.clone(),
                    vertex_colors: vertex_colors.clone(),
                    corner_uv,
                    vertex_attributes: vertex_attributes.clone(),
                    face_attributes,
                    polylines: polylines.clone(),
                }
            })
        },
    )
}

/// Bit patterns, in which NaN is equal to itself and 0 is not -0.
pub fn bits<'a>(values: impl IntoIterator<Item = &'a f64>) -> Vec<u64> {
    values.into_iter().map(|x| if x.is_nan() { f64::NAN.to_bits() } else { x.to_bits() }).collect()
}

/// Bit patterns of points.
pub fn point_bits(points: &[DVec3]) -> Vec<[u64; 3]> {
    points.iter().map(|p| p.to_array().map(f64::to_bits)).collect()
}

/// Bit patterns of texture coordinates; no mapped face is the same as no mapping.
pub fn uv_bits(uv: &Option<Vec<Vec<[f64; 2]>>>) -> Option<Vec<Vec<u64>>> {
    let mapped = uv.as_ref().filter(|faces| faces.iter().any(|f| !f.is_empty()))?;
    Some(mapped.iter().map(|face| bits(face.iter().flatten())).collect())
}

/// Fails unless the soup keeps what its type promises.
pub fn assert_sound(soup: &FaceSoup) {
    let n = soup.positions.len();
    assert!(soup.positions.iter().all(|p| p.is_finite()));
    assert!(soup.faces.iter().chain(&soup.polylines).flatten().all(|&v| (v as usize) < n));
    assert!(soup.vertex_colors.as_ref().is_none_or(|c| c.len() == n));
    assert!(soup.vertex_colors.iter().flatten().flatten().all(|x| (0.0..=1.0).contains(x)));
    assert!(soup.vertex_attributes.iter().all(|(_, values)| values.len() == n));
    if let Some(uv) = &soup.corner_uv {
        assert_eq!(uv.len(), soup.faces.len());
        assert!(uv.iter().zip(&soup.faces).all(|(uv, face)| uv.is_empty() || uv.len() == face.len()));
    }
}

/// A folder of the test models beside the repository, if it is there.
pub fn models(folder: &str) -> Option<PathBuf> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/models").join(folder);
    if path.is_dir() {
        return Some(path);
    }
    say_skipped(&format!("no test models in {}", path.display()));
    None
}

/// Says what is skipped so that it is seen: the test harness hides what goes through `eprintln` where a test passes.
pub fn say_skipped(what: &str) {
    let _ = writeln!(std::io::stderr(), "SKIPPED: {what}");
}
