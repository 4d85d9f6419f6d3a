//! Tables: heights on a grid (a given mirror, or a measured form error) and the sag table.

use morion::internals::design::design;
use morion::internals::export::read_sag;
use morion::internals::pipeline::{Silent, dry_run};
use morion::internals::profile::{Profile, SagGrid};
use std::sync::LazyLock;

/// A mirror of the grid's heights, of which it uses the middle.
static PROFILE: LazyLock<Profile> = LazyLock::new(|| {
    let text = "\
camera.orthographic.pixels = [16, 12]
mirror.grid.file = \"sag.csv\"
part = { width_mm = 3, height_mm = 3, base_mm = 5 }
mesh.chord_um = 5
export.formats = [\"stl\"]
";
    Profile::parse("grid", "grid.toml", text.as_bytes()).expect("a valid profile")
});

pub fn holds(bytes: &[u8]) {
    if let Ok(rows) = read_sag(bytes) {
        let line = |row: &morion::internals::export::SagRow| {
            let ([x, y, z], [a, b, c]) = (row.at.to_array(), row.normal.to_array());
            format!("{x},{y},{z},{a},{b},{c}\n")
        };
        let again: String = rows.iter().map(line).collect();
        assert_eq!(read_sag(again.as_bytes()).expect("rows that were read"), rows);
    }
    let Ok(grid) = SagGrid::parse(bytes) else { return };
    is_sound(&grid);
    let mut lines = Vec::new();
    for (j, row) in grid.z_mm.chunks(grid.x.count).enumerate() {
        for (i, z) in row.iter().enumerate() {
            lines.push(format!("{},{},{z}\n", grid.x.at(i), grid.y.at(j)));
        }
    }
    // In any order.
    lines.reverse();
    let again = SagGrid::parse(lines.concat().as_bytes()).expect("a grid that was read");
    assert_eq!((again.x.count, again.y.count), (grid.x.count, grid.y.count));
    assert_eq!(again.z_mm, grid.z_mm);

    // Deep pits take a million facets, and their time.
    let is_shallow = grid.z_mm.iter().all(|z| z.abs() <= 10.0);
    let source = Profile { heights: Some(grid), ..PROFILE.clone() };
    if design(&source).is_ok() && is_shallow {
        // Foreseen or refused.
        let _ = dry_run(&source, &Silent);
    }
}

fn is_sound(grid: &SagGrid) {
    assert_eq!(grid.z_mm.len(), grid.x.count * grid.y.count);
    assert!(grid.z_mm.iter().all(|z| z.is_finite()));
    for axis in [&grid.x, &grid.y] {
        assert!(axis.count >= 4 && axis.step_mm > 0.0, "{axis:?}");
        assert!(axis.first_mm.is_finite() && axis.last_mm().is_finite(), "{axis:?}");
    }
}
