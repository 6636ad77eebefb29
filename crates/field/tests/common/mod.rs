//! Small meshes for the tests, each with its Euler characteristic known beforehand.
#![allow(dead_code)]

use quadloom_mesh::{DVec3, TriMesh};
use std::collections::BTreeMap;

/// Splits every triangle in four, `levels` times.
pub fn subdivide(mut points: Vec<DVec3>, mut faces: Vec<[u32; 3]>, levels: usize) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    for _ in 0..levels {
        let mut middle = BTreeMap::new();
        let mut finer = Vec::new();
        for [a, b, c] in faces {
            let mut mid = |i: u32, j: u32| {
                *middle.entry((i.min(j), i.max(j))).or_insert_with(|| {
                    points.push(0.5 * (points[i as usize] + points[j as usize]));
                    points.len() as u32 - 1
                })
            };
            let (ab, bc, ca) = (mid(a, b), mid(b, c), mid(c, a));
            finer.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        faces = finer;
    }
    (points, faces)
}

/// A cube with sharp edges: 12·4^levels triangles.
pub fn cube(levels: usize) -> TriMesh {
    let points: Vec<DVec3> =
        (0..8).map(|k| DVec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2 & 1))).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let (points, faces) = subdivide(points, faces, levels);
    TriMesh::new(points, &faces).unwrap()
}

/// A sphere from an octahedron: 8·4^levels triangles.
pub fn sphere(levels: usize) -> TriMesh {
    let points = vec![DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z];
    let faces = vec![[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]];
    let (points, faces) = subdivide(points, faces, levels);
    TriMesh::new(points.into_iter().map(DVec3::normalize).collect(), &faces).unwrap()
}

/// A torus of radii 1 and 0.2 with m × n vertices.
pub fn torus(m: u32, n: u32) -> TriMesh {
    let mut points = Vec::new();
    let mut faces = Vec::new();
    for i in 0..m {
        for j in 0..n {
            let (a, b) = (f64::from(i) / f64::from(m), f64::from(j) / f64::from(n));
            let (sa, ca) = (std::f64::consts::TAU * a).sin_cos();
            let (sb, cb) = (std::f64::consts::TAU * b).sin_cos();
            points.push(DVec3::new((1.0 + 0.2 * cb) * ca, (1.0 + 0.2 * cb) * sa, 0.2 * sb));
            let id = |i: u32, j: u32| (i % m) * n + j % n;
            let (p, q, r, s) = (id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1));
            faces.extend([[p, q, r], [p, r, s]]);
        }
    }
    TriMesh::new(points, &faces).unwrap()
}

/// A flat n × n square, bent by `height`.
pub fn plate(n: u32, height: f64) -> TriMesh {
    let mut points = Vec::new();
    let mut faces = Vec::new();
    for i in 0..=n {
        for j in 0..=n {
            let (x, y) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
            points.push(DVec3::new(x, y, height * (5.0 * x).sin() * (4.0 * y).cos()));
            if i < n && j < n {
                let id = |i: u32, j: u32| i * (n + 1) + j;
                let (p, q, r, s) = (id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1));
                faces.extend(if (i + j) % 2 == 0 { [[p, q, r], [p, r, s]] } else { [[p, q, s], [q, r, s]] });
            }
        }
    }
    TriMesh::new(points, &faces).unwrap()
}
