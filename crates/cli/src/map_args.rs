//! What can be typed after `quadloom regular-map`.

use crate::args::{RunArgs, parse_above_zero, parse_part};
use clap::{Args, Subcommand, ValueEnum};
use quadloom::regular_map::ColorBy;
use quadloom::tubification::skeleton::Symmetry;
use std::ops::RangeInclusive;
use std::path::PathBuf;

/// Arguments of `regular-map`.
#[derive(Args)]
pub struct RegularMapArgs {
    /// What to do.
    #[command(subcommand)]
    pub verb: MapVerb,
}

/// One verb per task.
#[derive(Subcommand)]
pub enum MapVerb {
    /// List maps: reflexible ones of genus 2 and more with p <= q, no duals
    #[command(after_help = "Example: quadloom regular-map list --genus 2..5 --type 3,7")]
    List(ListArgs),
    /// Print what is known about a map
    #[command(after_help = "Example: quadloom regular-map info R3.1")]
    Info(InfoArgs),
    /// Draw a map flat: in the hyperbolic disc, the plane or on the sphere
    #[command(after_help = "Example: quadloom regular-map tile R3.1 -o disc.svg")]
    Tile(FlatArgs),
    /// Find the tube surfaces that a map can be drawn on
    #[command(after_help = "Example: quadloom regular-map match R5.8")]
    Match(MatchArgs),
    /// Build a tube surface in space and draw the map on it
    #[command(after_help = "Example: quadloom regular-map realize R3.1 -o klein.glb --view klein.html")]
    Realize(Box<RealizeArgs>),
    /// Build the tube surface of a map's own edge graph
    #[command(after_help = "Example: quadloom regular-map tubify R2.4 -o tubes.obj")]
    Tubify(Box<TubifyArgs>),
    /// Search maps anew, beyond the list that comes with the program
    #[command(after_help = "Example: quadloom regular-map search --genus 2..6")]
    Search(SearchArgs),
}

/// Which map is meant.
#[derive(Args)]
#[group(id = "source", required = true, multiple = false)]
pub struct MapArgs {
    /// A map: R3.1 as in Conder's list, {3,7}_8#3.1 or a part of it, cube; ' after it means the dual
    #[arg(value_name = "MAP", group = "source")]
    pub map: Option<String>,
    /// A map by its group, as in "R^3, S^7, (R*S^-2)^4"
    #[arg(long, value_name = "RELATORS", group = "source")]
    pub presentation: Option<String>,
}

/// Arguments of `list`.
#[derive(Args)]
pub struct ListArgs {
    /// Genus, or a range with both ends, as in 2..5
    #[arg(long, value_name = "G|G..G", value_parser = parse_range)]
    pub genus: Option<RangeInclusive<usize>>,
    /// Corners of a face and faces at a vertex, as in 3,7
    #[arg(long = "type", value_name = "P,Q", value_parser = parse_type)]
    pub kind: Option<(usize, usize)>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `info`.
#[derive(Args)]
pub struct InfoArgs {
    /// The map.
    #[command(flatten)]
    pub source: MapArgs,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `match`.
#[derive(Args)]
pub struct MatchArgs {
    /// The map.
    #[command(flatten)]
    pub source: MapArgs,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// `--model`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ModelArg {
    /// Angles are true; lines are arcs of circles
    Poincare,
    /// Lines are straight
    Klein,
    /// A half sphere, seen from the side
    Jemisphere,
}

/// `--centre`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum CentreArg {
    /// A face
    Face,
    /// A vertex
    Vertex,
    /// An edge
    Edge,
}

/// Arguments of `tile`.
#[derive(Args)]
pub struct FlatArgs {
    /// The map.
    #[command(flatten)]
    pub source: MapArgs,
    /// Where the picture goes: .svg or .png
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// How the hyperbolic plane is shown
    #[arg(long, value_enum, default_value_t = ModelArg::Poincare)]
    pub model: ModelArg,
    /// What is in the middle
    #[arg(long, value_enum, default_value_t = CentreArg::Face)]
    pub centre: CentreArg,
    /// Colours by face, vertex, edge, petrie (polygon), triangle (black and white), orbit:WORDS of faces under a subgroup,
    /// or block:WORDS, its cosets
    #[arg(long, value_name = "BY", default_value = "face")]
    pub colors: ColorBy,
    /// Width and height in pixels
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(16..=16384))]
    pub size: u32,
    /// Draw the flags' triangles, too
    #[arg(long)]
    pub triangles: bool,
    /// Write the numbers of faces
    #[arg(long)]
    pub numbers: bool,
}

/// `--edges`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum EdgesArg {
    /// Not drawn: faces meet
    None,
    /// Flat bands of another colour
    Bands,
    /// Round ridges
    Tubes,
    /// Bands that stand out with steep sides
    Relief,
}

/// `--skeleton`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SkeletonArg {
    /// Exact on a sphere or torus, else relaxed
    Auto,
    /// The target drawn on a tube surface of its own target
    Drawn,
    /// The edge graph of the target, relaxed
    Relaxed,
}

/// How tubes are made and written.
#[derive(Args)]
pub struct SurfaceArgs {
    /// Where the surface goes: .glb, .stl, .obj, .ply, .off or .vtu
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Largest extent of the surface, millimetres; above 0
    #[arg(long, value_name = "MM", default_value_t = 100.0, value_parser = parse_above_zero)]
    pub size: f64,
    /// Where the tubes' axes come from
    #[arg(long, value_enum, default_value_t = SkeletonArg::Auto)]
    pub skeleton: SkeletonArg,
    /// Rotations that a relaxed skeleton has: auto, none, C3, D2, T, O, I, …
    #[arg(long, value_name = "GROUP", default_value = "auto", value_parser = parse_symmetry)]
    pub symmetry: Symmetry,
    /// Radius of the tubes as a share of the largest that has room; above 0 and at most 1
    #[arg(long, value_name = "T", default_value_t = 1.0, value_parser = parse_thickness)]
    pub thickness: f64,
    /// Write a surface that intersects itself, too
    #[arg(long)]
    pub allow_intersections: bool,
}

/// Arguments of `realize`.
#[derive(Args)]
#[command(allow_negative_numbers = true)]
pub struct RealizeArgs {
    /// The map.
    #[command(flatten)]
    pub source: MapArgs,
    /// The surface.
    #[command(flatten)]
    pub surface: SurfaceArgs,
    /// The target: a map's name, or a type as {8,3}_12 from `match` [default: the one with the best surface]
    #[arg(long, value_name = "TARGET")]
    pub on: Option<String>,
    /// Draw the dual map
    #[arg(long)]
    pub dual: bool,
    /// Colours by face, vertex, edge, petrie (polygon), triangle (black and white), tube, half-tube, quarter-tube,
    /// junction, symmetry (orbits of faces under the rotations in space), orbit:WORDS of faces under a subgroup, or
    /// block:WORDS, its cosets
    #[arg(long, value_name = "BY", default_value = "face")]
    pub colors: ColorBy,
    /// How edges are drawn [default: relief in .stl, else bands]
    #[arg(long, value_enum)]
    pub edges: Option<EdgesArg>,
    /// Width of edges: share of the distance from an edge to its face's centre; above 0, at most 0.9 [default: 0.05 for
    /// bands, else 0.12]
    #[arg(long, value_name = "W", value_parser = parse_width)]
    pub edge_width: Option<f64>,
    /// Pieces that a quarter-tube is at least cut into along and around
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u16).range(3..=64))]
    pub steps: u16,

    /// Write everything measured as JSON
    #[arg(long, value_name = "FILE.json", help_heading = "Also write")]
    pub report: Option<PathBuf>,
    /// Draw surface and flat picture side by side in one self-contained page
    #[arg(long, value_name = "FILE.html", help_heading = "Also write")]
    pub view: Option<PathBuf>,

    /// How the run behaves.
    #[command(flatten)]
    pub run: RunArgs,
}

/// Arguments of `tubify`.
#[derive(Args)]
#[command(allow_negative_numbers = true)]
pub struct TubifyArgs {
    /// The map whose edges become tubes.
    #[command(flatten)]
    pub source: MapArgs,
    /// The surface.
    #[command(flatten)]
    pub surface: SurfaceArgs,

    /// Write everything measured as JSON
    #[arg(long, value_name = "FILE.json", help_heading = "Also write")]
    pub report: Option<PathBuf>,

    /// How the run behaves.
    #[command(flatten)]
    pub run: RunArgs,
}

/// Arguments of `search`.
#[derive(Args)]
pub struct SearchArgs {
    /// Genus, or a range with both ends, as in 2..5; from 2
    #[arg(long, value_name = "G|G..G", value_parser = parse_range)]
    pub genus: RangeInclusive<usize>,
    /// Only faces with P corners and vertices of Q faces, as in 3,7
    #[arg(long = "type", value_name = "P,Q", value_parser = parse_type)]
    pub kind: Option<(usize, usize)>,
    /// Chiral maps instead: those that are not their own mirror image
    #[arg(long)]
    pub chiral: bool,
    /// Print JSON
    #[arg(long)]
    pub json: bool,

    /// How the run behaves.
    #[command(flatten)]
    pub run: RunArgs,
}

fn parse_range(text: &str) -> Result<RangeInclusive<usize>, String> {
    let number = |t: &str| t.trim().parse::<usize>().map_err(|_| format!("{t:?} is no whole number from 0"));
    let (from, to) = match text.split_once("..") {
        Some((from, to)) => (number(from)?, number(to.trim_start_matches('='))?),
        None => (number(text)?, number(text)?),
    };
    if from > to { Err(format!("{from} is larger than {to}")) } else { Ok(from..=to) }
}

fn parse_thickness(text: &str) -> Result<f64, String> {
    parse_part(text).ok().filter(|&t| t > 0.0).ok_or_else(|| "a number above 0 and at most 1 is needed".into())
}

fn parse_width(text: &str) -> Result<f64, String> {
    let width = parse_part(text).ok().filter(|&w| w > 0.0 && w <= WIDEST);
    width.ok_or_else(|| format!("a number above 0 and at most {WIDEST} is needed"))
}

/// Widest edges: beyond it nothing is left of faces.
const WIDEST: f64 = 0.9;

fn parse_symmetry(text: &str) -> Result<Symmetry, String> {
    Ok(match text {
        "auto" => Symmetry::Auto,
        "none" => Symmetry::None,
        name => Symmetry::Named(name.parse().map_err(|why: String| format!("{why}; or auto, or none"))?),
    })
}

fn parse_type(text: &str) -> Result<(usize, usize), String> {
    let inner = text.trim().trim_start_matches('{').trim_end_matches('}');
    let number = |t: &str| match t.trim().parse::<usize>() {
        Ok(n) if n >= 2 => Ok(n),
        _ => Err(format!("{t:?} is no whole number from 2")),
    };
    let (p, q) = inner.split_once(',').ok_or("two numbers are needed, as in 3,7")?;
    Ok((number(p)?, number(q)?))
}
