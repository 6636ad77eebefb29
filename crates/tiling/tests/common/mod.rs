//! Independent checks of tilings: they use the refined mesh and the sides of the tiles, nothing of the crate's own.
#![allow(dead_code, reason = "each test uses a part of it")]

use quadloom_mesh::{DVec3, TriMesh, VertexId};
use quadloom_tiling::Tiling;
use std::collections::{BTreeMap, BTreeSet};

/// Makes every tile a surface of its own from its faces and sides alone, glues equal sides, and counts.
///
/// A tile's corners start apart; they are joined where two of its faces share an edge that is on no arc. Gluing joins
/// the corners along both sides of each arc. What comes out must have V, E, F and χ of the refined mesh.
pub fn check_gluing(what: &str, tiling: &Tiling) {
    let mesh = tiling.mesh();
    let faces = mesh.to_faces();
    let mut on_arc: BTreeSet<(u32, u32)> = BTreeSet::new();
    for path in tiling.arc_path.values() {
        for p in path.windows(2) {
            on_arc.insert((p[0].0.min(p[1].0), p[0].0.max(p[1].0)));
        }
    }
    // 1. Directed sides of faces, by ends: (tile, corner at start, corner at end).
    let mut corner_sets: Vec<u32> = (0..3 * faces.len() as u32).collect();
    let mut directed: BTreeMap<(u32, u32), (u32, u32, u32)> = BTreeMap::new();
    for (f, face) in faces.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (face[k], face[(k + 1) % 3]);
            let corners = (3 * f as u32 + k as u32, 3 * f as u32 + (k as u32 + 1) % 3);
            let tile = tiling.face_tile.values()[f].0;
            assert!(directed.insert((a, b), (tile, corners.0, corners.1)).is_none(), "{what}: not oriented");
        }
    }
    // 2. Tiles alone.
    for (&(a, b), &(tile, s, t)) in &directed {
        if a < b
            && !on_arc.contains(&(a, b))
            && let Some(&(other, u, v)) = directed.get(&(b, a))
        {
            assert_eq!(tile, other, "{what}: two tiles meet beside arcs");
            join(&mut corner_sets, s, v);
            join(&mut corner_sets, t, u);
        }
    }
    let tiles = tiling.complex.cells.len();
    let (mut vertices, mut chi) = (vec![BTreeSet::new(); tiles], vec![0i64; tiles]);
    let mut halves = vec![0i64; tiles];
    for f in 0..faces.len() {
        let tile = tiling.face_tile.values()[f].0 as usize;
        chi[tile] += 1;
        vertices[tile].extend((0..3).map(|k| root(&mut corner_sets, 3 * f as u32 + k)));
    }
    for (&(a, b), &(tile, ..)) in &directed {
        // An edge inside counts half for each of its sides, one on the tile's border once.
        let glued = !on_arc.contains(&(a.min(b), a.max(b))) && directed.contains_key(&(b, a));
        halves[tile as usize] += if glued { 1 } else { 2 };
    }
    for (tile, cell) in tiling.complex.cells.iter() {
        let k = tile.0 as usize;
        let found = vertices[k].len() as i64 - halves[k] / 2 + chi[k];
        let stated = 2 - 2 * i64::from(cell.genus) - cell.boundaries.len() as i64;
        assert_eq!(found, stated, "{what}: tile {tile}");
    }
    // 3. Sides of one arc glued together.
    let mut sides: BTreeMap<u32, Vec<Vec<(u32, u32)>>> = BTreeMap::new();
    for cell in tiling.complex.cells.values() {
        for cycle in &cell.boundaries {
            for side in cycle {
                let mut path: Vec<VertexId> = tiling.arc_path[side.arc].clone();
                if side.reversed {
                    path.reverse();
                }
                let mut ends: Vec<(u32, u32)> = path
                    .windows(2)
                    .map(|p| directed.get(&(p[0].0, p[1].0)).map(|&(_, s, t)| (s, t)).expect("a side has faces"))
                    .collect();
                if side.reversed {
                    ends.reverse();
                    ends.iter_mut().for_each(|e| *e = (e.1, e.0));
                }
                sides.entry(side.arc.0).or_default().push(ends);
            }
        }
    }
    let mut edges = directed.keys().filter(|(a, b)| !on_arc.contains(&((*a).min(*b), (*a).max(*b)))).count() as i64;
    let lonely =
        directed.keys().filter(|&&(a, b)| !on_arc.contains(&(a.min(b), a.max(b))) && !directed.contains_key(&(b, a)));
    assert_eq!(lonely.count(), 0, "{what}: a border on no arc");
    edges /= 2;
    for pair in sides.values() {
        assert!(pair.len() <= 2, "{what}: an arc with {} sides", pair.len());
        edges += pair[0].len() as i64;
        if let [one, other] = &pair[..] {
            for (p, q) in one.iter().zip(other) {
                join(&mut corner_sets, p.0, q.0);
                join(&mut corner_sets, p.1, q.1);
            }
        }
    }
    let vertices: BTreeSet<u32> = (0..corner_sets.len() as u32).map(|c| root(&mut corner_sets, c)).collect();
    let counts = (vertices.len(), edges as usize, faces.len());
    assert_eq!(counts, (mesh.vertex_count(), mesh.edge_count(), mesh.face_count()), "{what}: glued again");
}

/// New vertices lie where they say, on the faces they came from; faces lie in their parents and cover them.
pub fn check_refinement(what: &str, old: &TriMesh, tiling: &Tiling) {
    let (mesh, surface) = (tiling.mesh(), &tiling.surface);
    let diagonal = |f| {
        let corners = old.face_vertices(f).map(|v| old.position(v));
        let (lo, hi) = (corners[0].min(corners[1]).min(corners[2]), corners[0].max(corners[1]).max(corners[2]));
        (hi - lo).length()
    };
    for v in mesh.vertices() {
        let place = surface.place[v];
        let corners = old.face_vertices(place.face).map(|v| old.position(v));
        let there: DVec3 = corners.iter().zip(place.weights).map(|(&p, w)| p * w).sum();
        let off = there.distance(mesh.position(v));
        assert!(off <= 1e-12 * diagonal(place.face), "{what}: vertex {v} is {off:e} off the surface");
        assert!(place.weights.iter().all(|w| (-1e-15..=1.0 + 1e-15).contains(w)), "{what}: {place:?}");
    }
    let mut area = vec![0.0; old.face_count()];
    for f in mesh.faces() {
        let parent = surface.parent_face[f];
        let part = mesh.vector_area(f).dot(old.face_normal(parent));
        assert!(part > 0.0, "{what}: face {f} has no area or looks back: {part:e}");
        area[parent.0 as usize] += part;
    }
    for f in old.faces() {
        let whole = old.vector_area(f).length();
        assert!((area[f.0 as usize] - whole).abs() <= 1e-9 * whole, "{what}: parts of face {f} do not cover it");
    }
}

fn root(sets: &mut [u32], mut i: u32) -> u32 {
    while sets[i as usize] != i {
        sets[i as usize] = sets[sets[i as usize] as usize];
        i = sets[i as usize];
    }
    i
}

fn join(sets: &mut [u32], a: u32, b: u32) {
    let (a, b) = (root(sets, a), root(sets, b));
    sets[a.max(b) as usize] = a.min(b);
}
