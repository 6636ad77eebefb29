//! Distances from a curve on a generated torus: the wavefront, questions to it, a refined mesh.
//!
//! Run with `cargo run --release --example distance_field`.
use quadloom_geodesic::{CurveTracer, IntrinsicSurface, Options, RefineOptions, Wavefront, isolines, spaced};
use quadloom_mesh::{FaceId, Progress, SurfacePoint, metric::edge_lengths, shapes::torus};

#[allow(clippy::print_stdout, reason = "an example shows what it finds")]
fn main() -> Result<(), quadloom_geodesic::GeodesicError> {
    // 1. A surface: connectivity and edge lengths.
    let mesh = torus(1.0, 0.4, 60, 30);
    let lengths = edge_lengths(&mesh);
    let surface = IntrinsicSurface::new(&mesh, &lengths)?;
    // 2. A closed curve through three points, joined by shortest paths.
    let middle = |face: u32| SurfacePoint { face: FaceId(face), weights: [0.2, 0.3, 0.5] };
    let corners = [middle(10), middle(1200), middle(2500), middle(10)];
    let curve = CurveTracer::new(&surface).join(&corners, 0, &Progress::none())?;
    // 3. The wavefront, and what it knows.
    let mut wave = Wavefront::new(&surface);
    wave.spread(&curve, &Options::default(), &Progress::none())?;
    let field = wave.field();
    let far = middle(3000);
    let nearest = field.at(&far)?;
    let path = field.path_from(&far)?.expect("a torus is connected");
    println!("{} segments, {} windows", curve.len(), field.window_count());
    println!(
        "distance {:.6}, by a path of {} points and length {:.6}",
        nearest.distance,
        path.points.len(),
        path.length
    );
    // 4. A mesh on which the field is nearly linear, and its isolines.
    let fine = field.refine(&RefineOptions::within(1e-3), &Progress::none())?;
    let lines = isolines(&fine.connectivity, &fine.distance, &spaced(&fine.distance, 0.1)?);
    println!("{} faces instead of {}, {} isolines", fine.connectivity.face_count(), mesh.face_count(), lines.len());
    Ok(())
}
