//! Blind holes below a mirror: the material that they leave under it and beside its walls.

use super::DesignError;
use crate::geom::{BlindHole, Border, DVec2, DVec3, HoleKind, HoleMeridian, Outline, PlanPolygon};
use crate::mirror::Mirror;
use crate::profile::{BorderFeature, BorderSpec, HoleSpec, Profile, under_rim};

/// Steps along each side of the outline, which is curved under a pinhole: finer than a mesh's.
const STEPS: usize = 1024;
/// Places along each side of the first grid among which the thinnest one is searched.
const GRID: usize = 33;
/// Places along each side of the finer grids, and how many there are: each is half as wide, 1e-6 of the first in the end.
const FINER: usize = 9;
const ROUNDS: usize = 20;
/// Halvings of an interval of depths: to a millionth of it.
const HALVINGS: usize = 20;
/// Digits of a depth in a remedy: a micrometre.
const PER_MM: f64 = 1e3;

/// The blind holes that the profile wants below `mirror`, which reaches up to `top_mm`.
///
/// # Errors
/// [`DesignError::Border`] when one leaves less than [`HoleSpec::LEAST_WALL_MM`] under the mirror or the flat rim, or
/// less than [`BorderSpec::CLEAR_MM`] beside it.
pub(super) fn below(
    profile: &Profile,
    mirror: &Mirror,
    border: Option<&Border>,
    top_mm: f64,
) -> Result<Vec<BlindHole>, DesignError> {
    let specs: Vec<(usize, &HoleSpec, BlindHole)> = profile
        .part
        .holes
        .iter()
        .enumerate()
        .filter_map(|(k, spec)| Some((k, spec, spec.blind()?)))
        .collect();
    if specs.is_empty() {
        return Ok(Vec::new());
    }
    let above = Above { mirror, heights_mm: [profile.part.base_mm, top_mm] };
    let rim = above.rim();
    for (k, spec, hole) in &specs {
        let foot = footprint(mirror, &rim, border.map_or(0.0, |border| border.top_mm));
        let inset = foot.inset(hole.hole.at) - hole.hole.mouth_radius();
        match border {
            Some(border) if inset < HoleSpec::LEAST_WALL_MM => {
                let conflict = under_rim(border.top_mm, BorderFeature::Drilling(*k), hole);
                if let Some(conflict) = conflict {
                    return Err(DesignError::Border {
                        message: conflict.message,
                        hint: conflict.hint,
                    });
                }
            }
            Some(_) => {}
            None => beside(&foot, &footprint(mirror, &rim, hole.tip_mm()), hole)?,
        }
        let wall = above.wall(&hole.meridian(), 0.0);
        if !(wall >= HoleSpec::LEAST_WALL_MM - BorderSpec::ROUNDING_MM) {
            return Err(above.refusal(spec, hole, wall));
        }
    }
    Ok(specs.into_iter().map(|(_, _, hole)| hole).collect())
}

/// Whether a hole stays clear of the walls below the mirror's rim.
fn beside(foot: &PlanPolygon, higher: &PlanPolygon, hole: &BlindHole) -> Result<(), DesignError> {
    let at = hole.hole.at;
    let gap = foot.inset(at).min(higher.inset(at)) - hole.hole.mouth_radius();
    if gap >= BorderSpec::CLEAR_MM - BorderSpec::ROUNDING_MM {
        return Ok(());
    }
    Err(DesignError::Border {
        message: format!(
            "hole.at_mm must stay {} mm clear of the part's side, found [{}, {}] with a mouth {} mm wide, \
             which leaves {gap:.3} mm",
            BorderSpec::CLEAR_MM,
            at.x,
            at.y,
            2.0 * hole.hole.mouth_radius()
        ),
        hint: "move the hole inwards, make it smaller or put a flat rim around the mirror with \
               part.border_mm = 8"
            .to_owned(),
    })
}

/// What is above the base of a part.
struct Above<'a> {
    mirror: &'a Mirror,
    /// Least and largest Z of the mirror, mm.
    heights_mm: [f64; 2],
}

impl Above<'_> {
    /// Places along the mirror's outer rim, counter-clockwise, mm.
    fn rim(&self) -> Vec<DVec3> {
        let outer = self.mirror.full_outline().rims(STEPS).swap_remove(0);
        outer.into_iter().map(|q| self.on_mirror(q)).collect()
    }

    fn on_mirror(&self, q: DVec2) -> DVec3 {
        if self.mirror.has_steps() {
            return self.mirror.position_on(self.mirror.panel_of(q), q);
        }
        self.mirror.position(q, &self.mirror.at(q))
    }

    /// The mirror's point over a place of the chart, its rim's beyond it, or the land's inside a ring: a fan to the rim's
    /// mean height in the middle, which a flat land is too.
    fn surface(&self, q: DVec2) -> DVec3 {
        let outline = self.mirror.full_outline();
        if let Outline::Ring { inner, .. } = outline
            && q.length() < inner
        {
            let middle = DVec3::Z * self.mirror.rim_mm(inner);
            let share = q.length() / inner;
            let rim = self.on_mirror(q.try_normalize().unwrap_or(DVec2::X) * inner);
            return middle.lerp(rim, share);
        }
        self.on_mirror(outline.nearest(q))
    }

    /// Material between a hole and the mirror lifted by so much, mm; negative where the hole reaches through it. Thicker
    /// than [`HoleSpec::LEAST_WALL_MM`] it is not looked for.
    fn wall(&self, hole: &HoleMeridian, lifted_mm: f64) -> f64 {
        let reach = hole.mouth_radius() + 2.0 * HoleSpec::LEAST_WALL_MM;
        let bounds = self.mirror.full_outline().bounds();
        let (mut min, mut max) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for corner in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            for z in self.heights_mm {
                let at = hole.axis + reach * DVec2::from(corner);
                let (q, _) = self.mirror.chart.coordinates(at.extend(z));
                (min, max) = (min.min(q), max.max(q));
            }
        }
        (min, max) = (min.max(bounds.min), max.min(bounds.max));
        if !(min.x <= max.x && min.y <= max.y) {
            return f64::INFINITY;
        }
        let thickness = |q: DVec2| hole.wall(self.surface(q) + DVec3::Z * lifted_mm);
        let (mut least, mut at) = thinnest(&thickness, min, max, GRID);
        let mut half = 2.0 * (max - min) / (GRID - 1) as f64;
        for _ in 0..ROUNDS {
            let (from, to) = ((at - half).max(bounds.min), (at + half).min(bounds.max));
            let (found, place) = thinnest(&thickness, from, to, FINER);
            if found < least {
                (least, at) = (found, place);
            }
            half *= 0.5;
        }
        least
    }

    /// The refusal of a hole that leaves so much, with the largest depth that leaves enough, or else the least base.
    fn refusal(&self, spec: &HoleSpec, hole: &BlindHole, wall: f64) -> DesignError {
        let (at, least) = (hole.hole.at, HoleSpec::LEAST_WALL_MM);
        let found = if wall > 0.0 {
            format!("found {wall:.3} mm")
        } else {
            format!("found it {:.3} mm too deep for any", -wall)
        };
        let message = format!(
            "the hole at [{}, {}] (line {} of the profile), whose ground is at Z {:.3} mm, must leave {least} mm \
             of material under the mirror, {found}",
            at.x,
            at.y,
            spec.place.0,
            hole.tip_mm()
        );
        let hint = match self.shallower(hole) {
            Some(depth) => match hole.hole.kind {
                HoleKind::Thread { size, depth_mm } => {
                    let usable = depth_mm.unwrap_or(f64::INFINITY).min(depth - size.overrun_mm());
                    let usable = (usable * PER_MM + 1e-6).floor() / PER_MM;
                    format!("set depth_mm = {depth} and thread_depth_mm = {usable}")
                }
                _ => format!("set depth_mm = {depth}"),
            },
            None => format!("set part.base_mm = {}", self.thicker(hole)),
        };
        DesignError::Border { message, hint }
    }

    /// The largest depth with which the hole leaves enough, if there is one that is of use.
    fn shallower(&self, hole: &BlindHole) -> Option<f64> {
        let least = match hole.hole.kind {
            HoleKind::Thread { size, .. } => size.overrun_mm() + size.pitch_mm(),
            _ => hole.hole.mouth_depth_mm() + BorderSpec::CLEAR_MM,
        };
        let fits = |depth_mm: f64| {
            let tried = BlindHole { depth_mm, ..*hole };
            self.wall(&tried.meridian(), 0.0) >= HoleSpec::LEAST_WALL_MM
        };
        let (mut low, mut high) = (least, hole.depth_mm);
        if !(low < high && fits(low)) {
            return None;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if fits(middle) { low = middle } else { high = middle }
        }
        let depth = (low * PER_MM).floor() / PER_MM;
        (depth >= least).then_some(depth)
    }

    /// The least base with which the hole leaves enough, mm.
    fn thicker(&self, hole: &BlindHole) -> f64 {
        let base = self.heights_mm[0];
        let meridian = hole.meridian();
        let (mut low, mut high) = (0.0, hole.tip_mm() + HoleSpec::LEAST_WALL_MM);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            let fits = self.wall(&meridian, middle) >= HoleSpec::LEAST_WALL_MM;
            if fits { high = middle } else { low = middle }
        }
        ((base + high) * PER_MM).ceil() / PER_MM
    }
}

/// The least of a function among the places of a grid, and where it is.
fn thinnest(
    thickness: &dyn Fn(DVec2) -> f64,
    min: DVec2,
    max: DVec2,
    count: usize,
) -> (f64, DVec2) {
    let share = |k: usize| k as f64 / (count - 1) as f64;
    let mut best = (f64::INFINITY, min);
    for row in 0..count {
        for column in 0..count {
            let q = min + (max - min) * DVec2::new(share(column), share(row));
            let found = thickness(q);
            if found < best.0 {
                best = (found, q);
            }
        }
    }
    best
}

/// The outline, in the plan, of the walls below a mirror at the height `z_mm`: they are upright, or lie along the rays of the
/// pinhole where there are steps.
fn footprint(mirror: &Mirror, rim: &[DVec3], z_mm: f64) -> PlanPolygon {
    let place = |p: &DVec3| {
        if mirror.has_steps() { mirror.chart.passing(*p, z_mm) } else { p.truncate() }
    };
    PlanPolygon(rim.iter().map(place).collect())
}
