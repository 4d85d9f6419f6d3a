//! A file damaged between writing and reading: the verdict says fail, and names what is wrong.

use crate::support::altered_files::FileRewriter;
use crate::support::builds::{SMALL, command, files, folder, morion, parsed, save, told};
use crate::support::{share, small_but};
use morion::internals::export::{ImportedMesh, read_obj, read_stl};
use morion::internals::geom::DVec3;
use morion::internals::pipeline::{Observer, Silent, build, verify};
use morion::internals::profile::Profile;
use morion::internals::results::{BuildReport, FileFault, Reason, Verdict};
use std::path::Path;

const STL: &str = "formats = [\"stl\"]";
const OBJ: &str = "formats = [\"obj\"]";
const GLB: &str = "formats = [\"glb\"]";
/// Length of an STL before its first facet.
const HEAD: usize = 84;
/// Length of a facet in an STL.
const FACET: usize = 50;

fn small(formats: &str) -> Profile {
    parsed(&small_but("formats = [\"stl\", \"obj\"]", formats))
}

/// The report of a build whose only file is damaged. What is on the disk afterwards is what the
/// report speaks of.
fn damaged(formats: &str, damage: impl Fn(Vec<u8>) -> Vec<u8> + Sync) -> BuildReport {
    let folder = folder();
    let report = build(&small(formats), folder.path(), &FileRewriter(damage)).unwrap();
    let made = files(&folder.path().join("small"));
    assert_eq!(made["report.json"], report.json().into_bytes());
    let [file] = &report.files[..] else { panic!("{} files", report.files.len()) };
    assert_eq!(made[&file.name].len() as u64, file.bytes);
    let page = String::from_utf8(made["report.html"].clone()).unwrap();
    assert!(page.contains(if report.verdict == Verdict::Pass { ">pass<" } else { ">fail<" }));
    report
}

/// The one reason that holds all of `words`.
#[track_caller]
fn reason(report: &BuildReport, words: &[&str]) -> String {
    assert_eq!(report.verdict, Verdict::Fail);
    reason_of(&report.reasons, words)
}

/// The one of `reasons` that holds all of `words`.
#[track_caller]
fn reason_of(reasons: &[Reason], words: &[&str]) -> String {
    let fits = |reason: &String| words.iter().all(|word| reason.contains(word));
    match reasons.iter().map(ToString::to_string).find(fits) {
        Some(reason) => reason,
        None => panic!("no reason with {words:?} in {reasons:#?}"),
    }
}

fn place(v: DVec3) -> String {
    format!("({}, {}, {})", v.x, v.y, v.z)
}

/// Facet of `read` that has a vertex well inside the optical face, and that vertex.
fn inner(read: &ImportedMesh) -> (usize, DVec3) {
    let here = DVec3::new(3.0, 2.0, 5.0);
    let top = |v: DVec3| v.z > 0.0;
    let far = |v: DVec3| (v - here).truncate().length();
    let v = *read
        .mesh
        .vertices
        .iter()
        .filter(|v| top(**v))
        .min_by(|a, b| far(**a).total_cmp(&far(**b)))
        .unwrap();
    let facets = 0..read.mesh.triangles.len();
    let facet = facets.into_iter().find(|&t| read.mesh.corners(t).contains(&v)).unwrap();
    (facet, v)
}

fn stl_bytes(v: DVec3) -> Vec<u8> {
    v.as_vec3().to_array().iter().flat_map(|x| x.to_le_bytes()).collect()
}

/// Where the corners of facet `t` are that lie at `v`.
fn corner_at(bytes: &[u8], t: usize, v: DVec3) -> Option<usize> {
    let corners = (0..3).map(|c| HEAD + FACET * t + 12 * (c + 1));
    corners.into_iter().find(|&at| bytes[at..at + 12] == stl_bytes(v)[..])
}

/// Takes facet `t` out of an STL, and out of the count.
fn without_facet(mut bytes: Vec<u8>, t: usize) -> Vec<u8> {
    let count = u32::from_le_bytes(bytes[80..84].try_into().unwrap()) - 1;
    bytes[80..84].copy_from_slice(&count.to_le_bytes());
    bytes.drain(HEAD + FACET * t..HEAD + FACET * (t + 1));
    bytes
}

fn count(bytes: &[u8]) -> usize {
    u32::from_le_bytes(bytes[80..84].try_into().unwrap()) as usize
}

/// Lifts the inner vertex by 50 um in the first `most` facets that have it.
fn lifted(mut bytes: Vec<u8>, most: usize) -> Vec<u8> {
    let (_, v) = inner(&read_stl(&bytes).unwrap());
    let there: Vec<usize> = (0..count(&bytes)).filter_map(|t| corner_at(&bytes, t, v)).collect();
    assert!(there.len() >= 4, "{} facets", there.len());
    for at in there.into_iter().take(most) {
        bytes[at..at + 12].copy_from_slice(&stl_bytes(v + 0.05 * DVec3::Z));
    }
    bytes
}

/// The lines of an OBJ, changed.
fn relined(bytes: Vec<u8>, change: impl Fn(&mut Vec<String>)) -> Vec<u8> {
    let text = String::from_utf8(bytes).unwrap();
    let mut lines: Vec<String> = text.lines().map(Into::into).collect();
    change(&mut lines);
    (lines.join("\n") + "\n").into_bytes()
}

/// The line of the inner facet.
fn inner_line(lines: &[String]) -> usize {
    let (facet, _) = inner(&read_obj((lines.join("\n") + "\n").as_bytes()).unwrap());
    let faces = lines.iter().enumerate().filter(|(_, line)| line.starts_with("f "));
    faces.map(|(at, _)| at).nth(facet).unwrap()
}

#[track_caller]
fn opens_at(report: &BuildReport, corners: [DVec3; 3]) {
    let facts = &report.trace[0].solid.check;
    assert!(!facts.closed && facts.oriented, "{facts:?}");
    for (a, b) in [(0, 1), (1, 2), (2, 0)].map(|(a, b)| (corners[a], corners[b])) {
        let name = &report.files[0].name;
        reason(report, &[name, "open: only facet ", &place(a), &place(b)]);
    }
}

#[track_caller]
fn exceeds_the_facet_limit(report: &BuildReport) {
    let trace = &report.trace[0];
    assert!(trace.solid.reasons.is_empty() && trace.solid.check.closed, "{:?}", trace.solid);
    let most = trace.errors.facet_error_px.unwrap().max;
    assert!(most > 3.0);
    let figures = format!("facet error {most:.3} px, over the 3 px of mesh.facet_px");
    reason(report, &[&report.files[0].name, &figures]);
}

#[test]
fn undamaged_files_pass() {
    for formats in [STL, OBJ, GLB] {
        let report = damaged(formats, |bytes| bytes);
        assert_eq!((report.verdict, &report.reasons[..]), (Verdict::Pass, &[][..]));
        assert_eq!(report.trace.len(), 1);
    }
}

#[test]
fn a_facet_missing_from_the_stl_leaves_it_open() {
    let report = damaged(STL, |bytes| {
        let (t, _) = inner(&read_stl(&bytes).unwrap());
        without_facet(bytes, t)
    });
    let made = whole(STL);
    let (t, _) = inner(&read_stl(&made).unwrap());
    opens_at(&report, read_stl(&made).unwrap().mesh.corners(t));
    // The facet that is named has the edge that is named.
    let read = read_stl(&without_facet(made, t)).unwrap();
    let reasons = report.reasons.iter().map(ToString::to_string);
    for reason in reasons.filter(|reason| reason.contains("open: ")) {
        let named = reason.split_once("only facet ").unwrap().1;
        let named: usize = named.split_once(' ').unwrap().0.parse().unwrap();
        let corners = read.mesh.corners(named).map(place);
        assert_eq!(corners.iter().filter(|corner| reason.contains(*corner)).count(), 2, "{reason}");
    }
}

/// The bytes of the undamaged file.
fn whole(formats: &str) -> Vec<u8> {
    let folder = folder();
    let report = build(&small(formats), folder.path(), &Silent).unwrap();
    std::fs::read(folder.path().join("small").join(&report.files[0].name)).unwrap()
}

#[test]
fn with_a_number_of_triangles_the_witness_is_held_to_what_was_proven() {
    let text = small_but("chord_um = 20\nfacet_px = 3", "max_triangles = 5000");
    let text = text.replace("formats = [\"stl\", \"obj\"]", STL);
    let (source, out) = (parsed(&text), folder());
    let lift = FileRewriter(|bytes| lifted(bytes, usize::MAX));
    let report = build(&source, out.path(), &lift).unwrap();
    reason(&report, &["mirror.stl: facet error ", " px of the mesh's bound"]);
    assert_eq!(build(&source, out.path(), &Silent).unwrap().verdict, Verdict::Pass);
}

#[test]
fn a_vertex_lifted_in_all_its_facets_exceeds_the_facet_limit() {
    exceeds_the_facet_limit(&damaged(STL, |bytes| lifted(bytes, usize::MAX)));
}

#[test]
fn a_vertex_lifted_in_one_facet_tears_the_surface() {
    let report = damaged(STL, |bytes| lifted(bytes, 1));
    let (_, v) = inner(&read_stl(&whole(STL)).unwrap());
    assert!(!report.trace[0].solid.check.closed);
    let torn = v.as_vec3().as_dvec3();
    let lifted = (v + 0.05 * DVec3::Z).as_vec3().as_dvec3();
    reason(&report, &["mirror.stl: open: only facet ", &place(torn)]);
    reason(&report, &["mirror.stl: open: only facet ", &place(lifted)]);
}

#[test]
fn a_turned_facet_is_named() {
    let report = damaged(STL, |mut bytes| {
        let (t, _) = inner(&read_stl(&bytes).unwrap());
        let second = HEAD + FACET * t + 24;
        let (b, c) = bytes[second..second + 24].split_at_mut(12);
        b.swap_with_slice(c);
        bytes
    });
    let facts = &report.trace[0].solid.check;
    assert!(facts.closed && !facts.oriented, "{facts:?}");
    reason(&report, &["mirror.stl: not oriented: facet ", "and its neighbour run the same way"]);
    let turned = relined_report(|lines| {
        let at = inner_line(lines);
        let [f, a, b, c] = *lines[at].split(' ').collect::<Vec<_>>() else { panic!() };
        lines[at] = [f, a, c, b].join(" ");
    });
    assert!(turned.trace[0].solid.check.closed && !turned.trace[0].solid.check.oriented);
    reason(&turned, &["mirror.obj: not oriented: facet "]);
}

/// The report of an OBJ whose lines are changed.
fn relined_report(change: impl Fn(&mut Vec<String>) + Sync) -> BuildReport {
    damaged(OBJ, |bytes| relined(bytes, &change))
}

#[test]
fn an_stl_that_ends_too_soon_says_how_many_bytes_there_should_be() {
    for cut in [1, 7, FACET, 20_000] {
        let report = damaged(STL, |mut bytes| {
            bytes.truncate(bytes.len() - cut);
            bytes
        });
        let found = report.files[0].bytes;
        let promised = format!("which take {} bytes", found + cut as u64);
        reason(&report, &["mirror.stl: ", &promised, &format!("but it has {found}")]);
        assert!(report.trace.is_empty() && report.frame.is_none());
    }
}

#[test]
fn an_stl_with_more_than_it_promises_is_refused() {
    let report = damaged(STL, |mut bytes| {
        bytes.push(0);
        bytes
    });
    reason(&report, &["mirror.stl: ", &format!("but it has {}", report.files[0].bytes)]);
}

#[test]
fn a_coordinate_that_is_no_number_is_named_by_its_facet() {
    let report = damaged(STL, |mut bytes| {
        bytes[HEAD + 123 * FACET + 16..][..4].copy_from_slice(&f32::NAN.to_le_bytes());
        bytes
    });
    reason(&report, &["mirror.stl: facet 123 has a coordinate that is not a finite number"]);
    assert!(report.trace.is_empty());
}

#[test]
fn an_emptied_file_is_unreadable() {
    for formats in [STL, OBJ, GLB] {
        let report = damaged(formats, |_| Vec::new());
        reason(&report, &[&report.files[0].name]);
        assert!(report.trace.is_empty() && report.files[0].bytes == 0);
    }
}

#[test]
fn a_face_missing_from_the_obj_leaves_it_open() {
    let report = relined_report(|lines| drop(lines.remove(inner_line(lines))));
    let read = read_obj(&whole(OBJ)).unwrap();
    opens_at(&report, read.mesh.corners(inner(&read).0));
}

#[test]
fn a_coordinate_edited_in_the_obj_exceeds_the_facet_limit() {
    exceeds_the_facet_limit(&relined_report(|lines| {
        let (_, v) = inner(&read_obj(lines.join("\n").as_bytes()).unwrap());
        let line = format!("v {} {} {}", v.x, v.y, v.z);
        let at = lines.iter().position(|l| *l == line).unwrap();
        lines[at] = format!("v {} {} {}", v.x, v.y, v.z + 0.05);
    }));
}

#[test]
fn only_one_damaged_file_of_two_is_blamed() {
    struct SpoilObj;
    impl Observer for SpoilObj {
        fn written(&self, path: &Path) {
            let bytes = std::fs::read(path).unwrap();
            if bytes.starts_with(b"#") {
                std::fs::write(path, &bytes[..bytes.len() / 3]).unwrap();
            }
        }
    }
    let folder = folder();
    let report = build(&parsed(SMALL), folder.path(), &SpoilObj).unwrap();
    assert_eq!(report.verdict, Verdict::Fail);
    assert!(report.reasons.iter().all(|reason| reason.to_string().starts_with("mirror.obj: ")));
    let traced: Vec<&str> = report.trace.iter().map(|trace| &*trace.file).collect();
    assert_eq!((traced, report.files.len()), (vec!["mirror.stl"], 2));
}

#[test]
#[ignore = "long: .ci/nightly"]
fn an_obj_or_a_glb_cut_off_anywhere_never_passes() {
    // The last byte of an OBJ is a line feed, which no one misses; all before it matter.
    for (formats, name, least) in [(OBJ, "cut.obj", 2), (GLB, "cut.glb", 1)] {
        let whole = whole(formats);
        let folder = folder();
        let path = folder.path().join(name);
        let length = whole.len();
        let ends = (least..30).map(|cut| length - cut);
        let spread = (0..12).map(|k| k * length / 12);
        for keep in share(3, 0, spread.chain(ends)) {
            std::fs::write(&path, &whole[..keep]).unwrap();
            let report = verify(&small(formats), &path, &Silent).unwrap();
            assert_eq!(report.verdict, Verdict::Fail, "{keep} of {length} bytes");
            reason_of(&report.reasons, &[name, ": ", ": "]);
        }
    }
}

/// The STL with every corner at `from` moved to `to`.
fn moved(mut bytes: Vec<u8>, from: DVec3, to: DVec3) -> Vec<u8> {
    let there: Vec<usize> = (0..count(&bytes)).filter_map(|t| corner_at(&bytes, t, from)).collect();
    assert!(!there.is_empty());
    for at in there {
        bytes[at..at + 12].copy_from_slice(&stl_bytes(to));
    }
    bytes
}

#[test]
fn a_moved_vertex_fails_where_no_ray_goes_and_no_facet_limit_is_set() {
    let bytes = whole(STL);
    let read = read_stl(&bytes).unwrap();
    let base = *read.mesh.vertices.iter().find(|v| v.z == 0.0 && v.x > 1.0).unwrap();
    let (_, inner) = inner(&read);
    let by_chord = small_but("formats = [\"stl\", \"obj\"]", STL);
    let by_chord = parsed(&by_chord.replace("facet_px = 3", ""));
    assert_eq!(by_chord.mesh.facet_px(), None);
    let folder = folder();
    let path = folder.path().join("moved.stl");
    for (from, to) in [
        (base, base - 0.05 * DVec3::Z),
        (base, base + 0.05 * DVec3::X.copysign(base)),
        (inner, inner + 0.05 * DVec3::Z),
    ] {
        std::fs::write(&path, moved(bytes.clone(), from, to)).unwrap();
        let report = verify(&by_chord, &path, &Silent).unwrap();
        assert!(report.trace[0].solid.check.is_solid());
        let single = to.as_vec3().as_dvec3();
        assert_eq!(report.verdict, Verdict::Fail);
        reason_of(&report.reasons, &["the vertex ", &place(single), " mm off the designed part"]);
    }
    std::fs::write(&path, &bytes).unwrap();
    assert_eq!(verify(&by_chord, &path, &Silent).unwrap().verdict, Verdict::Pass);
}

#[test]
fn a_changed_byte_that_no_one_reads_is_noticed() {
    let report = damaged(STL, |mut bytes| {
        bytes[70] ^= 1;
        bytes
    });
    let [reason] = &report.reasons[..] else { panic!("{:?}", report.reasons) };
    assert_eq!(*reason, Reason::from(FileFault::Altered).of_file("mirror.stl"));
}

#[test]
fn verify_tells_whole_files_from_damaged_and_unreadable_ones() {
    let folder = folder();
    let home = folder.path();
    save(home, SMALL);
    let (code, _, err) = told(&morion(home, &["build", "small.toml", "--quiet"]));
    assert_eq!(code, 0, "{err}");
    let verify = |file: &str| {
        let arguments = ["verify", file, "--profile", "small.toml", "--quiet"];
        told(&command(home).args(arguments).output().unwrap())
    };
    for whole in ["out/small/mirror.stl", "out/small/mirror.obj"] {
        let (code, out, err) = verify(whole);
        assert_eq!((code, &*err), (0, ""), "{out}");
        assert!(out.contains(whole) && out.ends_with("verdict  pass\n"), "{out}");
    }

    let stl = std::fs::read(home.join("out/small/mirror.stl")).unwrap();
    let (t, _) = inner(&read_stl(&stl).unwrap());
    std::fs::write(home.join("hole.stl"), without_facet(stl.clone(), t)).unwrap();
    std::fs::write(home.join("lifted.STL"), lifted(stl.clone(), usize::MAX)).unwrap();
    std::fs::write(home.join("short.stl"), &stl[..stl.len() - 9]).unwrap();
    std::fs::write(home.join("mesh.stp"), &stl).unwrap();
    let promised = format!("which take {} bytes, but it has {}", stl.len(), stl.len() - 9);
    for (file, why) in [
        ("hole.stl", "- hole.stl: open: only facet "),
        ("short.stl", &*promised),
        ("lifted.STL", " px, over the 3 px of mesh.facet_px"),
        ("mesh.stp", "- mesh.stp: line 1: "),
    ] {
        let (code, out, err) = verify(file);
        assert_eq!((code, &*err), (1, ""), "{out}");
        assert!(out.contains(why) && out.ends_with("verdict  fail\n"), "{out}");
    }

    std::fs::write(home.join("mirror.igs"), &stl).unwrap();
    for (file, why) in [
        (
            "mirror.igs",
            "the name must end in .step, .stp, .csv, .xyz, .txt, .asc, .ply, .stl, .obj, .3mf or .glb",
        ),
        ("nowhere.stl", "cannot read nowhere.stl"),
    ] {
        let (code, out, err) = verify(file);
        assert_eq!((code, &*out), (2, ""), "{err}");
        assert!(err.starts_with("error: ") && err.contains(file) && err.contains(why), "{err}");
    }
}

#[test]
fn errors_that_are_not_finite_fail_without_any_limit_on_them() {
    // Of degree 1 the sheet is a plane, which shows the zenith: infinitely far from any strip.
    let text = SMALL[..SMALL.find("[accept]").unwrap()]
        .replace("[layout.conquistador]\npanel = \"refit\"\nridge = \"crest\"", "[layout.strip]")
        .replace("fill_frame = true", "")
        .replace("degree = 8", "degree = 1")
        .replace("facet_px = 3", "")
        .replace("formats = [\"stl\", \"obj\"]", STL);
    let report = build(&parsed(&text), folder().path(), &Silent).unwrap();
    reason(&report, &["largest pixel error is not finite"]);
}
