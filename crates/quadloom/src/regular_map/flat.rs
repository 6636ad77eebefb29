//! Flat pictures of maps as files.
//!
//! In: a map, a [`FlatRequest`]. Out: an SVG or PNG that is staged. Source: [Razafindrazaka2015] §9.3, Fig. 9.7, 9.8.

use super::{ColorBy, NamedMap};
use crate::error::RemeshError;
use quadloom_io::Batch;
use quadloom_regular_maps::colouring::Colouring;
use quadloom_regular_maps::tiling::{Centre, FlatTiling, Model, Picture, PictureOptions};
use std::path::Path;

/// What a flat picture shows.
#[derive(Clone, Debug, PartialEq)]
pub struct FlatRequest {
    /// How the plane is shown. Default: the Poincaré disc.
    pub model: Model,
    /// What lies in the middle. Default: a face.
    pub centre: Centre,
    /// What has one colour. Default: each face.
    pub colors: ColorBy,
    /// Width and height, pixels, from 16 to 16384. Default 1000.
    pub size: u32,
    /// Draw the sides of all flags' triangles. Default false.
    pub triangles: bool,
    /// Write the faces' numbers. Default false.
    pub numbers: bool,
}

impl Default for FlatRequest {
    fn default() -> Self {
        Self {
            model: Model::default(),
            centre: Centre::default(),
            colors: ColorBy::default(),
            size: 1000,
            triangles: false,
            numbers: false,
        }
    }
}

/// Adds the flat picture of a map: as PNG where the path says so, else as SVG.
///
/// # Errors     [`RemeshError::Argument`] for colours that only a surface in space has; every error of writing
/// # Cost       n log n in flags
pub fn stage_flat(files: &mut Batch, path: &Path, source: &NamedMap, request: &FlatRequest) -> Result<(), RemeshError> {
    let options = PictureOptions {
        size: request.size,
        model: request.model,
        colouring: Some(flat_colouring(&request.colors)?),
        triangles: request.triangles,
        face_numbers: request.numbers,
        ..PictureOptions::default()
    };
    let tiling = FlatTiling::layout(&source.map, request.centre)?;
    let picture = Picture { title: source.name.clone(), ..Picture::new(&tiling, &options) };
    let png = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"));
    let bytes = if png { picture.to_png() } else { picture.to_svg().into_bytes() };
    Ok(files.stage(path, |out| out.write_all(&bytes))?)
}

fn flat_colouring(colors: &ColorBy) -> Result<Colouring, RemeshError> {
    match colors {
        ColorBy::Flags(colouring) => Ok(colouring.clone()),
        ColorBy::Tubes(_) | ColorBy::Symmetry => Err(RemeshError::Argument {
            option: "colors",
            why: "a flat picture has no tubes and no rotations of space: colour it by face, vertex, edge, petrie, triangle, \
                  orbit:WORDS or block:WORDS"
                .into(),
        }),
    }
}
