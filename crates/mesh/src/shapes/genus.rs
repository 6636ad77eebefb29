//! Closed smooth surfaces of given genus and size: what the cutting of surfaces is measured with.
//!
//! In: genus, level or vertex count. Out: closed meshes, plates with round holes and rounded rims.
//! Holds: genus and vertex count exactly, one component. Not: a position that is the same at every level.
//! Source: Loop subdivision [Loop1987] of surfaces of unit cells; vertex counts of [Favreau2009] Table 1.

use super::draft::Draft;
use super::{loop_step, loop_subdivided, torus, voxel_surface};
use crate::mesh::TriMesh;
use glam::DVec2;

/// Loop steps before level 0 of [`genus_series`]: two make the cells' surface round.
const ROUNDING: u32 = 2;

/// Smooth surface of a genus in a series of resolutions, each level with four times the faces of the one before.
///
/// | genus | level 0 | level 1 | level 2 | level 3 |
/// |---|---|---|---|---|
/// | 1 | 768 | 3072 | 12288 | 49152 |
/// | 2 | 830 | 3326 | 13310 | 53246 |
/// | 3 | 1724 | 6908 | 27644 | 110588 |
/// | 4 | 2202 | 8826 | 35322 | 141306 |
///
/// # Input      genus: any, counts are only promised for 1 to 4; level: at most 4
/// # Output     a torus (genus 1) or a plate with a row of holes; vertices of a level keep their ids in the next
/// # Guarantees the vertex counts above
/// # Source     counts of [Favreau2009] Table 1, shapes own
pub fn genus_series(genus: u32, level: u32) -> TriMesh {
    let level = level.min(4);
    match genus {
        1 => loop_subdivided(torus(1.0, 0.35, 48, 16), level),
        2 => loop_subdivided(two_holes(), ROUNDING + level),
        _ => loop_subdivided(row_of_holes(genus, 2), ROUNDING + level),
    }
}

/// A slab of cells with a row of square holes, whose sides are `hole` cells long: genus 3 of 2 cells has 104
/// vertices, genus 4 has 132.
pub(super) fn row_of_holes(genus: u32, hole: usize) -> TriMesh {
    let period = hole + 1;
    let length = period * genus as usize + 1;
    voxel_surface([length.max(3), hole + 2, 1], |[x, y, _]| genus == 0 || x % period == 0 || y == 0 || y > hole)
}

/// The slab with two holes of one cell, 48 vertices, and two more: the centres of the middle cell's top and bottom.
fn two_holes() -> TriMesh {
    let slab = row_of_holes(2, 1);
    let middle = DVec2::new(2.5, 1.5);
    let diagonals = slab.edges().map(|e| slab.ends(e)).filter(|ends| {
        let centre = slab.position(ends[0]).midpoint(slab.position(ends[1]));
        centre.truncate().distance(middle) < 0.1
    });
    let mut draft = Draft::new(&slab);
    diagonals.for_each(|ends| draft.split(ends.map(|v| v.0), 0.5));
    draft.finish()
}

/// Plate with a nearly square grid of round holes, of a given genus and number of vertices.
///
/// Loop subdivision as long as the count allows, then the longest edges are bisected, one by one, and the vertices
/// smoothed.
///
/// # Input      genus: some hundreds at most; vertices: raised to those of the plate of unit cells, which are
/// 8 · (columns + 1) · (rows + 1) for a full grid of holes
/// # Output     closed, one component, exactly `vertices` vertices
/// # Cost       near-linear: genus 100 with 500 000 vertices in about a second
/// # Source     own
pub fn many_holes(genus: u32, vertices: usize) -> TriMesh {
    let mut mesh = grid_of_holes(genus as usize);
    // A step adds one vertex an edge.
    while mesh.vertex_count() + mesh.edge_count() <= vertices {
        mesh = loop_step(&mesh);
    }
    let mut draft = Draft::new(&mesh);
    draft.bisect_to(vertices);
    draft.smooth(0.5);
    draft.smooth(0.5);
    draft.finish()
}

/// A slab of cells with holes of one cell, one cell apart, row by row; where the last row ends, the slab is solid.
fn grid_of_holes(genus: usize) -> TriMesh {
    let columns = genus.isqrt() + usize::from(genus.isqrt().pow(2) < genus);
    let rows = genus.div_ceil(columns.max(1));
    let size = [(2 * columns + 1).max(3), (2 * rows + 1).max(3), 1];
    voxel_surface(size, |[x, y, _]| !(x % 2 == 1 && y % 2 == 1 && (y / 2) * columns + x / 2 < genus))
}

#[cfg(test)]
mod tests {
    use super::super::tests::{check_closed, smallest_angle};
    use super::*;
    use crate::ids::VertexId;

    #[test]
    fn genus_series_has_the_counts_of_the_table() {
        let table: [(u32, &[usize]); 4] = [
            (1, &[768, 3072, 12288, 49152]),
            (2, &[830, 3326, 13310, 53246]),
            (3, &[1724, 6908, 27644]),
            (4, &[2202, 8826, 35322]),
        ];
        for (genus, counts) in table {
            for (level, &vertices) in (0..).zip(counts) {
                let mesh = genus_series(genus, level);
                check_closed(&mesh, genus);
                assert_eq!(mesh.vertex_count(), vertices, "genus {genus}, level {level}");
                let angle = smallest_angle(&mesh);
                assert!(angle > 20.0, "genus {genus}, level {level}: smallest angle {angle}°");
            }
        }
    }

    #[test]
    fn levels_of_the_genus_series_are_nested() {
        for genus in 1..=4 {
            let (coarse, fine) = (genus_series(genus, 0), genus_series(genus, 1));
            assert_eq!(fine.vertex_count(), coarse.vertex_count() + coarse.edge_count());
            assert_eq!(fine.face_count(), 4 * coarse.face_count());
            // Loop steps move a vertex by less than its edges are long.
            for v in coarse.vertices() {
                let longest = coarse.neighbours(v).map(|w| coarse.position(v).distance(coarse.position(w)));
                assert!(fine.position(v).distance(coarse.position(v)) < 0.5 * longest.fold(0.0, f64::max));
            }
            assert_eq!(fine, genus_series(genus, 1));
        }
    }

    #[test]
    fn other_genera_have_their_series() {
        for genus in [0, 5, 6, 20] {
            check_closed(&genus_series(genus, 0), genus);
        }
    }

    #[test]
    fn many_holes_have_genus_and_count() {
        let cases =
            [(0, 100), (1, 300), (2, 257), (7, 600), (12, 1000), (30, 5000), (49, 4999), (100, 20000), (300, 30000)];
        for (genus, vertices) in cases {
            let mesh = many_holes(genus, vertices);
            check_closed(&mesh, genus);
            assert_eq!(mesh.vertex_count(), vertices, "genus {genus}");
            let angle = smallest_angle(&mesh);
            assert!(angle > 8.0, "genus {genus}, {vertices} vertices: smallest angle {angle}°");
            assert_eq!(mesh, many_holes(genus, vertices));
        }
    }

    #[test]
    fn many_holes_are_raised_to_the_plate_of_cells() {
        for genus in 0..40 {
            let mesh = many_holes(genus, 0);
            check_closed(&mesh, genus);
            assert!(mesh.vertex_count() <= 16 * genus as usize + 32, "genus {genus}: {}", mesh.vertex_count());
        }
    }

    #[test]
    fn many_holes_can_be_large() {
        let mesh = many_holes(100, 500_000);
        check_closed(&mesh, 100);
        assert_eq!(mesh.vertex_count(), 500_000);
        assert!(mesh.position(VertexId(0)).is_finite());
    }
}
