//! Frames of any size: memory does not grow with the number of pixels.

use crate::builds::{SMALL, edited, folder, save};
use crate::needs::Needs;
use serde_json::Value;

/// Most memory of a build with any frame, kB, where the mesh is small.
const MOST_KB: u64 = 400_000;

/// The report of a build of a small mirror with a frame of so many pixels, columns and rows of its
/// `preview.png`, and what the build took.
fn built(pixels: [u32; 2]) -> (Value, [u32; 2], Needs) {
    let folder = folder();
    let [columns, rows] = pixels;
    let text = edited(
        SMALL,
        &[
            ("pixels = [160, 120]", &format!("pixels = [{columns}, {rows}]")),
            // As few facets as with the small frame.
            ("facet_px = 3", &format!("facet_px = {}", 3 * columns / 160)),
        ],
    );
    let profile = save(folder.path(), &text);
    let arguments = ["build", profile.to_str().unwrap(), "--quiet"];
    let ((code, out, err), needs) = Needs::to_run(folder.path(), &arguments);
    assert!(code < 2, "{out}{err}");
    let made = folder.path().join("out").join(profile.file_stem().unwrap());
    let read = |name: &str| std::fs::read(made.join(name)).unwrap();
    let png = read("preview.png");
    let size = |at: usize| u32::from_be_bytes(png[at..at + 4].try_into().unwrap());
    (serde_json::from_slice(&read("report.json")).unwrap(), [size(16), size(20)], needs)
}

#[test]
fn a_frame_of_twelve_megapixels_takes_little_memory() {
    let (report, preview, needs) = built([4056, 3040]);
    assert!(needs.memory_kb <= MOST_KB, "{needs:?}");
    assert_eq!(report["frame"]["pixels"], serde_json::json!([4056, 3040]));
    assert_eq!(report["trace"][0]["rays"], 4056 * 3040);
    assert_eq!(preview, [1600, 1200]);
}

/// 300 megapixels: as many as the sensor of a scanner has.
#[test]
#[ignore = "takes minutes"]
fn a_frame_of_300_megapixels_takes_little_more() {
    let (report, preview, needs) = built([20_000, 15_000]);
    assert!(needs.memory_kb <= 500_000, "{needs:?}");
    assert_eq!(report["trace"][0]["rays"], 300_000_000);
    assert_eq!(preview, [1600, 1200]);
}
