//! What is written reads back bit for bit, by our readers and by independent ones.

mod common;

use common::{bits, finite, point_bits, single, surface, uv_bits};
use ply_rs_bw::parser::Parser;
use ply_rs_bw::ply::{DefaultElement, Property};
use proptest::prelude::*;
use quadloom_io::{
    Encoding, Format, Guide, IoError, RawField, SharpSide, Singularity, SurfaceOut, WriteOptions, WriteWarning,
};
use quadloom_io::{
    read_guides, read_rawfield, read_rosy, read_sharp, read_singularities, read_soup, read_vertex_pairs,
};
use quadloom_io::{write_guides, write_rawfield, write_rosy, write_sharp, write_singularities, write_surface};
use quadloom_mesh::{DVec3, FaceSoup};
use std::fs;
use std::path::PathBuf;

const ENCODINGS: [Encoding; 2] = [Encoding::Binary, Encoding::Ascii];

/// Writes to a file with a name that is not ASCII.
fn written(surface: &SurfaceOut, extension: &str, encoding: Encoding) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(format!("Fläche 面.{extension}"));
    write_surface(&path, surface, &WriteOptions { encoding, ..WriteOptions::default() }).unwrap();
    (folder, path)
}

fn back(surface: &SurfaceOut, extension: &str, encoding: Encoding) -> FaceSoup {
    let (_folder, path) = written(surface, extension, encoding);
    read_soup(path).unwrap()
}

fn attribute_bits(attributes: &[(String, Vec<f64>)]) -> Vec<(String, Vec<u64>)> {
    attributes.iter().map(|(name, values)| (name.clone(), bits(values))).collect()
}

proptest! {
    #![proptest_config(common::config(64))]

    #[test]
    fn obj(surface in surface(finite())) {
        let soup = back(&surface, "obj", Encoding::Binary);
        prop_assert_eq!(point_bits(&soup.positions), point_bits(&surface.positions));
        prop_assert_eq!(&soup.faces, &surface.faces);
        prop_assert_eq!(&soup.polylines, &surface.polylines);
        prop_assert_eq!(&soup.vertex_colors, &surface.vertex_colors);
        prop_assert_eq!(uv_bits(&soup.corner_uv), uv_bits(&surface.corner_uv));
    }

    #[test]
    fn ply(surface in surface(finite()), encoding in prop::sample::select(&ENCODINGS)) {
        let soup = back(&surface, "ply", encoding);
        prop_assert_eq!(point_bits(&soup.positions), point_bits(&surface.positions));
        prop_assert_eq!(&soup.faces, &surface.faces);
        let edges: Vec<_> = surface.polylines.iter().flat_map(|l| l.windows(2).map(<[u32]>::to_vec)).collect();
        prop_assert_eq!(&soup.polylines, &edges);
        prop_assert_eq!(&soup.vertex_colors, &surface.vertex_colors);
        prop_assert_eq!(uv_bits(&soup.corner_uv), uv_bits(&surface.corner_uv));
        prop_assert_eq!(attribute_bits(&soup.vertex_attributes), attribute_bits(&surface.vertex_attributes));
    }

    /// The reader of another crate sees the same positions, faces and attributes of faces.
    #[test]
    fn ply_by_another_reader(mut surface in surface(finite()), encoding in prop::sample::select(&ENCODINGS)) {
        // That reader's grammar for names is narrower, and it does not spell out what it does with NaN.
        for (k, (name, values)) in surface.vertex_attributes.iter_mut().chain(&mut surface.face_attributes).enumerate() {
            *name = format!("q{k}");
            values.iter_mut().filter(|x| !x.is_finite()).for_each(|x| *x = 0.5);
        }
        let (_folder, path) = written(&surface, "ply", encoding);
        let file = Parser::<DefaultElement>::new().read_ply(&mut fs::File::open(path).unwrap()).unwrap();
        let double = |e: &DefaultElement, name: &str| match e.get(name) {
            Some(Property::Double(x)) => *x,
            other => panic!("{name}: {other:?}"),
        };
        let vertices = &file.payload["vertex"];
        let positions: Vec<_> = vertices.iter().map(|v| DVec3::from(["x", "y", "z"].map(|n| double(v, n)))).collect();
        prop_assert_eq!(point_bits(&positions), point_bits(&surface.positions));
        let faces = &file.payload["face"];
        for (k, face) in faces.iter().enumerate() {
            let Some(Property::ListInt(corners)) = face.get("vertex_indices") else { panic!("{face:?}") };
            prop_assert_eq!(&corners.iter().map(|&v| v as u32).collect::<Vec<_>>(), &surface.faces[k]);
            for (name, values) in &surface.face_attributes {
                prop_assert_eq!(double(face, name).to_bits(), values[k].to_bits());
            }
        }
        prop_assert_eq!(faces.len(), surface.faces.len());
    }

    #[test]
    fn off(surface in surface(finite())) {
        let soup = back(&surface, "off", Encoding::Binary);
        prop_assert_eq!(point_bits(&soup.positions), point_bits(&surface.positions));
        prop_assert_eq!(&soup.faces, &surface.faces);
        prop_assert_eq!(&soup.vertex_colors, &surface.vertex_colors);
    }

    #[test]
    fn vtu(surface in surface(finite()), encoding in prop::sample::select(&ENCODINGS)) {
        let (_folder, path) = written(&surface, "vtu", encoding);
        let file = fs::read_to_string(path).unwrap();
        let arrays = vtu_arrays(&file);
        let find = |name: &str| &arrays.iter().find(|(n, _)| n == name).unwrap().1;
        let positions: Vec<f64> = surface.positions.iter().flat_map(|p| p.to_array()).collect();
        prop_assert_eq!(bits(find("Points")), bits(&positions));
        let mut begin = 0;
        for (k, face) in surface.faces.iter().enumerate() {
            let end = find("offsets")[k] as usize;
            let corners: Vec<u32> = find("connectivity")[begin..end].iter().map(|&v| v as u32).collect();
            prop_assert_eq!(&corners, face);
            prop_assert_eq!(find("types")[k], match face.len() { 3 => 5.0, 4 => 9.0, _ => 7.0 });
            begin = end;
        }
        let attributes = surface.vertex_attributes.iter().chain(&surface.face_attributes).map(|(_, v)| bits(v));
        let read = arrays.iter().take_while(|(name, _)| name != "Points").map(|(_, v)| bits(v));
        prop_assert_eq!(read.collect::<Vec<_>>(), attributes.collect::<Vec<_>>());
    }

    #[test]
    fn stl(surface in surface(single()), encoding in prop::sample::select(&ENCODINGS)) {
        let (_folder, path) = written(&surface, "stl", encoding);
        // Welding numbers vertices anew; corners are compared by place, in which 0 is -0.
        let soup = read_soup(&path).unwrap();
        let corners = |positions: &[DVec3], face: &[u32]| face.iter().map(|&v| positions[v as usize]).collect::<Vec<_>>();
        let ours: Vec<_> = soup.faces.iter().map(|f| corners(&soup.positions, f)).collect();
        prop_assert_eq!(ours.len(), surface.faces.iter().map(|f| f.len() - 2).sum::<usize>());
        // Another crate's reader sees the same facets.
        let theirs = stl_io::read_stl(&mut fs::File::open(&path).unwrap()).unwrap();
        for (a, b) in ours.iter().zip(&theirs.faces) {
            let b: Vec<_> = b.vertices.iter().map(|&v| DVec3::from(theirs.vertices[v].0.map(f64::from))).collect();
            prop_assert_eq!(a, &b);
        }
        // The facets of a triangle are the triangle.
        let mut k = 0;
        for face in &surface.faces {
            if face.len() == 3 {
                let wanted = corners(&surface.positions, face);
                prop_assert!((0..3).any(|s| (0..3).all(|c| ours[k][c] == wanted[(c + s) % 3])));
            }
            k += face.len() - 2;
        }
    }

    #[test]
    fn rosy_and_rawfield(field in proptest::collection::vec([finite(), finite(), finite()].prop_map(DVec3::from), 0..9)) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.rosy");
        write_rosy(&path, &field).unwrap();
        prop_assert_eq!(point_bits(&read_rosy(&path).unwrap()), point_bits(&field));
        let crosses: Vec<[DVec3; 4]> = field.iter().map(|&d| [d, -d, d, -d]).collect();
        write_rawfield(&path, &crosses).unwrap();
        let RawField { degree, vectors } = read_rawfield(&path).unwrap();
        prop_assert_eq!(degree, 4);
        prop_assert_eq!(point_bits(&vectors), point_bits(crosses.as_flattened()));
    }

    #[test]
    fn features_and_singularities(entries in proptest::collection::vec((any::<u32>(), 0u8..3, any::<bool>(), -999i32..999), 1..9)) {
        let folder = tempfile::tempdir().unwrap();
        let sides: Vec<_> = entries.iter().map(|&(face, side, convex, _)| SharpSide { face, side, convex }).collect();
        let path = folder.path().join("a.sharp");
        write_sharp(&path, &sides).unwrap();
        prop_assert_eq!(read_sharp(&path).unwrap(), sides);
        let pairs: Vec<_> = entries.iter().map(|&(v, side, _, _)| [v, u32::from(side)]).collect();
        quadloom_io::write_vertex_pairs(&path, &pairs).unwrap();
        prop_assert_eq!(read_vertex_pairs(&path).unwrap(), pairs);
        let list: Vec<_> = entries.iter().map(|&(vertex, _, _, quarters)| Singularity { vertex, quarters }).collect();
        for name in ["a.sing", "a.txt"] {
            let path = folder.path().join(name);
            write_singularities(&path, &list).unwrap();
            prop_assert_eq!(&read_singularities(&path).unwrap(), &list);
        }
    }

    #[test]
    fn guides(curves in proptest::collection::vec(
        proptest::collection::vec([finite(), finite(), finite()].prop_map(DVec3::from), 2..5), 1..4,
    )) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.json");
        let list: Vec<Guide> = curves.into_iter().map(|points| Guide { points }).collect();
        write_guides(&path, &list).unwrap();
        let read = read_guides(&path).unwrap();
        prop_assert_eq!(read.len(), list.len());
        for (a, b) in read.iter().zip(&list) {
            prop_assert_eq!(point_bits(&a.points), point_bits(&b.points));
        }
    }

    #[test]
    fn glb(mut surface in surface(-1e3..1e3), far in prop::sample::select(&[0.0, 1e7])) {
        surface.positions.iter_mut().for_each(|p| p.x += far);
        let (_folder, path) = written(&surface, "glb", Encoding::Binary);
        let glb = Glb::read(&fs::read(path).unwrap());
        // 1. Coordinates are good to single precision of the model's own size, wherever it is.
        let tolerance = 2e3 * 32.0 * f64::from(f32::EPSILON);
        for (p, q) in surface.positions.iter().zip(glb.positions()) {
            prop_assert!(p.distance(q) <= tolerance, "{} {}", p, q);
        }
        // 2. Triangles that share their first vertex join to the polygons.
        let mut polygons: Vec<Vec<u32>> = Vec::new();
        for t in glb.indices(0).as_chunks::<3>().0 {
            match polygons.last_mut() {
                Some(p) if p[0] == t[0] => p.push(t[2]),
                _ => polygons.push(t.to_vec()),
            }
        }
        prop_assert_eq!(polygons.len(), surface.faces.len());
        for (a, b) in polygons.iter().zip(&surface.faces) {
            let start = b.iter().position(|v| v == &a[0]).unwrap();
            let turned: Vec<u32> = (0..b.len()).map(|k| b[(start + k) % b.len()]).collect();
            prop_assert_eq!(a, &turned);
        }
        // 3. The extension is declared exactly where it is used.
        let used = surface.faces.iter().any(|f| f.len() > 3);
        prop_assert_eq!(glb.root.extensions_used.contains(&"FB_ngon_encoding".to_string()), used);
        // 4. Polylines are lines.
        let edges: Vec<u32> = surface.polylines.iter().flat_map(|l| l.windows(2).flatten().copied()).collect();
        if !edges.is_empty() {
            prop_assert_eq!(glb.indices(1), edges);
        }
    }
}

/// Names and values of the data arrays of a VTU file, in its order.
fn vtu_arrays(file: &str) -> Vec<(String, Vec<f64>)> {
    use base64::Engine;
    let attribute = |tag: &str, name: &str| {
        let from = tag.find(&format!(" {name}=\"")).unwrap() + name.len() + 3;
        tag[from..].split('"').next().unwrap().to_string()
    };
    let array = |part: &str| {
        let (tag, rest) = part.split_once('>').unwrap();
        let text = rest.split("</DataArray>").next().unwrap().trim();
        let values = if attribute(tag, "format") == "ascii" {
            text.split_ascii_whitespace().map(|t| t.parse().unwrap()).collect()
        } else {
            let raw = base64::engine::general_purpose::STANDARD.decode(text).unwrap();
            let (length, data) = raw.split_at(8);
            assert_eq!(u64::from_le_bytes(length.try_into().unwrap()) as usize, data.len());
            match attribute(tag, "type").as_str() {
                "Float64" => data.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect(),
                "Int64" => data.as_chunks().0.iter().map(|b| i64::from_le_bytes(*b) as f64).collect(),
                "UInt8" => data.iter().map(|&b| f64::from(b)).collect(),
                other => panic!("{other}"),
            }
        };
        (attribute(tag, "Name"), values)
    };
    file.split("<DataArray").skip(1).map(array).collect()
}

/// A GLB file through another crate's data types, which refuse what the schema does not allow.
struct Glb {
    root: gltf_json::Root,
    buffer: Vec<u8>,
}

impl Glb {
    fn read(file: &[u8]) -> Self {
        let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap()) as usize;
        assert_eq!((&file[..4], word(4), word(8)), (b"glTF".as_slice(), 2, file.len()));
        let text_end = 20 + word(12);
        assert_eq!((&file[16..20], text_end % 4), (b"JSON".as_slice(), 0));
        assert_eq!(
            (word(text_end), &file[text_end + 4..text_end + 8]),
            (file.len() - text_end - 8, b"BIN\0".as_slice())
        );
        let root = gltf_json::deserialize::from_slice(&file[20..text_end]).unwrap();
        Self { root, buffer: file[text_end + 8..].to_vec() }
    }

    fn words(&self, accessor: usize) -> Vec<[u8; 4]> {
        let accessor = &self.root.accessors[accessor];
        let view = &self.root.buffer_views[accessor.buffer_view.unwrap().value()];
        let from = view.byte_offset.unwrap().0 as usize;
        let words = self.buffer[from..from + view.byte_length.0 as usize].as_chunks().0.to_vec();
        assert_eq!(words.len() as u64 % accessor.count.0, 0);
        words
    }

    fn positions(&self) -> Vec<DVec3> {
        let primitive = &self.root.meshes[0].primitives[0];
        let key = gltf_json::validation::Checked::Valid(gltf_json::mesh::Semantic::Positions);
        let accessor = primitive.attributes[&key].value();
        let values: Vec<f32> = self.words(accessor).into_iter().map(f32::from_le_bytes).collect();
        let points: Vec<[f32; 3]> = values.as_chunks().0.to_vec();
        let bound = |pick: fn(f32, f32) -> f32| [0, 1, 2].map(|k| points.iter().map(|p| p[k]).reduce(pick).unwrap());
        let stated =
            |value: &Option<serde_json::Value>| serde_json::from_value::<[f32; 3]>(value.clone().unwrap()).unwrap();
        assert_eq!(stated(&self.root.accessors[accessor].min), bound(f32::min));
        assert_eq!(stated(&self.root.accessors[accessor].max), bound(f32::max));
        let origin = DVec3::from(self.root.nodes[0].translation.unwrap_or([0.0; 3]).map(f64::from));
        points.iter().map(|p| origin + DVec3::from(p.map(f64::from))).collect()
    }

    fn indices(&self, primitive: usize) -> Vec<u32> {
        let accessor = self.root.meshes[0].primitives[primitive].indices.unwrap().value();
        self.words(accessor).into_iter().map(u32::from_le_bytes).collect()
    }
}

#[test]
fn what_a_format_cannot_hold_is_said() {
    let square = SurfaceOut {
        corner_uv: Some(vec![vec![[0.0; 2]; 4]]),
        face_attributes: vec![("quality".into(), vec![1.0])],
        polylines: vec![vec![0, 1]],
        ..SurfaceOut::new(vec![DVec3::ZERO, DVec3::X, DVec3::X + 0.1, DVec3::Y], vec![vec![0, 1, 2, 3]])
    };
    let folder = tempfile::tempdir().unwrap();
    let warnings = |name: &str| write_surface(folder.path().join(name), &square, &WriteOptions::default()).unwrap();
    assert_eq!(warnings("a.ply"), []);
    assert_eq!(warnings("a.obj"), [WriteWarning::Dropped { format: Format::Obj, what: "face attributes" }]);
    let glb = warnings("a.glb");
    assert_eq!(glb[0], WriteWarning::Triangulated { format: Format::Glb, faces: 1 });
    assert_eq!(glb[1], WriteWarning::SinglePrecision { format: Format::Glb, vertices: 1 });
    assert_eq!(glb.len(), 4, "{glb:?}");
    let text: Vec<_> = warnings("a.off").iter().map(ToString::to_string).collect();
    assert_eq!(text[0], "OFF does not hold texture coordinates: left out");
}

#[test]
fn nothing_that_is_not_a_surface_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let good = SurfaceOut::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y], vec![vec![0, 1, 2]]);
    let broken: [(&str, SurfaceOut); 12] = [
        ("no face", SurfaceOut { faces: vec![], ..good.clone() }),
        ("vertex 1", SurfaceOut { positions: vec![DVec3::ZERO, DVec3::NAN, DVec3::Y], ..good.clone() }),
        ("vertex 3", SurfaceOut { faces: vec![vec![0, 1, 3]], ..good.clone() }),
        ("fewer than 3", SurfaceOut { faces: vec![vec![0, 1]], ..good.clone() }),
        ("polyline 0", SurfaceOut { polylines: vec![vec![0, 7]], ..good.clone() }),
        ("fewer than 2", SurfaceOut { polylines: vec![vec![0]], ..good.clone() }),
        ("taken", SurfaceOut { vertex_attributes: vec![("red".into(), vec![0.0; 3])], ..good.clone() }),
        ("taken", SurfaceOut { face_attributes: vec![("a".into(), vec![0.0]); 2], ..good.clone() }),
        ("texture", SurfaceOut { corner_uv: Some(vec![vec![[0.0; 2]; 2]]), ..good.clone() }),
        ("for 0", SurfaceOut { corner_uv: Some(vec![]), ..good.clone() }),
        ("2 values", SurfaceOut { vertex_attributes: vec![("a".into(), vec![0.0; 2])], ..good.clone() }),
        ("name", SurfaceOut { face_attributes: vec![("a b".into(), vec![0.0])], ..good.clone() }),
    ];
    for extension in ["obj", "ply", "off", "vtu", "glb", "stl"] {
        let path = folder.path().join(format!("a.{extension}"));
        fs::write(&path, "old").unwrap();
        for (part, surface) in &broken {
            let error = write_surface(&path, surface, &WriteOptions::default()).unwrap_err();
            assert!(matches!(error, IoError::InvalidSurface { .. }), "{error:?}");
            assert!(error.to_string().contains(part), "{part}: {error}");
        }
        assert_eq!(fs::read(&path).unwrap(), b"old");
    }
    let error = write_surface(folder.path().join("a.xyz"), &good, &WriteOptions::default()).unwrap_err();
    assert!(matches!(error, IoError::UnknownOutput { .. }));
    let huge = SurfaceOut { positions: vec![DVec3::ZERO, DVec3::X * 1e300, DVec3::Y], ..good };
    for extension in ["glb", "stl"] {
        let error = write_surface(folder.path().join(format!("b.{extension}")), &huge, &WriteOptions::default());
        assert!(error.unwrap_err().to_string().contains("single precision"));
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 6, "only the old files are left");
}

/// Files of another crate's writer.
#[test]
fn stl_of_another_writer() {
    use stl_io::{Normal, Triangle, Vertex};
    let vertex = |x: f32, y: f32| Vertex::new([x, y, 0.1]);
    let facet = |vertices| Triangle { normal: Normal::new([0.0, 0.0, 1.0]), vertices };
    let facets = [
        facet([vertex(0.0, 0.0), vertex(1.0, 0.0), vertex(0.0, 1.0)]),
        facet([vertex(1.0, 0.0), vertex(1.0, 1.0), vertex(0.0, 1.0)]),
    ];
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.STL");
    stl_io::write_stl(&mut fs::File::create(&path).unwrap(), facets.iter()).unwrap();
    let soup = read_soup(path).unwrap();
    assert_eq!(soup.faces, [[0, 1, 2], [1, 3, 2]]);
    assert_eq!(soup.positions[3], DVec3::new(1.0, 1.0, f64::from(0.1f32)));
}
