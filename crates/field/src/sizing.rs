//! Sizes: the wanted quad edge lengths along both directions of every cross.
//!
//! In: a triangle mesh and a wish. Out: [`SizeField`]. Holds: positive finite lengths.
//! Source: [Bommes2012] §8.3.

use quadloom_mesh::FaceMap;
use serde::{Deserialize, Serialize};

/// Wanted quad edge lengths per face, file units: `u` along directions 0 and 2 of the cross, `v` along 1 and 3.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SizeField {
    /// Length along direction 0.
    pub u: FaceMap<f64>,
    /// Length along direction 1.
    pub v: FaceMap<f64>,
}

impl SizeField {
    /// The same length everywhere.
    pub fn uniform(faces: usize, length: f64) -> Self {
        Self { u: FaceMap::filled(faces, length), v: FaceMap::filled(faces, length) }
    }

    /// All lengths multiplied by `factor`.
    pub fn scaled(&self, factor: f64) -> Self {
        Self { u: self.u.map(|h| h * factor), v: self.v.map(|h| h * factor) }
    }
}
