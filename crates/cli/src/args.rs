//! What can be typed.

use crate::map_args::RegularMapArgs;
use clap::{ArgGroup, Args, Parser, Subcommand, ValueEnum};
use quadloom::distance::{From, Lines};
use quadloom::tile::Cost;
use std::path::PathBuf;

/// Turns any surface into quadrilaterals.
#[derive(Parser)]
#[command(
    name = "quadloom",
    version,
    about = "Turns any surface into quadrilaterals by mixed-integer quadrangulation",
    after_help = "An input is a file (OBJ, PLY, STL, OFF) or sample:NAME, a generated shape.\n\n\
        Exit codes: 0 done; 2 wrong usage; 3 a file cannot be read or written, or is empty; 4 the input is rejected;\n\
        5 no valid result; 6 a valid result that misses a request (it is kept); 7 time limit; 130 cancelled."
)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub verb: Verb,
}

/// One verb per task.
#[derive(Subcommand)]
pub enum Verb {
    /// Make a pure-quad mesh of a surface
    #[command(after_help = "Example: quadloom remesh sample:bracket --quads 3000 -o bracket.obj --view bracket.html")]
    Remesh(Box<RemeshArgs>),
    /// Compute a cross field of a surface
    #[command(after_help = "Example: quadloom field sample:torus -o torus.rosy --write-singularities torus.sing")]
    Field(FieldArgs),
    /// Measure exact geodesic distances on a surface from vertices, points and curves
    #[command(after_help = "Example: quadloom distance sample:bracket --from features -o bracket.csv --isolines 20")]
    Distance(Box<DistanceArgs>),
    /// Cut a surface into a disk, a polygonal schema, quadrangles, pants or cylinders
    #[command(after_help = "Example: quadloom tile sample:genus2 --into quads -o tiles.obj --view tiles.html")]
    Tile(Box<TileArgs>),
    /// List regular maps, draw them flat, and build them as surfaces in space
    #[command(after_help = "Example: quadloom regular-map realize R3.1 -o klein.glb --view klein.html\n\n\
        `quadloom regular-map VERB --help` says more about each of them.")]
    RegularMap(RegularMapArgs),
    /// Say whether a file is a surface, or a valid quad mesh, and what cures its defects
    #[command(after_help = "Example: quadloom check bracket.obj --reference sample:bracket")]
    Check(CheckArgs),
    /// Print counts, topology and quality of a mesh
    #[command(after_help = "Example: quadloom stats bracket.obj --reference sample:bracket --json")]
    Stats(StatsArgs),
    /// Write a mesh in another format, as it is
    #[command(after_help = "Example: quadloom convert bracket.obj bracket.vtu")]
    Convert(ConvertArgs),
    /// Draw a mesh in one self-contained HTML page
    #[command(after_help = "Example: quadloom view bracket.obj -o bracket.html --reference sample:bracket")]
    View(ViewArgs),
    /// List the generated shapes
    #[command(after_help = "Example: quadloom samples")]
    Samples,
}

/// Arguments of `remesh`.
#[derive(Args)]
#[command(allow_negative_numbers = true, group(ArgGroup::new("size").args(["quads", "edge_length", "scale"])))]
pub struct RemeshArgs {
    /// The surface: a file or sample:NAME
    pub input: String,
    /// Where the quads go: .obj, .ply, .off, .vtu, or .glb or .stl, which have triangles only
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,

    /// Number of quads [default: a quarter of the triangles, 500 to 50000]
    #[arg(long, value_name = "N", value_parser = parse_quads, help_heading = "Size")]
    pub quads: Option<usize>,
    /// Mean edge length, in units of the file; above 0
    #[arg(long, value_name = "L", value_parser = parse_above_zero, help_heading = "Size")]
    pub edge_length: Option<f64>,
    /// Mean edge length, in mean edge lengths of the input; above 0
    #[arg(long, value_name = "S", value_parser = parse_above_zero, help_heading = "Size")]
    pub scale: Option<f64>,
    /// How far the count may be off, percent; above 0
    #[arg(long, value_name = "PERCENT", value_parser = parse_above_zero, default_value_t = 10.0, help_heading = "Size")]
    pub tolerance: f64,
    /// How strongly sizes vary over the surface, 0 to 1
    #[arg(long, value_name = "A", value_parser = parse_part, default_value_t = 0.0, help_heading = "Size")]
    pub adaptivity: f64,
    /// What they follow; needs --adaptivity
    #[arg(long, value_enum, default_value_t = AdaptToArg::Curvature, requires = "adaptivity", help_heading = "Size")]
    pub adapt_to: AdaptToArg,
    /// How strongly quads stretch where the surface is straight, 0 to 1
    #[arg(long, value_name = "A", value_parser = parse_part, default_value_t = 0.0, help_heading = "Size")]
    pub anisotropy: f64,
    /// How far sizes may follow the cross field so that quads stay square, 0 to 1
    #[arg(long, value_name = "A", value_parser = parse_part, default_value_t = 0.6, help_heading = "Size")]
    pub curl_correction: f64,
    /// Vertex attribute of the input that multiplies the density of quads
    #[arg(long, value_name = "NAME", help_heading = "Size")]
    pub density: Option<String>,

    /// Edges that bend by more are kept, degrees above 0 and up to 180, or off
    #[arg(long, value_name = "DEG", default_value = "35", value_parser = parse_sharp_angle, help_heading = "Features")]
    pub sharp_angle: SharpAngle,
    /// Edges to keep besides: .sharp, .obj with l lines, or two vertex numbers from 0 a line
    #[arg(long, value_name = "FILE", help_heading = "Features")]
    pub features: Option<PathBuf>,
    /// Whether boundary curves are kept
    #[arg(long, value_name = "BOOL", default_value_t = true, action = clap::ArgAction::Set, num_args = 0..=1,
          default_missing_value = "true", help_heading = "Features")]
    pub keep_boundary: bool,
    /// Curves to follow, in units of the file: .obj with l lines, or JSON, a list of curves, each a list of two or more
    /// points: [[[0,0,1],[1,0,1]], [[0,1,0],[0,2,0],[0,2,1]]]
    #[arg(long, value_name = "FILE", help_heading = "Features")]
    pub guides: Option<PathBuf>,

    /// A cross field to follow: .rosy or .rawfield, on the faces of the input
    #[arg(long, value_name = "FILE", help_heading = "Directions")]
    pub field: Option<PathBuf>,
    /// All singular vertices: lines of vertex number from 0 and whole quarters (valence 3 is 1), or .sing; a file that
    /// lists none asks for none, as on a torus
    #[arg(long, value_name = "FILE", conflicts_with = "field", help_heading = "Directions")]
    pub singularities: Option<PathBuf>,
    /// The list of singularities is not all of them: other vertices may be singular besides
    #[arg(long, requires = "singularities", help_heading = "Directions")]
    pub other_singularities: bool,
    /// Join the irregular vertices nearest to two vertices of the input by a chain of quad edges; may be repeated
    #[arg(long, value_name = "A,B", value_parser = parse_tie, help_heading = "Directions")]
    pub tie: Vec<[u32; 2]>,
    /// The same for every pair of a file: two vertex numbers from 0 a line, # starts a comment
    #[arg(long, value_name = "FILE", help_heading = "Directions")]
    pub ties: Option<PathBuf>,
    /// Move singular vertices where that lowers the distortion of the map: slower by a factor of ten and more
    #[arg(long, help_heading = "Directions")]
    pub relocate: bool,
    /// How integers are found
    #[arg(long, value_enum, default_value_t = MethodArg::Greedy, help_heading = "Directions")]
    pub method: MethodArg,
    /// What is done where no map without folds is found
    #[arg(long, value_enum, default_value_t = FallbackArg::Split, help_heading = "Directions")]
    pub fallback: FallbackArg,

    /// Write the cross field that was used: .rosy or .rawfield; the surface it lives on goes beside it, with .obj added
    /// to the name (f.rosy.obj)
    #[arg(long, value_name = "FILE", help_heading = "Also write")]
    pub write_field: Option<PathBuf>,
    /// Write the integer-grid map as .obj with texture coordinates
    #[arg(long, value_name = "FILE.obj", help_heading = "Also write")]
    pub write_map: Option<PathBuf>,
    /// Write everything measured as JSON
    #[arg(long, value_name = "FILE.json", help_heading = "Also write")]
    pub report: Option<PathBuf>,
    /// Draw input, quads, field and map in one self-contained page
    #[arg(long, value_name = "FILE.html", help_heading = "Also write")]
    pub view: Option<PathBuf>,

    /// How the run behaves.
    #[command(flatten)]
    pub run: RunArgs,
}

/// Arguments of every verb that computes.
#[derive(Args)]
pub struct RunArgs {
    /// End after this many seconds, above 0
    #[arg(long, value_name = "SECONDS", value_parser = parse_seconds, help_heading = "Run")]
    pub time_limit: Option<f64>,
    /// Threads to use, at most four for each core [default: one for each]; the result does not depend on it
    #[arg(long, value_name = "N", value_parser = parse_threads, help_heading = "Run")]
    pub threads: Option<usize>,
    /// Seed of everything that samples: a whole number from 0
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = parse_seed, help_heading = "Run")]
    pub seed: u64,
    /// Print errors only
    #[arg(short, long, help_heading = "Run")]
    pub quiet: bool,
    /// How progress is shown, on stderr [default: bar on a terminal, else none]
    #[arg(long, value_enum, help_heading = "Run")]
    pub progress: Option<ProgressArg>,
}

/// Arguments of `field`.
#[derive(Args)]
#[command(allow_negative_numbers = true)]
pub struct FieldArgs {
    /// The surface: a file or sample:NAME
    pub input: String,
    /// Where the field goes: .rosy or .rawfield
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Write the singular vertices: lines of vertex number and index in quarters
    #[arg(long, value_name = "FILE")]
    pub write_singularities: Option<PathBuf>,
    /// Edges that bend by more are followed, degrees above 0 and up to 180, or off
    #[arg(long, value_name = "DEG", default_value = "35", value_parser = parse_sharp_angle)]
    pub sharp_angle: SharpAngle,
    /// Edges to follow besides: .sharp, .obj with l lines, or two vertex numbers from 0 a line
    #[arg(long, value_name = "FILE")]
    pub features: Option<PathBuf>,
    /// All singular vertices: lines of vertex number from 0 and whole quarters (valence 3 is 1), or .sing; a file that
    /// lists none asks for none, as on a torus
    #[arg(long, value_name = "FILE")]
    pub singularities: Option<PathBuf>,
    /// The list of singularities is not all of them: other vertices may be singular besides
    #[arg(long, requires = "singularities")]
    pub other_singularities: bool,
    /// How the run behaves.
    #[command(flatten)]
    pub run: RunArgs,
}

/// Arguments of `distance`.
#[derive(Args)]
#[command(allow_negative_numbers = true)]
pub struct DistanceArgs {
    /// The surface: a file or sample:NAME
    pub input: String,
    /// What distances are measured from; may be repeated, sources are numbered from 0: vertices:I,J,… (from 0),
    /// point:X,Y,Z, boundary, features[:DEG] (edges that bend by more, default 35), curve:FILE (.obj with l lines, or
    /// JSON: [[[x,y,z], {"face":0,"weights":[a,b,c]}, …], …])
    #[arg(long, value_name = "SOURCE", required = true)]
    pub from: Vec<From>,
    /// Where distances go: .csv (vertex,distance,source), .ply or .vtu (attributes), .obj (colours)
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Distances with which the sources start, in units of the file, as in 0,0.5; missing ones start at 0
    #[arg(long, value_name = "D,…", value_delimiter = ',', value_parser = parse_from_zero)]
    pub start: Vec<f64>,
    /// Relative error that distances may have, 0 (exact) up to below 1: 0.001 is about twice as fast
    #[arg(long, value_name = "E", default_value_t = 0.0, value_parser = parse_epsilon)]
    pub epsilon: f64,
    /// How far points and curves may be from the surface, relative to its diagonal
    #[arg(long, value_name = "REL", default_value_t = 0.05, value_parser = parse_above_zero)]
    pub snap: f64,
    /// Refine the mesh until distances are linear along its edges up to this, in units of the file; .ply, .vtu and .obj
    /// then hold the refined mesh: the vertices of the input, then new ones. The rows of .csv stay those of the input
    #[arg(long, value_name = "TOL", value_parser = parse_above_zero)]
    pub refine: Option<f64>,

    /// Draw lines of equal distance: a whole number of them, or a spacing with a decimal point
    #[arg(long, value_name = "N|SPACING", help_heading = "Also write")]
    pub isolines: Option<Lines>,
    /// Where they go: .obj (l lines) or .svg [default: the output's name with .isolines.obj]
    #[arg(long, value_name = "FILE", requires = "isolines", help_heading = "Also write")]
    pub isolines_to: Option<PathBuf>,
    /// Trace shortest paths from here to their sources: vertices:I,J,… or point:X,Y,Z; may be repeated
    #[arg(long, value_name = "POINT", help_heading = "Also write")]
    pub path_from: Vec<From>,
    /// Where they go: .obj (l lines) or .svg [default: the output's name with .paths.obj]
    #[arg(long, value_name = "FILE", requires = "path_from", help_heading = "Also write")]
    pub paths_to: Option<PathBuf>,
    /// Write everything measured as JSON
    #[arg(long, value_name = "FILE.json", help_heading = "Also write")]
    pub report: Option<PathBuf>,
    /// Draw bands of distance, lines, sources, paths and the cut locus in one self-contained page
    #[arg(long, value_name = "FILE.html", help_heading = "Also write")]
    pub view: Option<PathBuf>,

    /// How the run behaves.
    #[command(flatten)]
    pub run: RunArgs,
}

/// Arguments of `tile`.
#[derive(Args)]
#[command(allow_negative_numbers = true)]
pub struct TileArgs {
    /// The surface: a file or sample:NAME
    pub input: String,
    /// Into what: one disk; the polygon with the fewest sides; quadrangles, 2g-1 of a closed surface of genus g; pairs of
    /// pants; three cylinders of each
    #[arg(long, value_enum, default_value_t = IntoArg::Disk)]
    pub into: IntoArg,
    /// Where the tiles go: .obj, a group for each tile, cuts as l lines
    #[arg(short, long, value_name = "FILE.obj")]
    pub output: PathBuf,
    /// How one tile is made: shortest loops, then shortest connections; all loops through one point (closed surfaces);
    /// or connections between as few points as possible [default: single-point for the schema and quadrangles of a
    /// closed surface, intermediate if it has a boundary, else shortest]
    #[arg(long, value_enum)]
    pub method: Option<CuttingArg>,
    /// How far shortest loops and diagonals are looked for: from all base points and corners, or from one
    #[arg(long, value_enum, default_value_t = SearchArg::Fast)]
    pub search: SearchArg,
    /// What a cut costs: euclidean (its length), curvature:C (less where the surface bends, C from 0 to 1) or
    /// attribute:NAME (its length times a vertex attribute of a .ply)
    #[arg(long, default_value_t = Cost::Euclidean)]
    pub cost: Cost,
    /// How the diagonals of quadrangles are chosen: the shortest again and again, or all together
    #[arg(long, value_enum, default_value_t = DiagonalsArg::Optimal)]
    pub diagonals: DiagonalsArg,
    /// Base point of single-point cuttings and of the fast search: a vertex of the input, from 0
    #[arg(long, value_name = "VERTEX")]
    pub base: Option<u32>,
    /// No cut runs through vertices where this vertex attribute of a .ply is not 0
    #[arg(long, value_name = "NAME")]
    pub forbid: Option<String>,
    /// Cut along these edges instead: .sharp, .obj (l lines) or a text of vertex pairs; what they leave must be disks
    #[arg(long, value_name = "FILE", conflicts_with_all = ["method", "base"])]
    pub cut: Option<PathBuf>,

    /// Map every tile, which must be a disk, to the plane: vt lines in the .obj. Quadrangles go to the unit square
    #[arg(long, value_enum)]
    pub parametrize: Option<ParametrizeArg>,

    /// Write nodes, arcs, tiles and words as JSON
    #[arg(long, value_name = "FILE.json", help_heading = "Also write")]
    pub layout: Option<PathBuf>,
    /// Write the tilings before the first cut and after each one to this folder, as step_000.obj, step_000.json, …
    #[arg(long, value_name = "FOLDER", help_heading = "Also write")]
    pub steps: Option<PathBuf>,
    /// Write everything measured as JSON
    #[arg(long, value_name = "FILE.json", help_heading = "Also write")]
    pub report: Option<PathBuf>,
    /// Draw tiles, cuts, multipoints and the unfolded polygons in one self-contained page
    #[arg(long, value_name = "FILE.html", help_heading = "Also write")]
    pub view: Option<PathBuf>,

    /// How the run behaves.
    #[command(flatten)]
    pub run: RunArgs,
}

/// `--into`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum IntoArg {
    /// One disk
    Disk,
    /// The polygon with the fewest sides
    Schema,
    /// Quadrangles
    Quads,
    /// Pairs of pants
    Pants,
    /// Cylinders
    Cylinders,
}

/// `--method`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum CuttingArg {
    /// Shortest loops, then shortest connections
    Shortest,
    /// All loops through one point
    SinglePoint,
    /// Shortest loops, then connections between few points
    Intermediate,
}

/// `--search`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SearchArg {
    /// From all base points and corners
    Exact,
    /// From one base point, and from all corners at once
    Fast,
}

/// `--parametrize`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ParametrizeArg {
    /// Mean value coordinates in a square or regular polygon: never folded
    Fixed,
    /// Discrete conformal in a square or regular polygon
    Conformal,
    /// Angle-based flattening, free border
    Abf,
    /// Circle packing, free border
    Circles,
}

/// `--diagonals`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DiagonalsArg {
    /// The shortest again and again
    Greedy,
    /// The smallest total
    Optimal,
}

/// Arguments of `check`.
#[derive(Args)]
pub struct CheckArgs {
    /// The mesh: a file or sample:NAME
    pub input: String,
    /// The surface whose topology a quad mesh must have
    #[arg(long, value_name = "IN")]
    pub reference: Option<String>,
    /// Edges of the reference that bend by more are sharp, as in remesh: degrees above 0 and up to 180, or off
    #[arg(long, value_name = "DEG", default_value = "35", value_parser = parse_sharp_angle, requires = "reference")]
    pub sharp_angle: SharpAngle,
    /// The layout of a tiling of this mesh, as `tile --layout` or `--steps` writes it: whether it is one
    #[arg(long, value_name = "FILE.json", conflicts_with = "reference")]
    pub layout: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `stats`.
#[derive(Args)]
pub struct StatsArgs {
    /// The mesh: a file or sample:NAME
    pub input: String,
    /// The surface that distances are measured to
    #[arg(long, value_name = "IN")]
    pub reference: Option<String>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `convert`.
#[derive(Args)]
pub struct ConvertArgs {
    /// The mesh: a file or sample:NAME
    pub input: String,
    /// Where it goes: .obj, .ply, .off, .vtu, or .glb or .stl, which have triangles only
    pub output: PathBuf,
}

/// Arguments of `view`.
#[derive(Args)]
pub struct ViewArgs {
    /// The mesh: a file or sample:NAME
    pub input: String,
    /// Where the page goes
    #[arg(short, long, value_name = "FILE.html")]
    pub output: PathBuf,
    /// The surface that is shown with it
    #[arg(long, value_name = "IN")]
    pub reference: Option<String>,
}

/// A sharp angle in degrees, or none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SharpAngle(pub Option<f64>);

fn parse_sharp_angle(text: &str) -> Result<SharpAngle, String> {
    if text == "off" {
        return Ok(SharpAngle(None));
    }
    let degrees = text.parse().ok().filter(|&a: &f64| a > 0.0 && a <= 180.0);
    degrees.map(|a| SharpAngle(Some(a))).ok_or_else(|| "degrees above 0 and up to 180, or off, are needed".into())
}

fn parse_quads(text: &str) -> Result<usize, String> {
    let quads = text.parse().ok().filter(|&n: &usize| n > 0);
    quads.ok_or_else(|| "a whole number from 1 is needed, as in 3000".into())
}

fn parse_seed(text: &str) -> Result<u64, String> {
    text.parse().map_err(|_| "a whole number from 0 is needed".into())
}

pub(crate) fn parse_above_zero(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|&x: &f64| x > 0.0 && x.is_finite());
    number.ok_or_else(|| "a finite number above 0 is needed, with a decimal point".into())
}

fn parse_from_zero(text: &str) -> Result<f64, String> {
    let number = text.trim().parse().ok().filter(|&x: &f64| x >= 0.0 && x.is_finite());
    number.ok_or_else(|| "finite numbers from 0 are needed, as in 0,0.5".into())
}

fn parse_epsilon(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|x: &f64| (0.0..1.0).contains(x));
    number.ok_or_else(|| "a number from 0 to below 1 is needed, as in 0.001 for 0.1 percent".into())
}

pub(crate) fn parse_part(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|x: &f64| (0.0..=1.0).contains(x));
    number.ok_or_else(|| "a number from 0 to 1 is needed".into())
}

fn parse_seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok().filter(|&s: &f64| s > 0.0 && s.is_finite());
    seconds.ok_or_else(|| "a number of seconds above 0 is needed; without --time-limit there is no limit".into())
}

fn parse_threads(text: &str) -> Result<usize, String> {
    let threads = text.parse().ok().filter(|&n: &usize| n > 0);
    threads.ok_or_else(|| "a number from 1 is needed; without --threads all are used".into())
}

fn parse_tie(text: &str) -> Result<[u32; 2], String> {
    let ends: Option<Vec<u32>> = text.split(',').map(|word| word.trim().parse().ok()).collect();
    match ends.as_deref() {
        Some(&[a, b]) if a != b => Ok([a, b]),
        Some(&[a, _]) => Err(format!("vertex {a} cannot be tied to itself; name two different vertices")),
        _ => Err("two vertex numbers from 0 are needed, as in 17,204".into()),
    }
}

/// How progress is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ProgressArg {
    /// A bar
    Bar,
    /// One JSON object per line
    Json,
    /// Nothing
    None,
}

/// What sizes follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum AdaptToArg {
    /// Small quads where the surface bends
    Curvature,
    /// Small quads where the surface is thin or near to other parts of itself
    FeatureSize,
}

/// How integers are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum MethodArg {
    /// Round all at once
    Direct,
    /// Round the most certain first
    Greedy,
}

/// What is done where no map without folds is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FallbackArg {
    /// Split triangles into quads, with a warning and exit code 6
    Split,
    /// End without a result
    Off,
}
