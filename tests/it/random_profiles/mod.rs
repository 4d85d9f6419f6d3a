//! Random valid profiles, over all that a profile may say: each ends in files that pass every check,
//! or in a refusal or a verdict that says why.

pub mod wanted;

use crate::support::builds::folder;
use crate::support::random::each;
use crate::support::{times, unlimited};
use morion::internals::pipeline::{Command, Error, Silent, ToleranceOptions, build, dry_run, load};
use morion::internals::profile::{Profile, SagGrid};
use morion::internals::results::ReasonKind::{self, NotWritten, Picture, Rays};
use morion::internals::results::{
    BuildReport, FileFault, PictureFault, RayFault, Refusal, RefusalCause, Verdict,
};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestCaseError, TestRng, TestRunner};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Mutex;
use std::time::{Duration, Instant};
use wanted::Wanted;

/// What takes longer is shown.
const SLOW: Duration = Duration::from_secs(5);

/// Profiles that are made by one stream of random numbers.
const STREAM: usize = 10;

// How a profile may end.
const INVALID: &str = "invalid";
const PASSED: &str = "passed";
const FAILED: &str = "failed by its own limits or its shape";
const NO_DESIGN: &str = "no design";

/// A kind of reason that is the profile's, and no fault of the mesh or the files: what is asked of the
/// mirror, or rays that no mirror of this shape can help.
struct Pardoned {
    name: &'static str,
    is: fn(&ReasonKind) -> bool,
    /// The largest share of the profiles that may end so: about twice what sixty show, while a fifth of
    /// ten thousand failed in all.
    share: f64,
}

macro_rules! pardoned {
    ($($name:literal, $kind:pat, $share:literal;)*) => {
        [$(Pardoned { name: $name, is: |kind| matches!(kind, $kind), share: $share }),*]
    };
}

static PARDONED: [Pardoned; 8] = pardoned! {
    "shadowed", Rays(RayFault::Shadowed { .. }), 0.15;
    "pixel error", Picture(PictureFault::PixelError { .. }), 0.1;
    "frame filled", Picture(PictureFault::FrameFilled { .. }), 0.1;
    "not finite", Picture(PictureFault::NotFinite { .. }), 0.05;
    "nothing aimed", Rays(RayFault::NothingAimed), 0.2;
    "empty table", ReasonKind::File(FileFault::EmptyTable), 0.05;
    "single precision", NotWritten(Refusal { cause: RefusalCause::SinglePrecision, .. }), 0.05;
    "no mesh", NotWritten(Refusal { cause: RefusalCause::NoMesh, .. }), 0.1;
};

/// How often each ending, and each kind of pardoned reason, was seen.
#[derive(Debug, Default)]
struct Endings {
    words: BTreeMap<&'static str, usize>,
    kinds: BTreeMap<&'static str, usize>,
}

/// How one profile ended: in a word, and by which pardoned reasons.
type Ending = (&'static str, BTreeSet<&'static str>);

/// How a profile ended, in a word.
fn ended(wanted: &Wanted, folder: &Path) -> Result<Ending, String> {
    let Ok(profile) = Profile::parse("random", "random.toml", wanted.text.as_bytes()) else {
        return Ok((INVALID, BTreeSet::new()));
    };
    let heights = wanted.heights.as_ref().map(|text| SagGrid::parse(text.as_bytes()));
    let heights = heights.transpose().map_err(|error| error.to_string())?;
    // What is usual is no business of random mirrors.
    let source = Profile { heights, ..unlimited(profile) };
    let ending = match build(&source, folder, &Silent) {
        Ok(report) => judged(&source, &report, &folder.join("random"))?,
        Err(error) => (refusal(&error)?, BTreeSet::new()),
    };
    if wanted.toleranced {
        let path = folder.join("random.toml");
        let heights = wanted.heights.as_deref().unwrap_or("");
        std::fs::write(folder.join("sag.csv"), heights).map_err(|error| error.to_string())?;
        std::fs::write(&path, &wanted.text).map_err(|error| error.to_string())?;
        let trials = ToleranceOptions { range: 0..3, ..ToleranceOptions::default() };
        let source = load(&path.display().to_string()).map_err(|error| error.to_string())?;
        if let Err(error) = trials.publish(&source, folder, &Silent) {
            refusal(&error)?;
        }
    }
    Ok(ending)
}

/// A build that came to an end: the files are there as the report has them, and what is wrong with
/// them is pardoned.
fn judged(profile: &Profile, report: &BuildReport, folder: &Path) -> Result<Ending, String> {
    for file in &report.files {
        let length = folder.join(&file.name).metadata().map_err(|error| error.to_string())?.len();
        if length != file.bytes {
            return Err(format!("{} has {length} bytes, not {}", file.name, file.bytes));
        }
    }
    for trace in &report.trace {
        if !trace.solid.check.is_solid() {
            return Err(format!("{}: {:?}", trace.file, trace.solid.check));
        }
    }
    if report.json().contains("NaN") {
        return Err("a report with NaN in it".into());
    }
    let mut kinds = BTreeSet::new();
    for reason in &report.reasons {
        match PARDONED.iter().find(|pardoned| (pardoned.is)(&reason.kind)) {
            Some(pardoned) => kinds.insert(pardoned.name),
            None => return Err(reason.to_string()),
        };
    }
    match report.verdict {
        Verdict::Pass if report.files.len() == profile.formats.len() => Ok((PASSED, kinds)),
        Verdict::Pass => Err(format!("passed with {} files", report.files.len())),
        Verdict::Fail if report.reasons.is_empty() => Err("failed without a reason".into()),
        Verdict::Fail => Ok((FAILED, kinds)),
    }
}

/// An error that a valid profile may end in, and that says something.
fn refusal(error: &Error) -> Result<&'static str, String> {
    let text = error.to_string();
    let kind = match error {
        Error::Design { .. } => NO_DESIGN,
        Error::Mesh { .. } => "no mesh",
        Error::Step { .. } => "no splines",
        Error::Table { .. } => "too long a table",
        Error::NoProjection { .. } | Error::Unseen { .. } | Error::Tracks { .. } => "no tolerances",
        _ => return Err(text),
    };
    if text.contains("NaN") || text.contains("inf ") || !text.contains(';') {
        return Err(format!("no clear refusal: {text}"));
    }
    Ok(kind)
}

#[test]
fn every_valid_profile_ends_in_sound_files_or_a_clear_refusal() {
    let count = times(20, 10_000);
    // Nothing here is to survive the loss of power.
    let memory = Path::new("/dev/shm");
    let place = if memory.is_dir() { memory.to_owned() } else { std::env::temp_dir() };
    let endings = Mutex::new(Endings::default());
    // Hours of work can be taken up again.
    let first = std::env::var("MORION_STREAM").map_or(0, |n| n.parse().expect("a number"));
    let streams: Vec<u64> = (first..count.div_ceil(STREAM) as u64).collect();
    let faults = each(&streams, |&stream| {
        let mut seed = [0; 32];
        seed[..8].copy_from_slice(&stream.to_le_bytes());
        let config = Config {
            cases: STREAM as u32,
            failure_persistence: None,
            max_global_rejects: 100_000,
            max_shrink_iters: 300,
            max_shrink_time: 20_000,
            ..Config::default()
        };
        let mut runner =
            TestRunner::new_with_rng(config, TestRng::from_seed(RngAlgorithm::ChaCha, &seed));
        let found = runner.run(&wanted::strategy(), |wanted| {
            let folder = tempfile::tempdir_in(&place).expect("a temporary folder");
            let begun = Instant::now();
            let (word, kinds) = ended(&wanted, folder.path()).map_err(TestCaseError::fail)?;
            if begun.elapsed() > SLOW {
                println!("{word} after {:?}: {wanted:?}", begun.elapsed());
            }
            let mut endings = endings.lock().expect("no panic");
            *endings.words.entry(word).or_default() += 1;
            for kind in kinds {
                *endings.kinds.entry(kind).or_default() += 1;
            }
            prop_assume!(word != INVALID);
            Ok(())
        });
        let fault = found.err().map(|error| format!("stream {stream}: {error}"));
        println!(
            "{}",
            fault.as_deref().map_or(format!("stream {stream} ended well"), str::to_owned)
        );
        fault
    });
    let endings = endings.into_inner().expect("no panic");
    println!("{endings:#?}");
    let faults: Vec<String> = faults.into_iter().flatten().collect();
    assert!(faults.is_empty(), "{} of {}:\n{}", faults.len(), streams.len(), faults.join("\n\n"));
    let ran = (streams.len() * STREAM) as f64;
    let share = |word: &str| endings.words.get(word).map_or(0.0, |n| *n as f64 / ran);
    assert!(share(PASSED) > 0.3 && share(NO_DESIGN) > 0.0, "{endings:?}");
    assert!(share(FAILED) > 0.01, "{endings:?}");
    for Pardoned { name, share: most, .. } in &PARDONED {
        let share = endings.kinds.get(name).map_or(0.0, |n| *n as f64 / ran);
        // Few profiles scatter by more than many.
        let scatter = 4.0 * (most * (1.0 - most) / ran).sqrt();
        assert!(share <= most + scatter, "{name} in {share} of the profiles: {endings:?}");
    }
}

/// Random profiles that once ended otherwise than they should have.
mod found {
    use super::*;

    fn ends(text: &str) -> &'static str {
        let wanted = Wanted { text: text.to_owned(), heights: None, toleranced: false };
        let folder = folder();
        ended(&wanted, folder.path()).unwrap_or_else(|fault| panic!("{fault}")).0
    }

    #[test]
    fn a_mirror_without_curvature_is_not_blamed_for_rounding() {
        // Of degree 1 each panel is a plane, and its chord error nothing.
        let text = "\
camera.orthographic = { pixels = [1, 1] }
projection.table = { azimuth_deg = [-180, 180], elevation_deg = [[0.1879, -29.5], [4.7681, -30.5]] }
layout.conquistador = { panel = \"refit\", ridge = \"crest\" }
method.vector-field = { degree = 1 }
[part]
width_mm = 5.882
base_mm = 1.881
border_mm = 0.3799
corner_radius_mm = 0.5417
[mesh]
chord_um = 18.06
[export]
formats = [\"obj\"]
";
        assert_eq!(ends(text), "passed");
    }

    #[test]
    fn a_skirt_below_an_edge_that_is_seen_obliquely_is_where_it_should_be() {
        // The edge turns back as seen from the part's axis.
        let text = "\
camera.orthographic = { pixels = [7, 2] }
mount = { fold_deg = -82.86, towards_deg = 41.36 }
projection.perspective = { hfov_deg = 40.95, centre_deg = [112.3, 11.3], target_radius_mm = 117.9 }
layout.rectangle = {}
method.fixed-surface = { degree = 7, minimax = false }
part = { width_mm = 35.57, base_mm = 0.96 }
mesh = { chord_um = 14.79, facet_px = 28.45 }
export.formats = [\"obj\", \"stl\"]
";
        assert_eq!(ends(text), "passed");
    }

    #[test]
    fn nor_for_what_single_precision_does_to_its_sides() {
        let text = "\
camera.orthographic = { pixels = [7, 1] }
projection.table = { azimuth_deg = [-2.441, 2.441], elevation_deg = [[1.104, 21.35], [5.616, 21.07], [10.933, 20.78], [13.762, 20.5], [14.2444, 20.21]] }
layout.strip = { fill_frame = false }
method.vector-field = { degree = 1, minimax = false }
[part]
width_mm = 1.568
base_mm = 1.497
border_mm = 0.3519
rim_mm = 1.177
marks_mm = [[-0.96, 0, 0.1]]
[mesh]
facet_px = 49.25
[export]
formats = [\"stl\", \"3mf\"]
";
        assert_eq!(ends(text), "passed");
    }

    /// The tip of its mark lies half a unit of the last digit off.
    #[test]
    fn nor_for_what_it_does_to_a_mark() {
        let text = "\
camera.orthographic = { pixels = [9, 1] }
projection.table = { azimuth_deg = [-4.42, 4.42], elevation_deg = [[1.104, 25.69], [5.616, 23.24], [10.933, 20.79], [13.762, 18.33], [14.2444, 15.88]] }
layout.strip = { fill_frame = false }
method.vector-field = { degree = 1 }
[part]
width_mm = 8.045
base_mm = 7.681
border_mm = 1.805
rim_mm = 6.039
marks_mm = [[-4.925, 0, 0.1337]]
[mesh]
facet_px = 49.25
[export]
formats = [\"obj\", \"stl\"]
";
        assert_eq!(ends(text), "passed");
    }

    /// The land's middle is as high as its rim is in the mean.
    #[test]
    fn nor_a_land_whose_rim_is_not_flat() {
        let text = "\
camera.orthographic = { pixels = [9, 9] }
layout.annulus.inner_width_mm = 0.3027
mirror.polynomial = { radius_mm = 0.55, conic = -1.869, terms = [[2, 0, -0.01888], [0, 0, -0.002055]] }
part = { width_mm = 1, base_mm = 0.3357 }
mesh.chord_um = 0.2
export.formats = [\"3mf\", \"stl\"]
";
        assert_eq!(ends(text), "passed");
    }

    /// Half-way up to the pinhole the views of the camera and of the table shrink unlike each other.
    #[test]
    fn a_table_of_a_mirror_near_its_pinhole_has_rows() {
        let text = "\
camera.pinhole = { pixels = [1, 1], focal_px = 0.15, distance_mm = 0.5 }
projection.best = { azimuth_deg = [-168.75, 168.75], elevation_deg = [24.72, 26.28] }
layout.strip = { fill_frame = false }
method.vector-field = { degree = 3, minimax = false }
part = { width_mm = 1, base_mm = 0.02067 }
mesh = { chord_um = 0.3704, facet_px = 19.08 }
[export]
formats = [\"step\", \"obj\", \"csv\"]
sag = { path = \"raster\", pitch_mm = 0.2556, step_mm = 0.1113 }
";
        assert_eq!(ends(text), "passed");
    }

    /// It is narrower than the table's lines lie apart, and its sides are bent.
    #[test]
    fn a_table_of_a_sliver_has_its_middle() {
        let text = "\
camera.pinhole = { pixels = [50, 14], focal_px = 205, distance_mm = 12.88 }
projection.equal-area = { azimuth_deg = [-180, 180], elevation_deg = [-17.25, -10.89] }
layout.strip = { fill_frame = false }
method.vector-field = { degree = 9, minimax = false }
part = { width_mm = 1, base_mm = 0.5001 }
mesh.facet_px = 9.369
[export]
formats = [\"obj\", \"csv\"]
sag = { path = \"raster\", pitch_mm = 0.06348, step_mm = 0.0397 }
";
        let folder = folder();
        let profile = Profile::parse("random", "random.toml", text.as_bytes()).unwrap();
        let report = build(&profile, folder.path(), &Silent).unwrap();
        assert!(report.sag.as_ref().is_some_and(|sag| sag.rows > 9), "{:?}", report.sag);
    }

    /// Two points of its packing fall on one place.
    #[test]
    #[ignore = "long: .ci/nightly"]
    fn a_crowded_packing_has_no_two_points_in_one_place() {
        let text = "\
camera.orthographic = { pixels = [14, 1] }
projection.table = { azimuth_deg = [-180, 180], elevation_deg = [[4.234, -9.567], [4.5791, -9.843], [4.693, -10.12], [13.332, -10.39], [21.335, -10.67]] }
layout.conquistador = { panel = \"refit\", ridge = \"valley\", fill_frame = false }
method.vector-field = { degree = 5, minimax = false }
part = { width_mm = 1.153, base_mm = 0.02368 }
mesh = { chord_um = 14.02, facet_px = 5.608 }
export.formats = [\"3mf\"]
";
        assert_eq!(ends(text), "no mesh");
    }

    /// Its cells shrink to nothing at the rim.
    #[test]
    fn a_rim_of_boundless_cells_is_refused() {
        let text = "\
camera.orthographic = { pixels = [5, 3] }
projection.cylinder = { inner_polar_deg = 23.91, outer_polar_deg = 88.07, target_plane_mm = 34.03 }
layout.annulus.inner_width_mm = 1.171
method.fixed-surface = { degree = 8, minimax = false }
part = { width_mm = 1.499, base_mm = 0.221 }
mesh.max_triangles = 105
export.formats = [\"stl\"]
";
        assert_eq!(ends(text), "no mesh");
    }

    /// Facets by the million, of which most fail and are split in vain.
    #[test]
    #[ignore = "long: .ci/nightly"]
    fn what_splitting_cannot_mend_is_refused_before_it_is_made() {
        for (pixels, method, table, part, limits, formats, said) in [
            (
                "[5, 21]",
                "fixed-surface = { degree = 8",
                "azimuth_deg = [-3.1375, 3.1375], elevation_deg = [[0.9258, -2], \
                 [20.7758, -2.204], [25.8758, -2.408], [27.3388, -2.613]], target_plane_mm = -35.76",
                "width_mm = 8.871, base_mm = 0.7925",
                "facet_px = 1.27",
                "\"3mf\"",
                "boundlessly smaller than elsewhere",
            ),
            (
                "[19, 14]",
                "distribution = { degree = 5",
                "azimuth_deg = [-180, 180], elevation_deg = [[3.113, -21.66], [9.295, -22.12], \
                 [9.8184, -22.58], [14.3644, -23.04], [14.7346, -23.5]], target_radius_mm = 1063",
                "width_mm = 201.4, base_mm = 19.8",
                "chord_um = 402, facet_px = 2.116",
                "\"stl\", \"obj\"",
                "over the 4e7 that fit in memory",
            ),
        ] {
            let text = format!(
                "camera.orthographic = {{ pixels = {pixels} }}\n\
                 projection.table = {{ {table} }}\n\
                 layout.strip = {{ fill_frame = false }}\n\
                 method.{method}, minimax = false }}\n\
                 part = {{ {part} }}\n\
                 mesh = {{ {limits} }}\n\
                 export.formats = [{formats}]\n"
            );
            let profile = Profile::parse("random", "random.toml", text.as_bytes()).unwrap();
            let error = dry_run(&profile, &Silent).unwrap_err();
            assert!(error.to_string().contains(said), "{error}");
        }
    }

    #[test]
    fn nor_a_plane_for_what_the_witness_rounds() {
        let text = "\
camera.orthographic = { pixels = [2, 5] }
projection.cylindrical = { azimuth_deg = [-76.85, 76.85], elevation_deg = [13.39, 22.81] }
layout.strip = { fill_frame = false }
method.fixed-surface = { degree = 1, minimax = false }
part = { width_mm = 1.123, base_mm = 0.1696 }
mesh.max_triangles = 1278
export.formats = [\"step\"]
";
        assert_eq!(ends(text), "passed");
    }

    /// The rim of its facets lies lower than its own, and rays aslant pass by.
    #[test]
    fn nor_a_given_mirror_for_rays_that_graze_its_rim() {
        let text = "\
camera.pinhole = { pixels = [11, 2], focal_px = 3.992, distance_mm = 0.5 }
mirror.polynomial = { radius_mm = -5.947, conic = -1.855 }
part = { width_mm = 1, base_mm = 0.04003, height_mm = 1.51 }
mesh.chord_um = 1.199
export.formats = [\"stl\"]
";
        assert_eq!(ends(text), "passed");
    }

    #[test]
    fn a_fit_that_runs_away_says_so_in_words() {
        let text = "\
camera.orthographic = { pixels = [1, 1] }
projection.table = { azimuth_deg = [-1.133, 1.133], elevation_deg = [[7.427, 25.43], [26.247, 25.07], [26.4209, 24.72], [27.0271, 24.36]], target_radius_mm = 1.096 }
layout.strip = { fill_frame = false }
method.fixed-surface = { degree = 2, minimax = false }
part = { width_mm = 1, base_mm = 0.5218 }
mesh.facet_px = 1.397
export.formats = [\"stl\"]
";
        assert_eq!(ends(text), "no design");
    }
}
