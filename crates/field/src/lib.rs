//! Curvature and salient directions, cross fields, singularities, sizing.
//!
//! In: a triangle mesh and its features. Out: [`CrossField`], [`SizeField`]. Source: [Bommes2012] §8.1 to 8.3, 8.6.
#![warn(missing_docs)]

mod carry;
pub mod constraints;
pub mod cross_field;
pub mod curvature;
pub mod error;
mod loops;
mod mixed_integer;
pub mod moves;
mod search;
pub mod sizing;
mod smoothest;
pub mod solve;
mod system;
pub mod transport;
pub mod tubes;

pub use constraints::{FieldConstraints, SoftDirection};
pub use cross_field::{CrossField, FieldDefect};
pub use curvature::{Curvature, SalientDirection, SalientOptions, curvature_at, curvatures, salient_directions};
pub use error::FieldError;
pub use moves::FieldMoves;
pub use sizing::{CurvatureSizing, SizeField, curl_potential, local_feature_size};
pub use solve::{FieldOptions, FieldReport, FieldStart, solve_cross_field};
pub use transport::Transport;
pub use tubes::unspiralled;
