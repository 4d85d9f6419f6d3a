//! Programs of numerical control.

use morion::internals::geom::{Cutter, DVec2};
use morion::internals::program::{
    SweptCutter, ToolMove, ToolPath, TurnedSlopes, TurnedSurface, TurningPath,
};

/// Moves of which the surface is compared with a search among all of them.
const MOST: usize = 500;

/// Most turns of which the section is looked at.
const MOST_TURNS: f64 = 2000.0;

pub fn holds(bytes: &[u8]) {
    turned(bytes);
    let path = match ToolPath::read(bytes) {
        Ok(path) => path,
        Err(error) => {
            let said = error.to_string();
            assert!(!said.chars().any(char::is_control), "{said:?}");
            return;
        }
    };
    let is_finite = |step: &ToolMove| step.from.is_finite() && step.to.is_finite();
    assert!(path.moves.iter().all(is_finite));
    assert!(path.moves.iter().all(|step| step.feed.is_none_or(|feed| feed > 0.0)));
    assert!(path.moves.windows(2).all(|pair| pair[0].line <= pair[1].line));
    assert!(path.moves.iter().all(|step| (1..=path.lines).contains(&step.line)));
    let moves = &path.moves[..path.moves.len().min(MOST)];
    let plain = again(moves);
    // (Numbers next to nothing take hundreds of digits.)
    if !plain.is_empty() && plain.lines().all(|line| line.len() <= 255) {
        let ends = |moves: &[ToolMove]| -> Vec<_> {
            let cuts = moves.iter().filter(|step| step.feed.is_some());
            cuts.map(|step| (step.from, step.to)).collect()
        };
        let read = ToolPath::read(plain.as_bytes()).expect("moves that were read");
        assert_eq!(ends(&read.moves), ends(moves));
    }
    for corner_mm in [2.0, 0.5, 0.0] {
        let cutter = Cutter { radius_mm: 2.0, corner_mm };
        let corners = [DVec2::splat(-10.0), DVec2::splat(10.0)];
        let swept = SweptCutter::new(moves, cutter, corners);
        for k in 0..64 {
            let at = DVec2::new(f64::from(k % 8), f64::from(k / 8)) * 2.5 - 9.0;
            let of = |step: usize| swept.of_step(step, at).map(|(z, _)| z);
            let least = (0..moves.len()).filter_map(of).reduce(f64::min);
            let found = swept.lowest(at).map(|found| found.z_mm);
            // (Places of cutters with a flat end are found by Newton's method.)
            let off = found.zip(least).map_or(0.0, |(a, b)| (a - b).abs());
            let rounding =
                if corner_mm == 2.0 { 0.0 } else { 1e-9 * (1.0 + least.unwrap_or(0.0).abs()) };
            assert!(
                found.is_some() == least.is_some() && off <= rounding,
                "{at}: {found:?} {least:?}"
            );
        }
    }
}

/// As the program of a lathe, and as a table of points: turns are those of feed moves, and the cusps of a section rise.
fn turned(bytes: &[u8]) {
    for path in [TurningPath::read(bytes), TurningPath::read_table(bytes)].into_iter().flatten() {
        sections(&path);
    }
}

fn sections(path: &TurningPath) {
    assert_eq!(path.tool.moves.len(), path.turns.len());
    let steps = || path.tool.moves.iter().zip(&path.turns);
    assert!(steps().all(|(step, turns)| turns.is_finite() && step.to.y == 0.0));
    assert!(path.is_commanded() || steps().all(|(_, turns)| *turns >= 0.0));
    assert!(!path.is_commanded() || path.commanded.len() == path.turns.len());
    assert!(path.axis_rates().acceleration.most >= 0.0);
    assert!(steps().all(|(step, turns)| step.feed.is_some() || *turns == 0.0));
    let surface = TurnedSurface::new(path, 2.0);
    if surface.turns() > MOST_TURNS {
        return;
    }
    let section = surface.section(0.0);
    let cusps: Vec<f64> = section.cusps().collect();
    assert!(cusps.windows(2).all(|pair| pair[0] < pair[1]), "{cusps:?}");
    assert!(cusps.iter().all(|at| section.lowest(*at).is_none_or(|place| place.z_mm.is_finite())));
    for k in 0..32 {
        let at = 0.37 * f64::from(k);
        let [cut, plain] = [section.lowest(at), section.without_cusps(at)];
        // Without cusps a section is nowhere higher.
        assert!(cut.is_some() == plain.is_some());
        assert!(cut.zip(plain).is_none_or(|(cut, plain)| plain.z_mm <= cut.z_mm), "{at}");
    }
    let slopes = TurnedSlopes::new(surface);
    for k in 0..64 {
        let at = DVec2::new(f64::from(k % 8), f64::from(k / 8)) * 2.5 - 9.0;
        assert!(slopes.slope_over(at).is_none_or(|slope| slope.is_finite()), "{at}");
    }
}

/// The same cuts, each from where it begins, in plain words.
fn again(moves: &[ToolMove]) -> String {
    let line = |step: &ToolMove| {
        let (from, to) = (step.from, step.to);
        let feed = step.feed?;
        Some(format!(
            "G0 X{} Y{} Z{}\nG1 X{} Y{} Z{} F{feed}\n",
            from.x, from.y, from.z, to.x, to.y, to.z
        ))
    };
    moves.iter().filter_map(line).collect()
}
