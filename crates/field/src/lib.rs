//! Curvature and salient directions, cross fields, singularities, sizing.
//!
//! In: a triangle mesh and its features. Out: [`CrossField`], sizes. Source: [Bommes2012] §8.1 to 8.3.
#![warn(missing_docs)]

pub mod constraints;
pub mod cross_field;
pub mod error;
pub mod transport;

pub use constraints::{FieldConstraints, SoftDirection};
pub use cross_field::{CrossField, FieldDefect};
pub use error::FieldError;
pub use transport::Transport;
