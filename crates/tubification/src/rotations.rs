//! The rotations of space that a tube surface really has.
//!
//! In: a target map and points of its tube surface, the same on every quarter-tube. Out: [`Measured`].
//! Holds: each listed automorphism of the target is carried out by a rotation up to the tolerance, and every automorphism
//! that is not listed is not. Not: mirror images; symmetries that do not map quarter-tubes to quarter-tubes.

use crate::skeleton::symmetry::PointGroup;
use glam::{DMat3, DVec3};
use quadloom_mesh::Id;
use quadloom_regular_maps::ids::{FlagId, FlagMap, MapFaceId};
use quadloom_regular_maps::map::RegularMap;

/// A rotation group that was measured.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Its name.
    pub group: PointGroup,
    /// Automorphisms of the target, as the flags that they take flag 0 to, and their rotations; the identity first.
    pub elements: Vec<(FlagId, DMat3)>,
    /// Largest distance of a point from where its rotation should take it, as a share of the surface's size.
    pub error: f64,
}

/// Points are the same where they are this close, as a share of the surface's size: surfaces are computed to about 1e-12.
const TOLERANCE: f64 = 1e-7;

/// Measures the rotation group of a tube surface.
///
/// # Input      `points`: points of the surface on a flag's quarter-tube, at the same (u, v) on each
/// # Cost       (automorphisms) × (points) at worst; most are refused by the first few points
pub fn measure(target: &RegularMap, points: impl Fn(FlagId) -> Vec<DVec3>) -> Measured {
    let samples: FlagMap<Vec<DVec3>> = FlagMap::from_vec(target.flags().map(points).collect());
    let all = || samples.values().iter().flatten();
    let centre = all().sum::<DVec3>() / all().count().max(1) as f64;
    let size = all().map(|p| p.distance(centre)).fold(f64::MIN_POSITIVE, f64::max);
    let samples = FlagMap::from_vec(
        samples.values().iter().map(|list| list.iter().map(|p| (*p - centre) / size).collect::<Vec<_>>()).collect(),
    );
    let mut elements = Vec::new();
    let mut error = 0.0f64;
    for h in target.flags() {
        if let Some((rotation, worst)) = rotation_of(target, &samples, h) {
            elements.push((h, rotation));
            error = error.max(worst);
        }
    }
    Measured { group: name(target, &elements), elements, error }
}

impl Measured {
    /// Orbits of the faces of a source under the measured rotations, each by number, the largest first.
    ///
    /// # Input      for each flag of the target the element of the source's group, as in [`quadloom_regular_maps::TubeMatch::element`]
    pub fn face_orbits(&self, source: &RegularMap, element: &FlagMap<FlagId>) -> Vec<Vec<MapFaceId>> {
        self.orbits(source, element, source.face_count(), |g| source.face(g).index())
            .into_iter()
            .map(|orbit| orbit.into_iter().map(|f| MapFaceId(f as u32)).collect())
            .collect()
    }

    /// The same for the faces of the dual.
    pub fn vertex_orbits(&self, source: &RegularMap, element: &FlagMap<FlagId>) -> Vec<Vec<usize>> {
        self.orbits(source, element, source.vertex_count(), |g| source.vertex(g).index())
    }

    fn orbits(
        &self,
        source: &RegularMap,
        element: &FlagMap<FlagId>,
        count: usize,
        cell: impl Fn(FlagId) -> usize,
    ) -> Vec<Vec<usize>> {
        let mut first = vec![None; count];
        source.flags().for_each(|g| _ = first[cell(g)].get_or_insert(g));
        let images: Vec<Vec<FlagId>> = self.elements.iter().map(|&(h, _)| source.automorphism(element[h])).collect();
        let mut seen = vec![false; count];
        let mut orbits = Vec::new();
        for start in 0..count {
            let Some(flag) = first[start] else { continue };
            if seen[start] {
                continue;
            }
            let mut orbit: Vec<usize> = images.iter().map(|image| cell(image[flag.index()])).collect();
            orbit.sort_unstable();
            orbit.dedup();
            orbit.iter().for_each(|&c| seen[c] = true);
            orbits.push(orbit);
        }
        orbits.sort_by_key(|orbit| (std::cmp::Reverse(orbit.len()), orbit[0]));
        orbits
    }
}

/// The rotation that carries out an automorphism, if one does, and its error.
fn rotation_of(target: &RegularMap, samples: &FlagMap<Vec<DVec3>>, h: FlagId) -> Option<(DMat3, f64)> {
    let image = target.automorphism(h);
    let pairs = || {
        let there = |f: FlagId| samples[f].iter().zip(&samples[image[f.index()]]);
        target.flags().flat_map(there)
    };
    if pairs().any(|(a, b)| (a.length() - b.length()).abs() > TOLERANCE) {
        return None;
    }
    // A frame from the two directions that are nearest to perpendicular, among the first point and all others.
    let (a, a_image) = pairs().max_by(|x, y| x.0.length().total_cmp(&y.0.length()))?;
    let (b, b_image) = pairs().max_by(|x, y| a.cross(*x.0).length().total_cmp(&a.cross(*y.0).length()))?;
    let rotation = frame(*a_image, *b_image)? * frame(*a, *b)?.transpose();
    let worst = pairs().map(|(p, q)| (rotation * *p).distance(*q)).fold(0.0, f64::max);
    (worst < TOLERANCE).then_some((rotation, worst))
}

fn frame(a: DVec3, b: DVec3) -> Option<DMat3> {
    let x = a.try_normalize()?;
    let z = x.cross(b).try_normalize()?;
    Some(DMat3::from_cols(x, z.cross(x), z))
}

/// A finite rotation group is known by its order and the largest order of an element.
fn name(target: &RegularMap, elements: &[(FlagId, DMat3)]) -> PointGroup {
    let order = elements.len();
    let largest = elements.iter().map(|(h, _)| target.order_of(*h)).max().unwrap_or(1);
    match (order, largest) {
        (12, 3) => PointGroup::Tetrahedral,
        (24, 4) => PointGroup::Octahedral,
        (60, 5) => PointGroup::Icosahedral,
        (n, m) if n == 2 * m => PointGroup::Dihedral(m),
        (n, _) => PointGroup::Cyclic(n),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::skeleton::upright_flags;
    use quadloom_regular_maps::coset::CosetLimit;
    use quadloom_regular_maps::presentation::Presentation;

    fn solid(p: usize, q: usize, stretch: f64) -> Measured {
        let presentation = Presentation::new(p, q, vec![]);
        let map = RegularMap::from_presentation(&presentation, CosetLimit::default()).unwrap();
        let skeleton = crate::skeleton::spherical(&map).unwrap();
        let upright = upright_flags(&map);
        measure(&map, |f| {
            let line = skeleton.outward(&map, f);
            let lift = if upright[f] { 0.1 } else { -0.1 };
            let lifted = line[0] + lift * skeleton.normals[map.vertex(f).index()];
            [lifted, line[1]].map(|x| x * DVec3::new(1.0, 1.0, stretch)).to_vec()
        })
    }

    #[test]
    fn platonic_solids_have_their_rotation_groups() {
        assert_eq!(solid(3, 3, 1.0).group, PointGroup::Tetrahedral);
        assert_eq!(solid(4, 3, 1.0).group, PointGroup::Octahedral);
        assert_eq!(solid(3, 4, 1.0).group, PointGroup::Octahedral);
        assert_eq!(solid(5, 3, 1.0).group, PointGroup::Icosahedral);
        assert_eq!(solid(3, 5, 1.0).group, PointGroup::Icosahedral);
    }

    #[test]
    fn a_stretched_solid_has_fewer_rotations() {
        assert!(solid(5, 3, 1.3).elements.len() < 60);
    }
}
