//! Meshes: typed ids and maps, half-edge connectivity, metric, topology, features, remeshing, repair, shapes.
//!
//! In: positions and faces. Out: [`TriMesh`], [`QuadMesh`], [`PolygonMesh`], and what can be asked of them.
//! Holds: a mesh value is an oriented 2-manifold with boundary; connectivity never reads a position.
#![warn(missing_docs)]

pub mod closest;
pub mod connectivity;
pub mod features;
mod heap;
pub mod ids;
pub mod intersections;
pub mod mesh;
pub mod metric;
pub mod progress;
pub mod refine;
pub mod remesh;
pub mod repair;
pub mod shapes;
pub mod soup;
pub mod surface_point;
pub mod topology;
mod union_find;

pub use closest::{ChainPoint, Closest, ClosestPoint, PolylineIndex};
pub use connectivity::{
    Connectivity, Defect, FaceShape, Fixed, Mixed, PolygonConnectivity, QuadConnectivity, TriConnectivity,
};
pub use features::{ChainId, FeatureChain, FeatureGraph, FeatureKind};
pub use glam::{DVec2, DVec3};
pub use ids::{
    CornerId, CornerMap, EdgeId, EdgeMap, FaceId, FaceMap, HalfEdgeId, HalfEdgeMap, Id, IdMap, VertexId, VertexMap,
};
pub use intersections::{intersects_itself, self_intersections};
pub use mesh::{Mesh, MeshError, PolygonMesh, QuadMesh, TriMesh};
pub use progress::{Cancelled, Progress};
pub use refine::{Refined, VertexOrigin};
pub use soup::FaceSoup;
pub use surface_point::SurfacePoint;
pub use topology::Summary;
