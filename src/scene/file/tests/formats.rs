//! PLY, STL, glTF, and compressed files, made on the spot.

use super::*;
use crate::scene::families;
use glam::Vec2;
use std::io::Write;

/// Reads `bytes` as a file of that name.
pub(super) fn read(name: &str, bytes: &[u8]) -> Result<Scene, SceneError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    load(&path)
}

fn square() -> [Triangle; 2] {
    let [a, b, c, d] = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
    [Triangle::new(a, b, c), Triangle::new(a, c, d)]
}

pub(super) const PLY_TEXT: &str = "ply\nformat ascii 1.0\ncomment ours\nelement vertex 4\nproperty float x\nproperty double y\n\
    property float z\nproperty uchar red\nelement face 2\nproperty uchar flags\nproperty list uchar int vertex_indices\n\
    element edge 1\nproperty int vertex1\nproperty int vertex2\nend_header\n\
    0 0 0 9\n1 0 0 9\n1 1 0 9\n0 1 0 9\n7 4 0 1 2 3\n7 2 0 1\n0 1\n";

#[test]
fn ply_text_and_binary() {
    let scene = read("a.ply", PLY_TEXT.as_bytes()).unwrap();
    assert_eq!((scene.triangles.as_slice(), scene.dropped.points_and_lines), (square().as_slice(), 1));
    assert_eq!(scene.warnings, ["elements that have no use here: 1 edge"]);
    for (name, swap) in [("binary_little_endian", false), ("binary_big_endian", true)] {
        assert_eq!(read("b.ply", &binary_ply(name, swap)).unwrap().triangles, square());
    }
    let strips = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement tristrips 1\n\
        property list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n1e39 1 0\n8 0 1 2 3 -1 0 1 2\n";
    let scene = read("c.ply", strips.as_bytes()).unwrap();
    assert_eq!((scene.triangles.len(), scene.dropped.not_finite), (2, 1));
    // The library knows no NaN in text; in binary it is just another number.
    assert!(read("d.ply", strips.replace("1e39", "nan").as_bytes()).unwrap_err().to_string().contains("d.ply:13: "));
    let mut binary = binary_ply("binary_little_endian", false);
    let at = binary.len() - 17 - 48;
    binary[at..at + 4].copy_from_slice(&f32::NAN.to_le_bytes());
    assert!(read("e.ply", &binary).unwrap_err().to_string().contains("(only 2 triangles with a NaN"));
}

/// The square as quads in binary.
pub(super) fn binary_ply(format: &str, swap: bool) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat {format} 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n\
        property list uchar uint vertex_index\nend_header\n"
    )
    .into_bytes();
    let mut word = |bits: u32| bytes.extend(if swap { bits.to_be_bytes() } else { bits.to_le_bytes() });
    let corners = [0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.];
    corners.map(f32::to_bits).into_iter().for_each(&mut word);
    bytes.push(4);
    (0..4).for_each(|i: u32| bytes.extend(if swap { i.to_be_bytes() } else { i.to_le_bytes() }));
    bytes
}

#[test]
fn ply_faults_say_what_and_where() {
    for (from, to, words) in [
        ("0 1 2 3\n", "0 1 2 9\n", "face 0: vertex index 9 is out of range: there are 4 vertices"),
        ("0 1 2 3\n", "0 1 2 -3\n", "vertex index -3"),
        ("1 1 0 9", "1 x 0 9", "a.ply:18: "),
        ("element vertex 4", "element vertex 40", "a.ply:"),
        ("property double y\n", "", "its vertices have no y"),
        ("ply\n", "plx\n", "magic number"),
        (
            "element edge 1\nproperty int vertex1\nproperty int vertex2\n",
            "element edge 99999999999\n",
            "without properties",
        ),
    ] {
        let text = PLY_TEXT.replacen(from, to, 1);
        let error = read("a.ply", text.as_bytes()).expect_err(to).to_string();
        assert!(error.contains(words) && error.lines().count() == 1, "{to}: {error}");
    }
    let points = PLY_TEXT.replace("element face 2", "element face 0").replace("7 4 0 1 2 3\n7 2 0 1\n", "");
    let error = read("a.ply", points.as_bytes()).unwrap_err().to_string();
    assert!(error.contains("no triangles (only 4 points and lines)"), "{error}");
}

pub(super) const STL_TEXT: &str = "solid one\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   vertex 1 1 0\n  \
    endloop\n endfacet\nendsolid one\nSOLID two\nfacet normal nan nan nan\nouter loop\nvertex 0 0 0\nvertex 1 1 0\nvertex 0 1e0 0\n\
    endloop\nendfacet\nfacet normal 0 0 0\nouter loop\nvertex inf 0 0\nvertex 1 1 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n";

pub(super) fn binary_stl(header: &str, triangles: &[Triangle]) -> Vec<u8> {
    let mut bytes = format!("{header:80}").into_bytes();
    bytes.extend(u32::try_from(triangles.len()).unwrap().to_le_bytes());
    for triangle in triangles {
        bytes.extend([0; 12]);
        bytes.extend(triangle.v.iter().flat_map(|v| v.to_array()).flat_map(f32::to_le_bytes));
        bytes.extend([0; 2]);
    }
    bytes
}

#[test]
fn stl_text_and_binary() {
    let scene = read("a.stl", STL_TEXT.as_bytes()).unwrap();
    assert_eq!((scene.triangles.as_slice(), scene.dropped.not_finite), (square().as_slice(), 1));
    assert_eq!(scene.objects.iter().map(|o| o.name.as_str()).collect::<Vec<_>>(), ["one", "two"]);
    // A header that begins like a text is still a header.
    for header in ["solid by an exporter", "made by hand"] {
        assert_eq!(read("b.STL", &binary_stl(header, &square())).unwrap().triangles, square());
    }
    let long = [binary_stl("x", &square()), vec![1; 7]].concat();
    let scene = read("c.stl", &long).unwrap();
    assert_eq!(scene.warnings, ["7 bytes behind the last of 2 triangles are ignored"]);
}

#[test]
fn stl_faults_say_what_and_where() {
    for (from, to, words) in [
        ("vertex 1 0 0", "vertex 1 0", "a.stl:5: a vertex needs three numbers"),
        ("vertex 1 0 0", "vertex 1 0 z", "a.stl:5: 'z' is not a number"),
        ("   vertex 1 0 0\n", "", "a.stl:6: a facet with 2 vertices"),
        ("endfacet", "endfacert", "a.stl:8: 'endfacert' has no meaning"),
    ] {
        let error = read("a.stl", STL_TEXT.replacen(from, to, 1).as_bytes()).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
    let cut = &STL_TEXT[..STL_TEXT.rfind("endloop").unwrap()];
    assert!(read("a.stl", cut.as_bytes()).unwrap_err().to_string().contains("the file ends within a facet"));
    let binary = binary_stl("x", &square());
    let error = read("a.stl", &binary[..150]).unwrap_err().to_string();
    assert!(error.contains("ends after 1 of 2 triangles"), "{error}");
    assert!(read("a.stl", &binary[..80]).unwrap_err().to_string().contains("80 bytes are too few"));
}

/// A square, a mirrored and shifted copy of it, a glass strip, a lamp in points; numbers in every form.
pub(super) fn gltf_document(uri: &str) -> String {
    let uri = if uri.is_empty() { String::new() } else { format!(r#""uri":"{uri}","#) };
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0,1,4]}}],
        "nodes":[{{"mesh":0,"name":"square","children":[2]}},{{"mesh":0,"scale":[-1,1,1],"translation":[5,0,0]}},
            {{"mesh":1,"translation":[0,0,2],"children":[3]}},{{"mesh":2}},{{"camera":0,"name":"view","translation":[0,0,9]}}],
        "cameras":[{{"type":"perspective","perspective":{{"yfov":1.0,"znear":0.1}}}}],
        "materials":[{{"name":"glass","extensions":{{"KHR_materials_transmission":{{"transmissionFactor":0.75}},
            "KHR_materials_ior":{{"ior":1.33}}}},"pbrMetallicRoughness":{{"baseColorFactor":[0,1,0,1],"metallicFactor":0}}}},
            {{"name":"gold","pbrMetallicRoughness":{{"baseColorFactor":[1,0.5,0,1],"roughnessFactor":0.1}}}}],
        "extensionsUsed":["KHR_materials_transmission","KHR_materials_ior"],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":2}},"indices":1,"material":1}}]}},
            {{"primitives":[{{"attributes":{{"POSITION":0}},"mode":5,"material":0}}]}},
            {{"primitives":[{{"attributes":{{"POSITION":0}},"mode":0}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}},
            {{"bufferView":1,"componentType":5121,"count":6,"type":"SCALAR"}},
            {{"bufferView":2,"componentType":5121,"normalized":true,"count":4,"type":"VEC2"}}],
        "bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":6}},
            {{"buffer":0,"byteOffset":56,"byteLength":16,"byteStride":4}}],
        "buffers":[{{{uri}"byteLength":72}}]}}"#
    )
}

pub(super) fn gltf_buffer() -> Vec<u8> {
    let corners = [0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.];
    let mut bytes: Vec<u8> = corners.into_iter().flat_map(f32::to_le_bytes).collect();
    bytes.extend([0, 1, 2, 0, 2, 3, 0, 0]);
    bytes.extend([0, 0, 0, 0, 255, 0, 0, 0, 255, 255, 0, 0, 0, 255, 0, 0]);
    bytes
}

pub(super) fn glb() -> Vec<u8> {
    let mut json = gltf_document("").into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let blob = gltf_buffer();
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((28 + json.len() as u32 + blob.len() as u32).to_le_bytes());
    for (kind, part) in [(b"JSON", &json), (b"BIN\0", &blob)] {
        bytes.extend((part.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(part);
    }
    bytes
}

#[test]
fn gltf_in_all_its_packings() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("my data.bin"), gltf_buffer()).unwrap();
    fs::write(at("beside.gltf"), gltf_document("my%20data.bin")).unwrap();
    use base64::Engine;
    let encoded = base64::engine::general_purpose::STANDARD.encode(gltf_buffer());
    let embedded = gltf_document(&format!("data:application/octet-stream;base64,{encoded}"));
    fs::write(at("embedded.gltf"), embedded).unwrap();
    fs::write(at("binary.glb"), glb()).unwrap();
    for name in ["beside.gltf", "embedded.gltf", "binary.glb"] {
        let scene = load(&at(name)).unwrap();
        assert_eq!(scene.triangles[..2], square());
        assert_eq!(scene.triangles.len(), 6, "{name}");
        // The strip comes next, two above; the mirrored copy last, its winding turned.
        let shifted = |p: Vec3| p + Vec3::Z * 2.0;
        assert_eq!(scene.triangles[2].v.map(|p| p - Vec3::Z * 2.0), square()[0].v, "{:?}", shifted(Vec3::ZERO));
        let flipped = scene.triangles[4];
        assert_eq!(flipped.v, [Vec3::new(5.0, 0.0, 0.0), Vec3::new(4.0, 1.0, 0.0), Vec3::new(4.0, 0.0, 0.0)]);
        assert!(flipped.cross().z > 0.0);
        assert_eq!((scene.dropped.points_and_lines, scene.material_ids.as_slice()), (4, [2, 2, 1, 1, 2, 2].as_slice()));
        let glass = &scene.materials[1];
        assert_eq!((glass.opacity, glass.refraction_index, glass.illumination_model), (0.25, 1.33, 7));
        assert_eq!(glass.transmission_filter, Vec3::Y);
        assert_eq!((scene.materials[2].diffuse, scene.materials[2].illumination_model), (Vec3::ZERO, 3));
        assert_eq!((scene.cameras[0].name.as_str(), scene.camera), ("view", scene.cameras[0].camera));
        assert_eq!(scene.camera.eye, Vec3::new(0.0, 0.0, 9.0));
        assert!(scene.texture_coordinates.is_empty(), "no material has a texture");
    }
}

#[test]
fn gltf_textures_come_with_their_coordinates() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    image::RgbImage::new(1, 1).save(at("dot.png")).unwrap();
    fs::write(at("data.bin"), gltf_buffer()).unwrap();
    let text = gltf_document("data.bin")
        .replacen(r#""roughnessFactor":0.1"#, r#""baseColorTexture":{"index":0}"#, 1)
        .replacen(r#""cameras""#, r#""textures":[{"source":0}],"images":[{"uri":"dot.png"}],"cameras""#, 1);
    fs::write(at("a.gltf"), text).unwrap();
    let scene = load(&at("a.gltf")).unwrap();
    assert!(scene.materials[2].diffuse_map.as_ref().unwrap().decode().is_ok());
    // v points upwards here, downwards there.
    assert_eq!(scene.texture_coordinates[0], [Vec2::new(0.0, 1.0), Vec2::ONE, Vec2::X]);
}

#[test]
fn gltf_faults_say_what() {
    for (from, to, words) in [
        ("\"count\":4,\"type\":\"VEC3\"", "\"count\":5,\"type\":\"VEC3\"", "accessor 0 reaches beyond its buffer"),
        ("\"byteLength\":72", "\"byteLength\":99", "buffer 0 has 72 of 99 bytes"),
        ("data.bin", "http://far.bin", "neither embedded data nor a file"),
        ("data.bin", "no.bin", "cannot read "),
        ("\"mesh\":2", "\"mesh\":7", "a.gltf"),
        ("\"asset\"", "\"asset", "a.gltf"),
        ("\"extensionsUsed\"", "\"extensionsRequired\":[\"KHR_draco_mesh_compression\"],\"extensionsUsed\"", "a.gltf"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("data.bin"), gltf_buffer()).unwrap();
        let path = folder.path().join("a.gltf");
        fs::write(&path, gltf_document("data.bin").replacen(from, to, 1)).unwrap();
        let error = load(&path).expect_err(to).to_string();
        assert!(error.contains(words) && error.lines().count() == 1, "{to}: {error}");
    }
    // Nodes in a circle are visited once each.
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("data.bin"), gltf_buffer()).unwrap();
    let path = folder.path().join("a.gltf");
    fs::write(&path, gltf_document("data.bin").replacen("{\"mesh\":2}", "{\"mesh\":2,\"children\":[0]}", 1)).unwrap();
    assert_eq!(load(&path).unwrap().triangles.len(), 6);
}

pub(super) fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    packed.write_all(bytes).unwrap();
    packed.finish().unwrap()
}

pub(super) fn zstandard(bytes: &[u8]) -> Vec<u8> {
    ruzstd::encoding::compress_to_vec(bytes, ruzstd::encoding::CompressionLevel::Fastest)
}

#[test]
fn compressed_files_are_unpacked_on_the_way() {
    let scene = families::FAMILIES.iter().find(|f| f.name == "soup").unwrap().generate(20_000, 1);
    let folder = tempfile::tempdir().unwrap();
    let plain = folder.path().join("plain.obj");
    crate::scene::export_obj(&scene, &plain).unwrap();
    let text = fs::read(&plain).unwrap();
    // Two members or frames one behind the other, as parallel packers write them; a frame without data between.
    let (front, back) = text.split_at(text.len() / 3);
    let skippable = b"\x50\x2a\x4d\x18\x03\0\0\0abc".to_vec();
    for (name, packed) in [
        ("a.obj.gz", gzip(&text)),
        ("b.obj.gz", [gzip(front), gzip(back)].concat()),
        ("c.obj.zst", zstandard(&text)),
        ("d.OBJ.ZST", [zstandard(front), skippable, zstandard(back)].concat()),
    ] {
        assert_eq!(read(name, &packed).unwrap().triangles, scene.triangles, "{name}");
        let error = read(name, &packed[..packed.len() - 9]).expect_err(name);
        assert!(matches!(error, SceneError::Unreadable { .. }) && error.to_string().lines().count() == 1, "{error}");
    }
    assert_eq!(read("e.stl.gz", &gzip(&binary_stl("x", &square()))).unwrap().triangles, square());
    assert_eq!(read("f.glb.zst", &zstandard(&glb())).unwrap().triangles.len(), 6);
    assert!(read("g.gz", &gzip(&text)).unwrap_err().to_string().contains("no known format"));
    let error = read("h.obj.gz", &TRIANGLE.repeat(9).into_bytes()).unwrap_err().to_string();
    assert!(error.contains("cannot read") && error.contains("gzip"), "{error}");
}

#[test]
fn progress_reaches_the_size_of_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.obj.gz");
    fs::write(&path, gzip(TRIANGLE.as_bytes())).unwrap();
    let mut told = Vec::new();
    load_watched(&path, &mut |done, size| told.push((done, size))).unwrap();
    let size = fs::metadata(&path).unwrap().len();
    assert!(told.is_sorted() && told.last() == Some(&(size, size)), "{told:?}");
}
