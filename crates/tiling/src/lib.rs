//! M-tiles: cutting a surface into tiles, a polygon, pants, cylinders and quadrangles.
#![warn(missing_docs)]

pub mod maps;
pub mod word;
