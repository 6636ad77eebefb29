//! Exact geodesic distance from points and polygonal curves.
#![allow(missing_docs)]
mod crossing;
mod curves;
mod cut_locus;
mod error;
mod field;
mod insert;
mod isolines;
mod lists;
mod merge;
mod path;
mod sources;
mod surface;
mod trim;
mod wavefront;
mod window;
pub use curves::{CurveTracer, boundary_sources, edge_sources};
pub use cut_locus::{CutLocus, CutPoint};
pub use error::GeodesicError;
pub use field::{EdgeWindow, Field, Nearest, vertex_distances};
pub use isolines::{Isoline, MOST_VALUES, isolines, spaced};
pub use path::GeodesicPath;
pub use sources::{Source, SourceShape};
pub use surface::IntrinsicSurface;
pub use wavefront::{Counts, Keep, Options, Wavefront};
impl Wavefront<'_> {
    pub fn audit(&self) {
        let mesh = self.surface.connectivity();
        let (mut holes, mut jumps, mut kinks, mut worst) = (0, 0, 0, 0.0f64);
        let mut first: Option<(f64, u32)> = None;
        for e in mesh.edges() {
            let len = self.surface.length(e);
            let l = self.lists.of(e);
            let mut x = 0.0;
            for (i, w) in l.iter().enumerate() {
                if w.b0 > x + 1e-9 * len {
                    holes += 1;
                    let d = w.at(w.b0);
                    if first.is_none_or(|f| d < f.0) {
                        first = Some((d, e.0))
                    }
                } else if i > 0 {
                    let o = &l[i - 1];
                    let j = (o.at(o.b1) - w.at(w.b0)).abs();
                    if j > 1e-9 * w.at(w.b0) {
                        jumps += 1;
                        worst = worst.max(j / w.at(w.b0));
                        let d = w.at(w.b0);
                        if first.is_none_or(|f| d < f.0) {
                            first = Some((d, e.0))
                        }
                    }
                    let (_, a) = o.at_with_slope(o.b1);
                    let (_, b) = w.at_with_slope(w.b0);
                    if b > a + 1e-6 {
                        kinks += 1;
                    }
                }
                x = w.b1;
            }
            if x < len * (1.0 - 1e-9) {
                holes += 1;
                let d = self.distance[mesh.ends(e)[0]];
                if first.is_none_or(|f| d < f.0) {
                    first = Some((d, e.0))
                }
            }
        }
        eprintln!("holes {holes} jumps {jumps} worst {worst} convex kinks {kinks} first {first:?}");
        if let Some((_, e)) = first {
            for w in self.lists.of(quadloom_mesh::EdgeId(e)) {
                eprintln!(
                    "  {w:?} {} {} lin {} can {} pend {}",
                    w.at(w.b0),
                    w.at(w.b1),
                    w.is_linear(),
                    w.to_canonical(),
                    w.is_pending()
                );
            }
            eprintln!("len {} ", self.surface.length(quadloom_mesh::EdgeId(e)));
        }
    }
}
