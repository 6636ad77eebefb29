//! What is asked of each component: the options, told in the vertices of the file, handed out to where these are.
//!
//! In: a file as it was read, its repaired mesh, its components and their shares, the options. Out: a [`PartRequest`]
//! per component, and warnings about what fits none. Holds: every id in a request is one of its component.

use crate::error::{RemeshError, Warning};
use crate::features::FeatureRequest;
use crate::guides::{
    astray, astray_guides_warning, far_guides, far_guides_warning, is_at_one_vertex, short_guides_warning,
};
use crate::ladder::attempts_of_piece;
use crate::options::{Fallback, GivenField, RemeshOptions};
use crate::part::PartRequest;
use crate::singularities::{SingularityRequest, check_list};
use crate::sizes::SizeRequest;
use crate::ties::TieRequest;
use crate::warnings::missing_edges_warning;
use quadloom_mesh::repair::{Component, Repaired};
use quadloom_mesh::{ClosestPoint, DVec3, FaceMap, FaceSoup, TriMesh, VertexId, VertexMap};

/// What is asked of each component; what fits no component is an error or a warning.
///
/// # Input      share: number of quads of each component; soup: the file that the options count in
/// # Errors     [`RemeshError::Mismatch`]: something named is not there, or cannot be
/// # Cost       linear, and closest-point queries for the points of drawn curves
pub fn requests<'a>(
    soup: &FaceSoup,
    repaired: &Repaired,
    components: &'a [Component],
    share: &[usize],
    options: &RemeshOptions,
    warnings: &mut Vec<Warning>,
) -> Result<Vec<PartRequest<'a>>, RemeshError> {
    let input = Input { soup, repaired, components, place: places(repaired, components) };
    let several = components.len() > 1;
    let blank = |(component, &quads): (&'a Component, &usize)| blank_request(&component.mesh, quads, several, options);
    let mut requests: Vec<PartRequest> = components.iter().zip(share).map(blank).collect();
    // 1. Named edges.
    let missing = input.hand_out_edges(&options.features, &mut requests);
    warnings.extend(missing_edges_warning(&missing));
    // 2. Singular vertices.
    input.hand_out_singularities(options, &mut requests)?;
    // 3. Ties.
    for &asked in &options.ties {
        let (i, tie) = input.tie(asked)?;
        requests[i].ties.push(tie);
    }
    // 4. Drawn curves.
    warnings.extend(input.hand_out_guides(&options.guides, &mut requests));
    // 5. Density.
    if let Some(name) = &options.density {
        input.hand_out_density(density(soup, name)?, &mut requests);
    }
    // 6. The given field.
    if let Some(field) = &options.field {
        input.hand_out_field(field, &mut requests)?;
    }
    Ok(requests)
}

/// Where each vertex of the repaired mesh is among the components.
fn places(repaired: &Repaired, components: &[Component]) -> VertexMap<(usize, VertexId)> {
    let mut place = VertexMap::filled(repaired.mesh.vertex_count(), (0, VertexId(0)));
    for (i, component) in components.iter().enumerate() {
        for (v, &whole) in component.vertex_of.iter() {
            place[whole] = (i, v);
        }
    }
    place
}

/// What is asked of any component.
fn blank_request<'a>(mesh: &'a TriMesh, quads: usize, several: bool, options: &RemeshOptions) -> PartRequest<'a> {
    PartRequest {
        mesh,
        quads,
        features: FeatureRequest { sharp_angle: options.sharp_angle, ..FeatureRequest::default() },
        field: None,
        sizes: SizeRequest {
            adaptivity: options.adaptivity,
            adapt_to: options.adapt_to,
            anisotropy: options.anisotropy,
            curl_correction: options.curl_correction,
            density: None,
        },
        singularities: Vec::new(),
        ties: Vec::new(),
        attempts: match options.fallback {
            Fallback::Split if several => attempts_of_piece(quads),
            _ => usize::MAX,
        },
    }
}

/// The input, and where its vertices are.
struct Input<'a> {
    soup: &'a FaceSoup,
    repaired: &'a Repaired,
    components: &'a [Component],
    /// Component, and vertex of it, of each vertex of the repaired mesh.
    place: VertexMap<(usize, VertexId)>,
}

impl Input<'_> {
    /// Component, and vertex of it, of a vertex of the file.
    fn find(&self, id: u32) -> Option<(usize, VertexId)> {
        Some(self.place[(*self.repaired.vertex_of_input.get(id as usize)?)?])
    }

    /// # Output     named edges that no component has
    fn hand_out_edges(&self, named: &[[u32; 2]], requests: &mut [PartRequest]) -> Vec<[u32; 2]> {
        let mut missing = Vec::new();
        for &edge in named {
            match edge.map(|v| self.find(v)) {
                [Some((i, a)), Some((j, b))] if i == j && self.components[i].mesh.find_edge(a, b).is_some() => {
                    requests[i].features.edges.push([a, b]);
                }
                _ => missing.push(edge),
            }
        }
        missing
    }

    fn hand_out_singularities(&self, options: &RemeshOptions, requests: &mut [PartRequest]) -> Result<(), RemeshError> {
        for &(asked, quarters) in options.singularities.iter().flatten() {
            let (i, vertex) = self.find(asked).ok_or_else(|| RemeshError::Mismatch {
                what: "the list of singularities",
                why: no_vertex(self.soup, asked),
            })?;
            requests[i].singularities.push(SingularityRequest { asked, vertex, quarters, named: true });
        }
        if options.singularities.as_ref().is_some_and(Vec::is_empty) && !options.other_singularities {
            for (request, component) in requests.iter_mut().zip(self.components) {
                request.singularities.extend(SingularityRequest::of_no_vertex(&component.mesh));
            }
        }
        let several = requests.len() > 1;
        requests.iter().enumerate().try_for_each(|(i, request)| {
            let checked = check_list(request.mesh, &request.singularities, options.other_singularities);
            checked.map_err(|e| match e {
                RemeshError::Mismatch { what, why } if several => {
                    RemeshError::Mismatch { what, why: format!("component {}: {why}", i + 1) }
                }
                other => other,
            })
        })
    }

    /// The component of a tie, and the tie there.
    fn tie(&self, asked: [u32; 2]) -> Result<(usize, TieRequest), RemeshError> {
        let [a, b] = asked;
        let why = match asked.map(|v| self.find(v)) {
            [Some((i, a)), Some((j, b))] if i == j && a != b => return Ok((i, TieRequest { asked, vertices: [a, b] })),
            [Some((i, _)), Some((j, _))] if i == j => {
                "both are one point of the surface; name two different ones".into()
            }
            [Some((i, _)), Some((j, _))] => format!(
                "its ends are on components {} and {} of the surface, and no chain of quad edges leads from one to \
                 another; name two vertices of one component",
                i + 1,
                j + 1
            ),
            [None, _] => no_vertex(self.soup, a),
            [_, None] => no_vertex(self.soup, b),
        };
        Err(RemeshError::Mismatch { what: "a tie", why: format!("--tie {a},{b}: {why}") })
    }

    /// Curves go to the component that their first point is nearest to.
    ///
    /// # Output     warnings about those that cannot be followed as they are drawn
    fn hand_out_guides(&self, guides: &[Vec<DVec3>], requests: &mut [PartRequest]) -> Vec<Warning> {
        if guides.is_empty() {
            return Vec::new();
        }
        let mesh = &self.repaired.mesh;
        let surface = ClosestPoint::new(mesh);
        let far = far_guides(mesh, &surface, guides);
        let (mut short, mut strayed) = (Vec::new(), Vec::new());
        for (k, guide) in guides.iter().enumerate() {
            let Some(i) = self.nearest_component(guide) else { continue };
            let request = &mut requests[i];
            request.features.guides.push(guide.clone());
            let quad_edge = (request.mesh.area() / request.quads as f64).sqrt();
            if far.iter().any(|f| f.0 == k) {
                continue;
            }
            if is_at_one_vertex(request.mesh, guide) {
                short.push(k);
            } else if let Some(distance) = astray(request.mesh, &surface, guide, quad_edge) {
                strayed.push((k, distance));
            }
        }
        let of_far = far_guides_warning(mesh, guides.len(), &far);
        let of_short = short_guides_warning(guides.len(), &short);
        [of_far, of_short, astray_guides_warning(guides.len(), &strayed)].into_iter().flatten().collect()
    }

    fn nearest_component(&self, guide: &[DVec3]) -> Option<usize> {
        let &first = guide.first()?;
        let mesh = &self.repaired.mesh;
        let distance = |v: &VertexId| mesh.position(*v).distance_squared(first);
        mesh.vertices().min_by(|a, b| distance(a).total_cmp(&distance(b))).map(|v| self.place[v].0)
    }

    /// # Input      value: of each vertex of the file
    fn hand_out_density(&self, value: &[f64], requests: &mut [PartRequest]) {
        let mut whole = VertexMap::filled(self.repaired.mesh.vertex_count(), 0.0);
        for (i, v) in self.repaired.vertex_of_input.iter().enumerate() {
            if let Some(v) = *v {
                whole[v] = value.get(i).copied().unwrap_or(0.0);
            }
        }
        for (request, component) in requests.iter_mut().zip(self.components) {
            request.sizes.density = Some(component.vertex_of.map(|&v| whole[v]));
        }
    }

    fn hand_out_field(&self, field: &GivenField, requests: &mut [PartRequest]) -> Result<(), RemeshError> {
        if field.directions.len() != self.soup.faces.len() {
            let why = format!("it has {} vectors, the input {} faces", field.directions.len(), self.soup.faces.len());
            return Err(RemeshError::Mismatch { what: "the cross field", why });
        }
        for (request, component) in requests.iter_mut().zip(self.components) {
            let direction = |f| field.directions[self.repaired.input_face[component.face_of[f]] as usize];
            request.field = Some(FaceMap::from_fn(component.mesh.face_count(), direction));
        }
        Ok(())
    }
}

/// The values of a vertex attribute of the file, none of them negative.
fn density<'a>(soup: &'a FaceSoup, name: &str) -> Result<&'a [f64], RemeshError> {
    let found = soup.vertex_attributes.iter().find(|(n, _)| n == name);
    let values = found.map(|(_, values)| values.as_slice()).ok_or_else(|| {
        let names: Vec<String> = soup.vertex_attributes.iter().map(|(n, _)| format!("`{n}`")).collect();
        let there = match &names[..] {
            [] => "it has no attributes at all (OBJ and STL cannot have any)".into(),
            _ => format!("it has {}", names.join(", ")),
        };
        let why = format!("there is no vertex attribute `{name}` (colours are none); {there}");
        RemeshError::Mismatch { what: "--density", why }
    })?;
    match values.iter().position(|&value| !(value.is_finite() && value >= 0.0)) {
        None => Ok(values),
        Some(v) => {
            let why = format!("`{name}` is {} at vertex {v}; numbers of zero and more are needed", values[v]);
            Err(RemeshError::Mismatch { what: "--density", why })
        }
    }
}

/// Says that a vertex is not there, and what is.
fn no_vertex(soup: &FaceSoup, asked: u32) -> String {
    match soup.positions.len() {
        count if (asked as usize) < count => {
            format!("vertex {asked} of the input is on no face that is left after repair; name one of a face")
        }
        count => format!(
            "there is no vertex {asked}: the input has {count}, numbered from 0 to {}; name one of those",
            count.saturating_sub(1)
        ),
    }
}
