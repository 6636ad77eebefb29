//! Generated shapes: samples to try, and meshes of known topology to test with.
//!
//! In: sizes and resolutions. Out: triangle meshes. Holds: valid, oriented outwards, the same bytes every time;
//! resolutions below the smallest sensible one are raised to it. Sizes must be finite and positive. Units: those of the given sizes.
//! Source: elementary solids; Loop subdivision [Loop1987].

mod draft;
mod genus;
mod random;

pub use genus::{genus_series, many_holes};
pub use random::{random_genus, small_random};

use crate::ids::{EdgeId, EdgeMap, VertexId, VertexMap};
use crate::mesh::TriMesh;
use crate::union_find::UnionFind;
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// Names and descriptions of the samples, in the order of their listing.
const SAMPLES: &[(&str, &str)] = &[
    ("sphere", "unit sphere, subdivided icosahedron"),
    ("torus", "torus of radii 1 and 0.4"),
    ("genus2", "smooth surface of genus 2"),
    ("genus3", "smooth surface of genus 3"),
    ("genus4", "smooth surface of genus 4, a plate with a row of holes"),
    ("holes", "plate with 7 by 7 round holes, genus 49"),
    ("lattice", "smoothed lattice of 3 by 3 by 3 bars, genus 28"),
    ("cube", "cube with sharp edges"),
    ("cylinder", "open tube, two boundary loops"),
    ("plate", "flat plate with five round holes"),
    ("bracket", "machined L-bracket: creases, a fillet, three bores (genus 3)"),
    ("bumpy_sphere", "sphere with smooth bumps"),
    ("bumpy_torus", "torus with smooth bumps"),
    ("noisy_sphere", "sphere with noise on every vertex"),
    ("noisy_torus", "torus with noise on every vertex"),
    ("two_spheres", "two spheres of different size: two components"),
];

/// Names of the samples, each with one line of description.
pub fn sample_names() -> &'static [(&'static str, &'static str)] {
    SAMPLES
}

/// The sample of a name listed by [`sample_names`]; `None` for other names.
pub fn sample(name: &str) -> Option<TriMesh> {
    Some(match name {
        "sphere" => sphere(1.0, 5),
        "torus" => torus(1.0, 0.4, 96, 48),
        "genus2" => smooth_genus(2, 3),
        "genus3" => smooth_genus(3, 3),
        "genus4" => genus_series(4, 0),
        "holes" => many_holes(49, 8000),
        "lattice" => lattice(3, 2),
        "cube" => cube(1.0, 24),
        "cylinder" => cylinder(1.0, 3.0, 72, 36),
        "plate" => plate_with_holes(0.12),
        "bracket" => bracket(0.2),
        "bumpy_sphere" => displace(&sphere(1.0, 5), |p| 0.12 * bumps(3.0 * p)),
        "bumpy_torus" => displace(&torus(1.0, 0.4, 128, 64), |p| 0.05 * bumps(5.0 * p)),
        "noisy_sphere" => with_noise(&sphere(1.0, 5), 0.01, 1),
        "noisy_torus" => with_noise(&torus(1.0, 0.4, 96, 48), 0.01, 1),
        "two_spheres" => {
            let small = sphere(0.5, 4);
            let moved = small.positions().map(|&p| p + DVec3::new(2.0, 0.0, 0.0));
            join(&[sphere(1.0, 5), build(moved.into_vec(), small.to_faces())])
        }
        _ => return None,
    })
}

/// Sphere about the origin: an icosahedron whose faces are quartered `levels` times (at most 9).
pub fn sphere(radius: f64, levels: u32) -> TriMesh {
    let long = 0.5 * (1.0 + 5f64.sqrt());
    let mut corners = Vec::new();
    for (a, b) in [(-1.0, long), (1.0, long), (-1.0, -long), (1.0, -long)] {
        corners.extend([DVec3::new(a, b, 0.0), DVec3::new(0.0, a, b), DVec3::new(b, 0.0, a)]);
    }
    // The faces are the triples at the smallest mutual distance, turned outwards.
    let mut faces = Vec::new();
    for i in 0..12u32 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                let [a, b, c] = [i, j, k].map(|v| corners[v as usize]);
                if [(a, b), (b, c), (c, a)].iter().all(|(p, q)| p.distance(*q) < 2.1) {
                    faces.push(if (b - a).cross(c - a).dot(a) > 0.0 { [i, j, k] } else { [i, k, j] });
                }
            }
        }
    }
    let mut mesh = build(corners, faces);
    for _ in 0..levels.min(9) {
        mesh = quarter(&mesh, |mesh, e| {
            let [a, b] = mesh.ends(e).map(|v| mesh.position(v));
            0.5 * (a + b)
        });
    }
    let round = mesh.positions().map(|p| p.normalize() * radius);
    build(round.into_vec(), mesh.to_faces())
}

/// Torus about the z axis: `around` steps along the large circle of radius `major`, `across` along the small one.
pub fn torus(major: f64, minor: f64, around: u32, across: u32) -> TriMesh {
    let (around, across) = (around.max(3), across.max(3));
    let point = |i: u32, j: u32| {
        let (s, t) = (TAU * f64::from(i % around) / f64::from(around), TAU * f64::from(j % across) / f64::from(across));
        let ring = major + minor * t.cos();
        DVec3::new(ring * s.cos(), ring * s.sin(), minor * t.sin())
    };
    let mut sheets = Sheets::new(1e-9 * (major.abs() + minor.abs()));
    sheets.add(around, across, point);
    sheets.finish()
}

/// Open tube about the z axis.
pub fn cylinder(radius: f64, height: f64, around: u32, along: u32) -> TriMesh {
    let (around, along) = (around.max(3), along.max(1));
    let mut sheets = Sheets::new(1e-9 * (radius.abs() + height.abs()));
    sheets.add(around, along, |i, j| {
        let s = TAU * f64::from(i % around) / f64::from(around);
        DVec3::new(radius * s.cos(), radius * s.sin(), height * f64::from(j) / f64::from(along))
    });
    sheets.finish()
}

/// Cube `0..=size` in each coordinate with `steps` subdivisions a side.
pub fn cube(size: f64, steps: u32) -> TriMesh {
    let steps = steps.max(1);
    let mut sheets = Sheets::new(1e-6 * size / f64::from(steps));
    let at = |i: u32| size * f64::from(i) / f64::from(steps);
    for turn in 0..3 {
        let place = |x: f64, y: f64, z: f64| match turn {
            0 => DVec3::new(x, y, z),
            1 => DVec3::new(z, x, y),
            _ => DVec3::new(y, z, x),
        };
        sheets.add(steps, steps, |i, j| place(at(i), at(j), size));
        sheets.add(steps, steps, |i, j| place(at(j), at(i), 0.0));
    }
    sheets.finish()
}

/// Flat plate 6 by 4 with five round holes, open; edges of about `step`.
pub fn plate_with_holes(step: f64) -> TriMesh {
    let mut sheets = Sheets::new(1e-3 * step);
    let n = count(2.0, step, 2);
    for (x, y) in [(1.0, 1.0), (3.0, 1.0), (5.0, 1.0), (1.0, 3.0), (3.0, 3.0), (5.0, 3.0)] {
        let centre = DVec2::new(x, y);
        let place = |p: DVec2| (centre + p).extend(0.0);
        match (x, y) {
            (3.0, 3.0) => sheets.add(n, n, |i, j| place(square_point(i, j, n))),
            (3.0, 1.0) => sheets.add_ring(n, 1.0, 0.3, place),
            (_, 1.0) => sheets.add_ring(n, 1.0, 0.6, place),
            _ => sheets.add_ring(n, 1.0, 0.45, place),
        }
    }
    sheets.finish()
}

/// Point of the grid of `n` by `n` steps over the square -1..=1.
fn square_point(i: u32, j: u32, n: u32) -> DVec2 {
    DVec2::new(f64::from(i), f64::from(j)) * (2.0 / f64::from(n)) - DVec2::ONE
}

/// L-bracket 6 × 4 × 6 with walls of 1, a fillet of radius 1, two bores of radius 0.55 through the base and one of
/// radius 1.2 through the wall: genus 3, closed; edges of about `step`.
///
/// ```text
///  z
///  6 ┌─┐            Blocks of the side view: base arm x 2..6, wall arm z 2..6,
///    │ │            and the corner between them, whose inner side is the fillet.
///    │ │
///  2 │  ╲
///  1 │    `──────┐
///  0 └───────────┘
///    0 1 2       6 x
/// ```
pub fn bracket(step: f64) -> TriMesh {
    let step = if step.is_finite() { step.clamp(0.02, 1.0) } else { 0.2 };
    let mut sheets = Sheets::new(1e-3 * step);
    let (two, thick) = (count(2.0, step, 2), count(1.0, step, 1));
    bracket_plates(&mut sheets, two, thick);
    bracket_corner(&mut sheets, two, thick);
    sheets.finish()
}

/// Mirror image that swaps base and wall: (x, y, z) to (z, y, x). It turns orientation round.
fn swap_xz(p: DVec3) -> DVec3 {
    DVec3::new(p.z, p.y, p.x)
}

/// Top, bottom, end and sides of the base arm and of the wall arm, with their bores.
fn bracket_plates(sheets: &mut Sheets, two: u32, thick: u32) {
    let four = 2 * two;
    let (s, t) = (2.0 / f64::from(two), 1.0 / f64::from(thick));
    // Base and wall are mirror images but for their bores.
    for wall in [false, true] {
        let mut add = |m: u32, n: u32, point: &dyn Fn(u32, u32) -> DVec3| {
            if wall {
                sheets.add(n, m, |i, j| swap_xz(point(j, i)));
            } else {
                sheets.add(m, n, point);
            }
        };
        // End face x = 6, sides y = 0 and y = 4.
        add(four, thick, &|i, j| DVec3::new(6.0, s * f64::from(i), t * f64::from(j)));
        add(four, thick, &|i, j| DVec3::new(2.0 + s * f64::from(i), 0.0, t * f64::from(j)));
        add(thick, four, &|i, j| DVec3::new(2.0 + s * f64::from(j), 4.0, t * f64::from(i)));
        if wall {
            continue;
        }
        // Plain half of the base, top and bottom.
        add(two, four, &|i, j| DVec3::new(2.0 + s * f64::from(i), s * f64::from(j), 1.0));
        add(four, two, &|i, j| DVec3::new(2.0 + s * f64::from(j), s * f64::from(i), 0.0));
    }
    // Bored squares.
    for y in [1.0, 3.0] {
        sheets.add_bore(two, thick, 1.0, 0.55, |p, z| DVec3::new(5.0 + p.x, y + p.y, z));
    }
    sheets.add_bore(four, thick, 2.0, 1.2, |p, x| DVec3::new(x, 2.0 + p.x, 4.0 + p.y));
}

/// The corner block: underside, back, fillet and the two sides.
fn bracket_corner(sheets: &mut Sheets, two: u32, thick: u32) {
    let four = 2 * two;
    let s = 2.0 / f64::from(two);
    // Outer path from (2, 0) over the origin to (0, 2), inner path along the fillet, as (x, z).
    let outer = |i: u32| DVec2::new((2.0 - s * f64::from(i)).max(0.0), (s * f64::from(i) - 2.0).max(0.0));
    let inner = |i: u32| {
        let angle = 0.5 * PI * f64::from(i) / f64::from(four);
        DVec2::new(2.0 - angle.sin(), 2.0 - angle.cos())
    };
    let place = |p: DVec2, y: f64| DVec3::new(p.x, y, p.y);
    sheets.add(four, four, |i, j| place(outer(i), s * f64::from(j)));
    sheets.add(four, four, |i, j| place(inner(j), s * f64::from(i)));
    let across = |i: u32, j: u32| outer(i).lerp(inner(i), f64::from(j) / f64::from(thick));
    sheets.add(thick, four, |i, j| place(across(j, i), 0.0));
    sheets.add(four, thick, |i, j| place(across(i, j), 4.0));
}

/// Number of steps of a length, at least `least`.
fn count(length: f64, step: f64, least: u32) -> u32 {
    if step > 0.0 { (length / step).round().clamp(f64::from(least), 1000.0) as u32 } else { least }
}

/// Closed smooth surface of a genus: a slab with a row of holes, Loop-subdivided `levels` times (at most 6).
pub fn smooth_genus(genus: u32, levels: u32) -> TriMesh {
    loop_subdivided(genus::row_of_holes(genus, 1), levels)
}

/// Closed smooth lattice of `bars` bars a direction; its genus is the number of independent loops of its graph,
/// 3·bars²·(bars − 1) − bars³ + 1.
fn lattice(bars: usize, levels: u32) -> TriMesh {
    let n = 2 * bars - 1;
    let solid = voxel_surface([n, n, n], |cell| cell.iter().filter(|&&c| c % 2 == 1).count() <= 1);
    loop_subdivided(solid, levels)
}

fn loop_subdivided(mut mesh: TriMesh, levels: u32) -> TriMesh {
    for _ in 0..levels.min(6) {
        mesh = loop_step(&mesh);
    }
    mesh
}

/// Boundary of the filled unit cells of a box, triangulated; cells may only touch along whole faces.
fn voxel_surface(size: [usize; 3], filled: impl Fn([usize; 3]) -> bool) -> TriMesh {
    let mut sheets = Sheets::new(1e-3);
    let is_filled =
        |c: [i64; 3]| (0..3).all(|k| c[k] >= 0 && (c[k] as usize) < size[k]) && filled(c.map(|x| x as usize));
    for x in 0..size[0] as i64 {
        for y in 0..size[1] as i64 {
            for z in 0..size[2] as i64 {
                let cell = [x, y, z];
                if !is_filled(cell) {
                    continue;
                }
                for axis in 0..3 {
                    for up in [false, true] {
                        let mut beyond = cell;
                        beyond[axis] += if up { 1 } else { -1 };
                        if !is_filled(beyond) {
                            let corner = DVec3::new(x as f64, y as f64, z as f64);
                            let unit = |k: usize| DVec3::AXES[(axis + k) % 3];
                            let base = corner + if up { unit(0) } else { DVec3::ZERO };
                            let (a, b) = if up { (unit(1), unit(2)) } else { (unit(2), unit(1)) };
                            sheets.add(1, 1, |i, j| base + a * f64::from(i) + b * f64::from(j));
                        }
                    }
                }
            }
        }
    }
    sheets.finish()
}

/// One step of Loop subdivision of a closed mesh ([Loop1987]).
fn loop_step(mesh: &TriMesh) -> TriMesh {
    let smooth = VertexMap::from_fn(mesh.vertex_count(), |v| {
        let n = mesh.valence(v) as f64;
        let centre = 0.375 + 0.25 * (TAU / n).cos();
        let beta = (0.625 - centre * centre) / n;
        let ring: DVec3 = mesh.neighbours(v).map(|w| mesh.position(w)).sum();
        mesh.position(v) * (1.0 - n * beta) + ring * beta
    });
    let fine = quarter(mesh, |mesh, e| {
        let [a, b] = mesh.ends(e).map(|v| mesh.position(v));
        let opposite = [Some(mesh.half_edge(e)), mesh.twin(mesh.half_edge(e))];
        let apexes: DVec3 = opposite.iter().flatten().map(|&h| mesh.position(mesh.origin(mesh.prev(h)))).sum();
        0.375 * (a + b) + 0.125 * apexes
    });
    let mut positions = fine.positions().values().to_vec();
    positions[..smooth.len()].copy_from_slice(smooth.values());
    build(positions, fine.to_faces())
}

/// Splits every triangle into four; `point` places the new vertex of an edge.
fn quarter(mesh: &TriMesh, point: impl Fn(&TriMesh, EdgeId) -> DVec3) -> TriMesh {
    let mut positions = mesh.positions().values().to_vec();
    let middle = EdgeMap::from_fn(mesh.edge_count(), |e| {
        positions.push(point(mesh, e));
        positions.len() as u32 - 1
    });
    let faces = mesh
        .faces()
        .flat_map(|f| {
            let [a, b, c] = mesh.face_vertices(f).map(|v| v.0);
            let [ab, bc, ca] = mesh.face_half_edges(f).map(|h| middle[mesh.edge(h)]);
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        })
        .collect();
    build(positions, faces)
}

/// Moves every vertex along its normal by `height` of its position.
pub fn displace(mesh: &TriMesh, height: impl Fn(DVec3) -> f64) -> TriMesh {
    let positions = mesh.vertices().map(|v| {
        let p = mesh.position(v);
        p + vertex_normal(mesh, v) * height(p)
    });
    build(positions.collect(), mesh.to_faces())
}

/// Moves every vertex along its normal by noise, uniform in ± `amplitude` times the bounding box's diagonal.
pub fn with_noise(mesh: &TriMesh, amplitude: f64, seed: u64) -> TriMesh {
    let size = amplitude * mesh.diagonal();
    let positions = mesh
        .vertices()
        .map(|v| mesh.position(v) + vertex_normal(mesh, v) * (size * (2.0 * random(seed, u64::from(v.0)) - 1.0)));
    build(positions.collect(), mesh.to_faces())
}

fn vertex_normal(mesh: &TriMesh, v: VertexId) -> DVec3 {
    mesh.outgoing(v).map(|h| mesh.vector_area(mesh.face(h))).sum::<DVec3>().normalize_or_zero()
}

/// Smooth function of space with values in -1..=1.
fn bumps(p: DVec3) -> f64 {
    (p.x + 0.3).sin() * (1.3 * p.y).cos() * (1.1 * p.z + 0.7).cos()
}

/// A number in 0..1 that depends on `seed` and `index` only (the finaliser of splitmix64).
pub fn random(seed: u64, index: u64) -> f64 {
    let mut x = seed
        .wrapping_mul(0x9e37_79b9_7f4a_7c15)
        .wrapping_add(index.wrapping_add(1).wrapping_mul(0xd1b5_4a32_d192_ed03));
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((x ^ (x >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

/// Random numbers, one after the other.
struct Dice {
    seed: u64,
    thrown: u64,
}

impl Dice {
    fn new(seed: u64) -> Self {
        Self { seed, thrown: 0 }
    }

    /// A number in 0..1.
    fn number(&mut self) -> f64 {
        self.thrown += 1;
        random(self.seed, self.thrown - 1)
    }

    /// A number between `low` and `high`.
    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.number()
    }

    /// A whole number below `n`.
    fn below(&mut self, n: usize) -> usize {
        (self.number() * n as f64) as usize
    }
}

/// Several meshes as one, in their order.
pub fn join(meshes: &[TriMesh]) -> TriMesh {
    let (mut positions, mut faces) = (Vec::new(), Vec::new());
    for mesh in meshes {
        let first = positions.len() as u32;
        positions.extend_from_slice(mesh.positions().values());
        faces.extend(mesh.to_faces().into_iter().map(|f| f.map(|v| v + first)));
    }
    build(positions, faces)
}

/// A mesh that is valid by construction.
fn build(positions: Vec<DVec3>, faces: Vec<[u32; 3]>) -> TriMesh {
    TriMesh::new(positions, &faces).expect("generated shapes are valid for every size and resolution")
}

/// Patches of triangulated grids that are welded where their borders coincide.
struct Sheets {
    /// Points closer than this are one.
    tolerance: f64,
    positions: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
}

impl Sheets {
    fn new(tolerance: f64) -> Self {
        Self { tolerance, positions: Vec::new(), faces: Vec::new() }
    }

    /// A grid of `m` by `n` cells, seen from outside with `i` to the right and `j` upwards.
    fn add(&mut self, m: u32, n: u32, point: impl Fn(u32, u32) -> DVec3) {
        let first = self.positions.len() as u32;
        for j in 0..=n {
            for i in 0..=m {
                self.positions.push(point(i, j));
            }
        }
        for j in 0..n {
            for i in 0..m {
                let a = first + j * (m + 1) + i;
                let (b, c, d) = (a + 1, a + m + 2, a + m + 1);
                let at = |v: u32| self.positions[v as usize];
                let (ac, bd) = (at(a).distance(at(c)), at(b).distance(at(d)));
                // The shorter diagonal; equal ones alternate, so that no direction is preferred.
                let equal = (ac - bd).abs() <= 1e-6 * ac;
                if (equal && (i + j) % 2 == 0) || (!equal && ac < bd) {
                    self.faces.extend([[a, b, c], [a, c, d]]);
                } else {
                    self.faces.extend([[a, b, d], [b, c, d]]);
                }
            }
        }
    }

    /// A square of half size `half` with a round hole, `n` steps a side; `place` maps its plane into space.
    fn add_ring(&mut self, n: u32, half: f64, radius: f64, place: impl Fn(DVec2) -> DVec3) {
        let around = 4 * n;
        // Radial steps grow from the spacing on the hole to the spacing on the square.
        let (small, large) = (TAU * radius / f64::from(around), 2.0 * half / f64::from(n));
        let gap = 1.15 * half - radius;
        let layers = count(gap, 0.5 * (small + large), 1);
        let ratio = (large / small).powf(1.0 / f64::from(layers));
        let fraction = |j: u32| {
            let grown = |j: u32| if (ratio - 1.0).abs() < 1e-9 { f64::from(j) } else { ratio.powi(j as i32) - 1.0 };
            grown(j) / grown(layers)
        };
        // From the outside inwards: where i goes to the right, the hole lies upwards.
        self.add(around, layers, |i, j| {
            let outside = square_border(i % around, n) * half;
            place(hole_point(i % around, around, radius).lerp(outside, fraction(layers - j)))
        });
    }

    /// A square plate with a round bore: both faces at 0 and 1 along `depth`, and the bore's wall.
    fn add_bore(&mut self, n: u32, thick: u32, half: f64, radius: f64, place: impl Fn(DVec2, f64) -> DVec3) {
        self.add_ring(n, half, radius, |p| place(p, 1.0));
        // The far side is the mirror image of the near one.
        self.add_ring(n, half, radius, |p| place(DVec2::new(p.x, -p.y), 0.0));
        let around = 4 * n;
        let deep = (2 * thick).max(1);
        self.add(around, deep, |i, j| {
            place(hole_point(i % around, around, radius), 1.0 - f64::from(j) / f64::from(deep))
        });
    }

    /// Welds and builds.
    fn finish(self) -> TriMesh {
        let weld = weld(&self.positions, self.tolerance);
        let mut positions = Vec::new();
        let mut new_id = vec![u32::MAX; self.positions.len()];
        let faces = self
            .faces
            .iter()
            .map(|f| {
                f.map(|v| {
                    let kept = weld[v as usize];
                    if new_id[kept] == u32::MAX {
                        new_id[kept] = positions.len() as u32;
                        positions.push(self.positions[kept]);
                    }
                    new_id[kept]
                })
            })
            .collect();
        build(positions, faces)
    }
}

/// Border point number `i` of the square -1..=1 with `n` steps a side, counter-clockwise from (1, -1).
fn square_border(i: u32, n: u32) -> DVec2 {
    let t = 2.0 * f64::from(i % n) / f64::from(n) - 1.0;
    match i / n {
        0 => DVec2::new(1.0, t),
        1 => DVec2::new(-t, 1.0),
        2 => DVec2::new(-1.0, -t),
        _ => DVec2::new(t, -1.0),
    }
}

/// Point of a circle opposite to [`square_border`]'s point of the same number.
fn hole_point(i: u32, around: u32, radius: f64) -> DVec2 {
    DVec2::from_angle(TAU * f64::from(i) / f64::from(around) - 0.25 * PI) * radius
}

/// For every point the first one that is nearly equal to it: no two coordinates differ by more than `tolerance`.
fn weld(points: &[DVec3], tolerance: f64) -> Vec<usize> {
    // Along a skew direction different points are far apart, equal ones are neighbours.
    let skew = DVec3::new(1.0, 0.618_033_988_749_895, 0.423_310_825_130_748);
    let mut order: Vec<(f64, usize)> = points.iter().enumerate().map(|(i, p)| (p.dot(skew), i)).collect();
    order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut sets = UnionFind::new(points.len());
    for (k, &(t, a)) in order.iter().enumerate() {
        for &(_, b) in order[k + 1..].iter().take_while(|(u, _)| u - t <= 3.0 * tolerance) {
            if (points[b] - points[a]).abs().max_element() <= tolerance {
                sets.join(a, b);
            }
        }
    }
    (0..points.len()).map(|i| sets.root(i)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::features::{FeatureGraph, FeatureOptions};
    use crate::metric::{corner_angles, edge_lengths};
    use crate::topology::Summary;

    /// Enclosed volume: positive if the faces look outwards.
    fn volume(mesh: &TriMesh) -> f64 {
        mesh.faces().map(|f| mesh.vector_area(f).dot(mesh.position(mesh.face_vertices(f)[0])) / 3.0).sum()
    }

    /// Asserts a closed, connected mesh of a genus whose faces have areas and look outwards.
    pub(super) fn check_closed(mesh: &TriMesh, genus: u32) {
        let s = Summary::of(mesh.connectivity());
        assert_eq!((s.components, s.boundary_loops, s.genus), (1, 0, i64::from(genus)), "{s:?}");
        assert_eq!(s.chi, 2 - 2 * i64::from(genus));
        let smallest = mesh.faces().map(|f| mesh.vector_area(f).length()).fold(f64::INFINITY, f64::min);
        assert!(smallest > 0.0, "a face has no area: {s:?}");
        assert!(volume(mesh) > 0.0, "turned inside out: {s:?}");
    }

    /// Smallest angle of all faces, degrees.
    pub(super) fn smallest_angle(mesh: &TriMesh) -> f64 {
        let angles = corner_angles(mesh.connectivity(), &edge_lengths(mesh));
        angles.values().iter().fold(PI, |smallest, &a| smallest.min(a)).to_degrees()
    }

    #[test]
    fn every_sample_has_its_topology() {
        // (name, components, boundary loops, genus)
        let expected = [
            ("sphere", 1, 0, 0),
            ("torus", 1, 0, 1),
            ("genus2", 1, 0, 2),
            ("genus3", 1, 0, 3),
            ("genus4", 1, 0, 4),
            ("holes", 1, 0, 49),
            ("lattice", 1, 0, 28),
            ("cube", 1, 0, 0),
            ("cylinder", 1, 2, 0),
            ("plate", 1, 6, 0),
            ("bracket", 1, 0, 3),
            ("bumpy_sphere", 1, 0, 0),
            ("bumpy_torus", 1, 0, 1),
            ("noisy_sphere", 1, 0, 0),
            ("noisy_torus", 1, 0, 1),
            ("two_spheres", 2, 0, 0),
        ];
        assert_eq!(expected.map(|e| e.0).to_vec(), sample_names().iter().map(|s| s.0).collect::<Vec<_>>());
        for (name, components, boundary_loops, genus) in expected {
            let mesh = sample(name).unwrap();
            let s = Summary::of(mesh.connectivity());
            assert_eq!((s.components, s.boundary_loops, s.genus), (components, boundary_loops, genus), "{name}");
            assert!((1000..40000).contains(&s.faces), "{name} has {} faces", s.faces);
            let smallest = mesh.faces().map(|f| mesh.vector_area(f).length()).fold(f64::INFINITY, f64::min);
            assert!(smallest > 0.0, "{name} has a face without area");
            if boundary_loops == 0 {
                assert!(volume(&mesh) > 0.0, "{name} is turned inside out");
            }
        }
        assert_eq!(sample("no such sample"), None);
    }

    #[test]
    fn sizes_are_as_described() {
        assert!((volume(&sphere(2.0, 5)) / (4.0 / 3.0 * PI * 8.0) - 1.0).abs() < 0.01);
        assert!((volume(&torus(1.0, 0.4, 96, 48)) / (2.0 * PI * PI * 0.16) - 1.0).abs() < 0.01);
        assert!((volume(&cube(2.0, 5)) - 8.0).abs() < 1e-9);
        assert!((cylinder(1.0, 3.0, 200, 10).area() / (6.0 * PI) - 1.0).abs() < 0.001);
        let holes = PI * (2.0 * 0.6f64.powi(2) + 2.0 * 0.45f64.powi(2) + 0.3f64.powi(2));
        assert!((plate_with_holes(0.05).area() / (24.0 - holes) - 1.0).abs() < 0.001);
        // Two plates, the corner square without the fillet's quarter disk, minus the bores.
        let corner = 4.0 * (4.0 - 0.25 * PI);
        let solid = 16.0 + 16.0 + corner - PI * (2.0 * 0.55f64.powi(2) + 1.2f64.powi(2));
        assert!((volume(&bracket(0.08)) / solid - 1.0).abs() < 0.002, "{} {solid}", volume(&bracket(0.08)));
    }

    #[test]
    fn the_bracket_has_its_creases() {
        let mesh = bracket(0.2);
        let (features, dropped) = FeatureGraph::detect(&mesh, &FeatureOptions::default());
        assert_eq!(dropped, 0);
        // Three bores with two rims each; no other closed curve.
        assert_eq!(features.chains.iter().filter(|c| c.closed).count(), 6);
        // Five corners of the L on each side; the fillet's ends are smooth.
        assert_eq!(features.is_corner.values().iter().filter(|&&c| c).count(), 10);
        let ratio = |f| {
            let length = mesh.sides(f).map(|h| mesh.position(mesh.origin(h)).distance(mesh.position(mesh.target(h))));
            let (short, long) = length.fold((f64::INFINITY, 0.0f64), |(s, l), x| (s.min(x), l.max(x)));
            long / short
        };
        let worst = mesh.faces().map(ratio).fold(0.0, f64::max);
        assert!(worst < 5.0, "aspect {worst}");
        assert!((8000..15000).contains(&mesh.face_count()), "{} faces", mesh.face_count());
    }

    #[test]
    fn noise_repeats() {
        assert_eq!(sample("noisy_torus"), sample("noisy_torus"));
        assert_ne!(with_noise(&sphere(1.0, 2), 0.01, 1), with_noise(&sphere(1.0, 2), 0.01, 2));
    }

    #[test]
    fn smallest_resolutions_are_valid() {
        for mesh in [torus(1.0, 0.3, 0, 0), cylinder(1.0, 1.0, 0, 0), cube(1.0, 0), bracket(9.0), plate_with_holes(9.0)]
        {
            assert!(mesh.face_count() > 0);
        }
        for genus in 0..6 {
            assert_eq!(Summary::of(smooth_genus(genus, 1).connectivity()).genus, i64::from(genus));
        }
    }
}
