//! GLB: what is written, what is read, and what a stranger's file may look like.

use crate::fuzzed::glb::file;
use crate::support::altered_files::{FileRewriter, flipped};
use crate::support::builds::{SMALL, folder, morion, parsed, save, told};
use crate::support::small_but;
use morion::internals::export::{ReadError, read_glb, read_stl};
use morion::internals::geom::{DVec3, TriMesh};
use morion::internals::pipeline::{Silent, build, verify};
use morion::internals::results::Verdict;
use serde_json::{Value, json};

/// The JSON of a GLB.
fn document(bytes: &[u8]) -> Value {
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&bytes[20..20 + length]).unwrap()
}

fn tetrahedron() -> TriMesh {
    TriMesh {
        vertices: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z],
        triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    }
}

/// Binary chunk of a mesh as other programs write it: a position every 16 bytes, then two-byte indices.
fn interleaved(mesh: &TriMesh, place: impl Fn(DVec3) -> DVec3) -> Vec<u8> {
    let vertex = |v: &DVec3| place(*v).as_vec3().extend(7.0).to_array();
    let places = mesh.vertices.iter().flat_map(vertex).flat_map(f32::to_le_bytes);
    let corners = mesh.triangles.iter().flatten().flat_map(|&v| (v as u16).to_le_bytes());
    places.chain(corners).collect()
}

/// The document for such a chunk, with these nodes, the first of which is shown.
fn theirs(mesh: &TriMesh, nodes: Value) -> Value {
    let [vertices, corners] = [mesh.vertices.len(), 3 * mesh.triangles.len()];
    json!({
        "asset": { "version": "2.0", "generator": "elsewhere", "minVersion": "2.0" },
        "scenes": [{ "nodes": [0], "name": "only" }],
        "nodes": nodes,
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "NORMAL": 9 }, "indices": 1 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": vertices, "type": "VEC3" },
            { "bufferView": 1, "componentType": 5123, "count": corners, "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": 16 * vertices, "byteStride": 16 },
            { "buffer": 0, "byteOffset": 16 * vertices, "byteLength": 2 * corners },
        ],
        "buffers": [{ "byteLength": 16 * vertices + 2 * corners }],
    })
}

/// A tetrahedron of 1 mm in metres with Y up.
fn small_body() -> (Value, Vec<u8>) {
    let mesh = tetrahedron();
    let bin = interleaved(&mesh, |v| DVec3::new(v.x, v.z, -v.y));
    (theirs(&mesh, json!([{ "mesh": 0, "scale": [0.001, 0.001, 0.001] }])), bin)
}

fn volume(mesh: &TriMesh) -> f64 {
    let six = |t: usize| {
        let [a, b, c] = mesh.corners(t);
        a.cross(b).dot(c)
    };
    (0..mesh.triangles.len()).map(six).sum::<f64>() / 6.0
}

#[test]
fn a_glb_is_the_stl_to_the_bit() {
    let folder = folder();
    let source = parsed(&small_but("[\"stl\", \"obj\"]", "[\"stl\", \"glb\"]"));
    let report = build(&source, folder.path(), &Silent).unwrap();
    assert_eq!(report.verdict, Verdict::Pass, "{:?}", report.reasons);
    let read = |name: &str| std::fs::read(folder.path().join("small").join(name)).unwrap();
    let (stl, glb) = (read("mirror.stl"), read("mirror.glb"));
    assert_eq!(read_stl(&stl).unwrap().mesh, read_glb(&glb).unwrap().mesh);
    // The rays of both see the same.
    assert_eq!(report.trace[1].file, "mirror.glb");
    assert_eq!(report.trace[0].errors, report.trace[1].errors);
    // Its words are those of the build.
    let found = document(&glb);
    assert_eq!(found["asset"]["generator"], "Morion");
    assert_eq!(found["asset"]["extras"]["profile"], "small");
    assert_eq!(found["asset"]["extras"]["sha256"], *report.profile.sha256);
    let tolerances = found["asset"]["extras"]["tolerances"].as_str().unwrap();
    assert!(tolerances.contains("chord um 20:") && tolerances.contains("facet px 3:"));
    // The first primitive is what reflects.
    let primitives = &found["meshes"][0]["primitives"];
    let optical = &found["accessors"][primitives[0]["indices"].as_u64().unwrap() as usize];
    assert_eq!(optical["count"], 3 * report.mesh.as_ref().unwrap().optical_triangles);
}

/// Strangers use other axes, units, strides, hierarchies and names.
#[test]
fn a_glb_of_another_making_is_read_and_verified() {
    let folder = folder();
    let home = folder.path();
    save(home, SMALL);
    assert_eq!(told(&morion(home, &["build", "small.toml", "--quiet"])).0, 0);
    let stl = std::fs::read(home.join("out/small/mirror.stl")).unwrap();
    let mesh = read_stl(&stl).unwrap().mesh;
    assert!(mesh.vertices.len() <= 65535);
    // Half as large in millimetres with Z up and 4 to the left, below a node that turns, one that doubles and
    // one that only gathers. Another mesh is in no scene.
    let bin = interleaved(&mesh, |v| 0.5 * v - 4.0 * DVec3::X);
    let half = 0.5_f64.sqrt();
    let nodes = json!([
        { "children": [2] },
        { "mesh": 0 },
        { "rotation": [-half, 0, 0, half], "scale": [0.001, 0.001, 0.001], "children": [3] },
        { "matrix": [2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1], "children": [4] },
        { "mesh": 0, "translation": [4, 0, 0], "name": "part" },
    ]);
    let path = home.join("theirs.GLB");
    std::fs::write(&path, file(&theirs(&mesh, nodes).to_string(), &bin)).unwrap();
    let report = verify(&parsed(SMALL), &path, &Silent).unwrap();
    assert_eq!(report.verdict, Verdict::Pass, "{:?}", report.reasons);
    assert_eq!(report.files[0].format, "glb");
    assert_eq!(report.units.unwrap().chosen, "declared");
    let arguments = ["verify", "theirs.GLB", "--profile", "small.toml", "--units", "mm"];
    let (code, _, err) = told(&morion(home, &arguments));
    assert!(code == 2 && err.contains("says what its unit is; leave --units out"), "{err}");
}

#[test]
fn nodes_place_every_instance_and_a_reflection_keeps_the_outside_outside() {
    let (mut document, bin) = small_body();
    document["nodes"] = json!([
        { "children": [1, 2] },
        { "mesh": 0, "scale": [0.001, 0.001, 0.001], "translation": [0.01, 0, 0] },
        { "mesh": 0, "matrix": [-0.002, 0, 0, 0, 0, 0.002, 0, 0, 0, 0, 0.002, 0, 0, 0, 0, 1] },
    ]);
    // The scene that is shown is not the first.
    document["scenes"] = json!([{ "nodes": [1] }, { "nodes": [0] }]);
    document["scene"] = json!(1);
    let mesh = read_glb(&file(&document.to_string(), &bin)).unwrap().mesh;
    assert_eq!(mesh.triangles.len(), 8);
    assert!((volume(&mesh) - 9.0 / 6.0).abs() < 1e-12, "{}", volume(&mesh));
    let (lo, hi) = mesh.bounds().unwrap();
    let wanted = [DVec3::new(-2.0, 0.0, 0.0), DVec3::new(11.0, 2.0, 2.0)];
    assert!((lo - wanted[0]).length() + (hi - wanted[1]).length() < 1e-12, "{lo} {hi}");
}

#[test]
fn indices_of_every_kind_or_none_tell_the_facets() {
    let mesh = tetrahedron();
    let corners: Vec<u32> = mesh.triangles.iter().flatten().copied().collect();
    let (document, bin) = small_body();
    let wanted = read_glb(&file(&document.to_string(), &bin)).unwrap().mesh;
    assert_eq!(wanted.triangles.len(), 4);
    for (kind, size) in [(5121, 1), (5125, 4)] {
        let mut bin = bin[..64].to_vec();
        bin.extend(corners.iter().flat_map(|v| v.to_le_bytes()[..size].to_vec()));
        let mut document = document.clone();
        document["accessors"][1]["componentType"] = json!(kind);
        document["bufferViews"][1]["byteLength"] = json!(12 * size);
        document["buffers"][0]["byteLength"] = json!(64 + 12 * size);
        assert_eq!(read_glb(&file(&document.to_string(), &bin)).unwrap().mesh, wanted);
    }
    let (mut document, mut soup) = (document.clone(), Vec::new());
    corners.iter().for_each(|&v| soup.extend(&bin[16 * v as usize..][..16]));
    document["meshes"][0]["primitives"][0] = json!({ "attributes": { "POSITION": 0 }, "mode": 4 });
    document["accessors"] =
        json!([{ "bufferView": 0, "componentType": 5126, "count": 12, "type": "VEC3" }]);
    document["bufferViews"] = json!([{ "buffer": 0, "byteLength": 192, "byteStride": 16 }]);
    document["buffers"][0]["byteLength"] = json!(192);
    assert_eq!(read_glb(&file(&document.to_string(), &soup)).unwrap().mesh, wanted);
}

/// Why the small body is refused with another value at a place of its document.
#[track_caller]
fn refused(place: &str, value: Value, why: &str) {
    let (mut document, bin) = small_body();
    let (above, key) = place.rsplit_once('/').unwrap();
    let above = document.pointer_mut(above).unwrap();
    match above.as_array_mut() {
        Some(list) => list[key.parse::<usize>().unwrap()] = value,
        None => above[key] = value,
    }
    says(&file(&document.to_string(), &bin), why);
}

#[track_caller]
fn says(bytes: &[u8], why: &str) {
    match read_glb(bytes) {
        Err(error @ (ReadError::Glb(_) | ReadError::Empty | ReadError::NotFinite { .. })) => {
            let said = error.to_string();
            assert!(said.contains(why), "{said}, not {why}");
        }
        other => panic!("{other:?}, not {why}"),
    }
}

#[test]
fn what_is_not_read_is_named_with_a_way_out() {
    let draco = "KHR_draco_mesh_compression is not read: save it without compression";
    refused("/extensionsRequired", json!(["KHR_draco_mesh_compression"]), draco);
    let meshopt = "EXT_meshopt_compression is not read: save it without compression";
    refused(
        "/extensionsRequired",
        json!(["KHR_materials_ior", "EXT_meshopt_compression"]),
        meshopt,
    );
    refused(
        "/extensionsRequired",
        json!(["X_Y"]),
        "X_Y is not read: save it without this extension",
    );
    refused(
        "/buffers/0/uri",
        json!("part.bin"),
        "buffers[0]: it is outside of the file's binary chunk",
    );
    refused(
        "/bufferViews/0/buffer",
        json!(1),
        "bufferViews[0]: there is no buffer 1, but 1 of them",
    );
    refused(
        "/accessors/0/sparse",
        json!({}),
        "accessors[0]: sparse data are not read: save it without",
    );
    refused(
        "/accessors/0/bufferView",
        Value::Null,
        "accessors[0]: it has no data of its own: save it",
    );
    let primitive = "/meshes/0/primitives/0";
    for (mode, kind) in [(0, "points"), (1, "lines"), (5, "triangle strips"), (6, "triangle fans")]
    {
        let why = format!(
            "meshes[0].primitives[0]: {kind} (mode {mode}) are not read: save it as triangles"
        );
        refused(&format!("{primitive}/mode"), json!(mode), &why);
    }
    let morph = "morph targets are not read: apply them before saving";
    refused(&format!("{primitive}/targets"), json!([{ "POSITION": 0 }]), morph);
    refused("/nodes/0/skin", json!(0), "nodes[0]: skins are not read: apply them before saving");
    let instances = "nodes[0]: EXT_mesh_gpu_instancing is not read: save a node for each instance";
    refused("/nodes/0/extensions", json!({ "EXT_mesh_gpu_instancing": {} }), instances);
    refused("/accessors/0/componentType", json!(5122), "save it without quantization");
    refused("/asset/minVersion", json!("2.1"), "asset: it is of version 2.1: save it as glTF 2.0");
}

#[test]
fn what_contradicts_itself_is_refused_at_its_place() {
    refused("/scene", json!(1), "scene: there is no scene 1, but 1 of them");
    refused("/scenes", json!([{}, {}]), "scene: it must say which of 2 scenes is meant");
    refused("/scenes", json!([{}]), "the file holds no facets");
    refused("/nodes/0/children", json!([0]), "nodes[0]: it is there twice, but nodes form trees");
    refused("/nodes/0/children", json!([7]), "nodes[0]: there is no node 7, but 1 of them");
    refused("/scenes/0/nodes", json!([0, 0]), "nodes[0]: it is there twice");
    refused("/nodes/0/mesh", json!(3), "nodes[0]: there is no mesh 3");
    refused(
        "/nodes/0/rotation",
        json!([0, 0, 0, 2]),
        "nodes[0]: rotation must be a unit quaternion",
    );
    let mut matrix = [0.0; 16];
    refused(
        "/nodes/0",
        json!({ "mesh": 0, "matrix": matrix }),
        "last row of its matrix must be 0 0 0 1",
    );
    matrix[15] = 1.0;
    refused("/nodes/0/matrix", json!(matrix), "both a matrix and translation, rotation or scale");
    refused("/nodes/0/translation", json!([1e308, 0, 0]), "not a finite number");
    let primitive = "/meshes/0/primitives/0";
    refused(&format!("{primitive}/attributes"), json!({}), "primitives[0]: it has no POSITION");
    refused(&format!("{primitive}/indices"), json!(5), "primitives[0]: there is no accessor 5");
    refused(
        &format!("{primitive}/indices"),
        json!(0),
        "accessors[0]: indices must be SCALAR and unsigned",
    );
    refused("/accessors/1/count", json!(11), "it has 11 corners, no multiple of 3");
    refused("/accessors/0/count", json!(3), "primitives[0]: facet 1 has vertex 3 of 3");
    refused("/accessors/0/count", json!(0), "accessors[0]: its count is 0");
    for count in [5, 1 << 40, u64::MAX] {
        refused(
            "/accessors/0/count",
            json!(count),
            "do not fit into the 64 bytes of bufferViews[0]",
        );
    }
    refused(
        "/accessors/1/byteOffset",
        json!(u64::MAX),
        "accessors[1]: its 12 items of 2 bytes do not",
    );
    refused(
        "/bufferViews/0/byteStride",
        json!(8),
        "bufferViews[0]: byteStride is 8, not from 12 to 252",
    );
    refused(
        "/bufferViews/0/byteLength",
        json!(u64::MAX),
        "bufferViews[0]: it does not fit into the 88",
    );
    refused(
        "/buffers/0/byteLength",
        json!(89),
        "buffers[0]: it has 89 bytes, but the binary chunk has 88",
    );
    refused("/accessors/0/type", json!("VEC2"), "accessors[0]: positions must be VEC3");
    refused("/accessors/0/count", json!(-1), "the JSON chunk: invalid value");
    let many = vec![json!({}); 100_001];
    refused("/nodes", json!(many), "the JSON chunk: a list has more than 100000 items");
}

#[test]
fn a_few_bytes_cannot_claim_gigabytes() {
    // 100 primitives of four facets, 99 999 times.
    let (mut document, bin) = small_body();
    let primitive = document["meshes"][0]["primitives"][0].clone();
    document["meshes"][0]["primitives"] = json!(vec![primitive; 100]);
    document["scenes"][0]["nodes"] = json!((0..99_999).collect::<Vec<_>>());
    document["nodes"] = json!(vec![json!({ "mesh": 0 }); 99_999]);
    says(&file(&document.to_string(), &bin), "or more than 100000 primitives");
    // 3 million facets, 40 times.
    let (mut document, mut bin) = small_body();
    bin.resize(64 + 9_000_000, 0);
    document["accessors"][1] =
        json!({ "bufferView": 1, "componentType": 5121, "count": 9_000_000, "type": "SCALAR" });
    document["bufferViews"][1]["byteLength"] = json!(9_000_000);
    document["buffers"][0]["byteLength"] = json!(bin.len());
    document["scenes"][0]["nodes"] = json!((0..40).collect::<Vec<_>>());
    document["nodes"] = json!(vec![json!({ "mesh": 0 }); 40]);
    says(&file(&document.to_string(), &bin), "more than 100000000 vertices or facets");
    // Nodes as deep as there may be.
    let (mut document, bin) = small_body();
    let deep: Vec<Value> = (1..100_000).map(|k| json!({ "children": [k] })).collect();
    document["nodes"] = json!([deep, vec![json!({ "mesh": 0 })]].concat());
    assert_eq!(read_glb(&file(&document.to_string(), &bin)).unwrap().mesh.triangles.len(), 4);
}

#[test]
fn chunks_are_held_to_what_they_say() {
    let (document, bin) = small_body();
    let (text, whole) = (document.to_string(), file(&document.to_string(), &bin));
    assert_eq!(read_glb(&whole).unwrap().mesh.triangles.len(), 4);
    let with = |at: usize, word: u32| {
        let mut bytes = whole.clone();
        bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
        bytes
    };
    let second = 20 + text.len().next_multiple_of(4);
    says(b"solid", "it does not begin with \"glTF\": save it as binary glTF");
    says(b"glTF\x02\0\0\0", "it ends within its header of 12 bytes");
    says(&with(4, 1), "it is of version 1: save it as glTF 2.0");
    says(&with(8, u32::MAX), "it says that it has 4294967295 bytes, but it has ");
    says(&with(12, u32::MAX - 3), "chunk 0 says that it has 4294967292 bytes, but ");
    says(&with(second, 86), "chunk 1 has 86 bytes, no multiple of 4");
    says(&with(second + 4, u32::from_le_bytes(*b"JSON")), "chunk 1 is JSON, which chunk 0 must be");
    says(&with(16, u32::from_le_bytes(*b"BIN\0")), "chunk 0 is BIN, which chunk 1 must be");
    says(&with(16, 0), "its first chunk is not JSON");
    says(&with(20, 0x20), "the JSON chunk: ");
    says(&with(second + 4, 0), "buffers[0]: it has 88 bytes, but the binary chunk has 0");
    // Chunks of other kinds are for others.
    let mut more = whole.clone();
    more.extend([4, 0, 0, 0, b'M', b'O', b'R', b'E', 1, 2, 3, 4]);
    let length = more.len() as u32;
    more[8..12].copy_from_slice(&length.to_le_bytes());
    assert_eq!(read_glb(&more).unwrap(), read_glb(&whole).unwrap());
    more.pop();
    says(&more, "it says that it has ");
}

#[test]
fn a_glb_cut_off_anywhere_is_refused_and_no_byte_of_it_brings_the_reader_down() {
    let (document, bin) = small_body();
    let whole = file(&document.to_string(), &bin);
    for length in 0..whole.len() {
        let mut cut = whole[..length].to_vec();
        says(&cut, "not a readable GLB: ");
        // Nor where the header hides it.
        if length >= 12 {
            cut[8..12].copy_from_slice(&(length as u32).to_le_bytes());
            assert!(read_glb(&cut).is_err(), "{length}");
        }
    }
    for at in 0..whole.len() {
        for change in [1, 0x10, 0x80, 0xff] {
            let mut altered = whole.clone();
            altered[at] ^= change;
            let _ = read_glb(&altered);
        }
    }
}

#[test]
fn a_damaged_glb_fails_and_is_named() {
    let only = parsed(&small_but("[\"stl\", \"obj\"]", "[\"glb\"]"));
    for percent in [0, 20, 50, 99] {
        let folder = folder();
        let report =
            build(&only, folder.path(), &FileRewriter(|bytes| flipped(bytes, percent, 0x40)))
                .unwrap();
        assert_eq!(report.verdict, Verdict::Fail, "{percent} %");
        assert!(report.reasons.iter().all(|reason| reason.to_string().starts_with("mirror.glb: ")));
    }
}
