//! Which points of the copies of a picture are the same: copies are glued along the sides of quarter-tubes.
//!
//! In: a [`LocalPicture`], the target. Out: [`Glue`]. Holds: points on glued sides are one vertex, all others are their own.
//! Source: [Razafindrazaka2015] §9.5.

use super::DrawError;
use super::local::LocalPicture;
use quadloom_mesh::Id;
use quadloom_regular_maps::ids::FlagId;
use quadloom_regular_maps::map::{Reflection, RegularMap};

/// Which vertices of the copies are the same.
pub(super) struct Glue {
    /// For each copy (flag of the target) and point of the picture, the vertex of the drawing.
    vertex: Vec<u32>,
    /// Copy and point that a vertex takes its place from.
    pub origin: Vec<(FlagId, u32)>,
    points: usize,
}

impl Glue {
    pub fn new(picture: &LocalPicture, target: &RegularMap) -> Result<Self, DrawError> {
        let points = picture.points.len();
        let pairs = glued_sides(picture)?;
        let mut root: Vec<u32> = (0..(points * target.order()) as u32).collect();
        for flag in target.flags() {
            for (by, list) in &pairs {
                let there = target.reflect(flag, *by);
                for &(here, other) in list {
                    let [a, b] = [(flag, here), (there, other)].map(|(f, i)| (f.index() * points) as u32 + i);
                    join(&mut root, a, b);
                }
            }
        }
        let mut origin = Vec::new();
        let mut vertex = vec![0; root.len()];
        for k in 0..root.len() as u32 {
            let to = find(&mut root, k);
            if to == k {
                vertex[k as usize] = origin.len() as u32;
                origin.push((FlagId(k / points as u32), k % points as u32));
            } else {
                vertex[k as usize] = vertex[to as usize];
            }
        }
        Ok(Self { vertex, origin, points })
    }

    /// The vertex of a point of a copy.
    pub fn vertex(&self, copy: FlagId, point: u32) -> u32 {
        self.vertex[copy.index() * self.points + point as usize]
    }
}

type Pairs = Vec<(u32, u32)>;

/// Points that are the same on a quarter-tube and on its neighbour: a and c to themselves, turned round; d to b.
fn glued_sides(picture: &LocalPicture) -> Result<[(Reflection, Pairs); 3], DrawError> {
    let [a, b, c, d] = picture.sides();
    let along =
        |list: &[u32], k: usize| -> Vec<f64> { list.iter().map(|&i| picture.points[i as usize].uv[k]).collect() };
    let turned = |list: &[u32]| list.iter().rev().copied().collect::<Vec<_>>();
    let alike = |one: Vec<f64>, other: Vec<f64>| {
        one.len() == other.len() && one.iter().zip(&other).all(|(x, y)| (x - y).abs() < 1e-5)
    };
    let mirrored = |list: &[u32]| along(&turned(list), 1).into_iter().map(|v| 1.0 - v).collect::<Vec<_>>();
    for (side, fits) in [
        ('a', alike(along(&a, 1), mirrored(&a))),
        ('c', alike(along(&c, 1), mirrored(&c))),
        ('d', alike(along(&d, 0), along(&b, 0))),
    ] {
        if !fits {
            return Err(DrawError::Sides(side));
        }
    }
    let zip = |one: &[u32], other: &[u32]| one.iter().copied().zip(other.iter().copied()).collect::<Vec<_>>();
    Ok([(Reflection::R1, zip(&a, &turned(&a))), (Reflection::R0, zip(&c, &turned(&c))), (Reflection::R2, zip(&d, &b))])
}

fn find(root: &mut [u32], mut x: u32) -> u32 {
    while root[x as usize] != x {
        root[x as usize] = root[root[x as usize] as usize];
        x = root[x as usize];
    }
    x
}

fn join(root: &mut [u32], a: u32, b: u32) {
    let (a, b) = (find(root, a), find(root, b));
    root[a.max(b) as usize] = a.min(b);
}
