//! Edges of a drawn map as curves in space.
//!
//! In: a [`Drawing`], its source. Out: the drawn map's [`Skeleton`], which the next tubes can be put around.
//! Source: [Razafindrazaka2015] §9.2, the sequence of maps M_i.

use super::{DrawError, Drawing, Drawn};
use crate::skeleton::Skeleton;
use glam::DVec3;
use quadloom_mesh::{HalfEdgeId, Id, TriMesh, VertexId};
use quadloom_regular_maps::ids::FlagId;
use quadloom_regular_maps::map::{Reflection, RegularMap};

impl Drawing {
    /// The drawn map's edge graph in space, with the surface's normals: what the next tubes can be put around.
    ///
    /// # Input      the source map; it gives the skeleton of the source, or of its dual where that is drawn
    /// # Source     [Razafindrazaka2015] §9.2, the sequence of maps M_i
    pub fn skeleton(&self, source: &RegularMap) -> Result<Skeleton, DrawError> {
        skeleton_of(self, source)
    }
}

/// A way along the drawn edges.
fn skeleton_of(drawing: &Drawing, source: &RegularMap) -> Result<Skeleton, DrawError> {
    let lines = drawing.lines(source)?;
    let mesh = &drawing.mesh;
    let (map, across) = match drawing.drawn {
        Drawn::Map => (source.clone(), Reflection::R2),
        Drawn::Dual => (source.dual(), Reflection::R0),
    };
    // Flags of the dual have other numbers; both are numbered from flag 0 by the same words.
    let renumbered = |g: FlagId| match drawing.drawn {
        Drawn::Map => g,
        Drawn::Dual => {
            let word: Vec<_> = source.reflections_of(g).into_iter().map(Reflection::dual).collect();
            map.walk(FlagId(0), &word)
        }
    };
    let number: Vec<FlagId> = source.flags().map(renumbered).collect();
    let is_edge = |h: HalfEdgeId| lines[h.index()] == Some(across);
    let mut positions = vec![None; map.vertex_count()];
    let mut normals = vec![DVec3::Z; map.vertex_count()];
    let mut edges = vec![Vec::new(); map.edge_count()];
    let firsts = crate::skeleton::upright_flags(&map);
    for h in mesh.half_edges().filter(|&h| is_edge(h)) {
        // A line starts where the flag left of it changes its vertex: the flags before and after it differ by r₁.
        let flag = number[drawing.flag[mesh.face(h)].index()];
        if !starts_at_vertex(mesh, &lines, h) {
            continue;
        }
        let v = mesh.origin(h);
        let vertex = map.vertex(flag);
        positions[vertex.index()] = Some(v);
        // The face left of a line that goes out is that of an upright flag where orientation and numbering agree.
        let outward = vertex_normal(mesh, v);
        normals[vertex.index()] = if firsts[flag] { outward } else { -outward };
        if crate::skeleton::starts_here(&map, flag) {
            edges[map.edge(flag).index()] = follow(mesh, &lines, h);
        }
    }
    let at = |v: &Option<VertexId>| v.map_or(DVec3::ZERO, |v| mesh.position(v));
    let positions = positions.iter().map(at).collect();
    let edges = edges.iter().map(|line: &Vec<VertexId>| line.iter().map(|&v| mesh.position(v)).collect()).collect();
    Ok(Skeleton { positions, normals, edges })
}

/// Whether a half-edge along an edge of the map starts at a vertex of the map: the line behind it is not its mirror image.
fn starts_at_vertex(mesh: &TriMesh, lines: &[Option<Reflection>], h: HalfEdgeId) -> bool {
    // Around the origin, a vertex of the map has r₁-lines; an edge's midpoint has r₀-lines (or r₂ in the dual) alone.
    mesh.outgoing(mesh.origin(h)).any(|k| lines[k.index()] == Some(Reflection::R1))
}

/// The vertices along a line of the map from a vertex to the next.
fn follow(mesh: &TriMesh, lines: &[Option<Reflection>], start: HalfEdgeId) -> Vec<VertexId> {
    let across = lines[start.index()];
    let mut path = vec![mesh.origin(start)];
    let mut at = start;
    loop {
        let v = mesh.target(at);
        path.push(v);
        let back = mesh.twin(at);
        let onward = mesh.outgoing(v).find(|&h| lines[h.index()] == across && Some(h) != back);
        let ends = mesh.outgoing(v).any(|k| lines[k.index()] == Some(Reflection::R1));
        match onward {
            Some(next) if !ends && path.len() <= mesh.vertex_count() => at = next,
            _ => return path,
        }
    }
}

fn vertex_normal(mesh: &TriMesh, v: VertexId) -> DVec3 {
    mesh.outgoing(v).map(|h| mesh.vector_area(mesh.face(h))).sum::<DVec3>().normalize_or(DVec3::Z)
}
