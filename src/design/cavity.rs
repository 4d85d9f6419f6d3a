//! The cavity that a profile asks for under its mirror.

use super::DesignError;
use crate::geom::{
    BlindHole, CavityFloor, DVec2, DVec3, Drilled, Hole, HoleMeridian, Outline, PlanPolygon, Rect,
};
use crate::mirror::{Mirror, SurfaceSamples};
use crate::profile::{BorderSpec, Profile, ShellSpec};

/// Steps along each side of the outlines whose distance is measured.
const STEPS: usize = 256;
/// Rounds of moving the walls inwards, and the share of the thickness within which they end.
const ROUNDS: usize = 20;
const CLOSE: f64 = 1e-6;
/// Height of the roof's facets off its surface, as a share of the walls' thickness.
const CHORD: f64 = 0.01;
/// A remedy is told in so many parts of a millimetre.
const PER_MM: f64 = 100.0;

/// The room inside a hollow part: a roof below the mirror, upright walls and a plane floor.
#[derive(Debug, Clone)]
pub struct Cavity {
    /// The roof: the mirror moved down, within walls.
    pub roof: Mirror,
    /// What it is moved by, mm.
    pub drop_mm: f64,
    /// Least thickness of what is around it, mm.
    pub wall_mm: f64,
    /// The floor.
    pub floor: CavityFloor,
    /// Its volume with that of the drains, mm^3.
    pub volume_mm3: f64,
}

impl Cavity {
    /// Height that facets of its roof may be off the roof's surface, mm.
    #[must_use]
    pub fn chord_mm(&self) -> f64 {
        CHORD * self.wall_mm
    }

    /// What facets of the roof and chords of a round wall may change its volume by, mm^3.
    #[must_use]
    pub fn volume_tolerance_mm3(&self) -> f64 {
        let chord_mm = self.chord_mm();
        let area = self.roof.footprint(self.floor.z_mm);
        let walls = match self.roof.outline {
            // Chords that cut EDGE of the radius take 4/3 of that share of the disc.
            Outline::Ring { .. } => 4.0 / 3.0 * Outline::EDGE * self.volume_mm3,
            Outline::Rect(_) => 0.0,
        };
        // (Under a pinhole walls are curved, and follow the roof's edge.)
        area * chord_mm + walls
    }
}

/// The cavity under `mirror`, whose lowest place is at `profile.part.base_mm`.
///
/// # Errors
/// [`DesignError::Border`] where there is no room for it, or for a drain or a blind hole beside it.
pub(super) fn below(
    profile: &Profile,
    mirror: &Mirror,
    blind: &[BlindHole],
    has_land_holes: bool,
) -> Result<Option<Cavity>, DesignError> {
    let Some(shell) = &profile.part.shell else { return Ok(None) };
    let refuse = |message: String, hint: String| Err(DesignError::Border { message, hint });
    let wall_mm = shell.wall_mm;
    if has_land_holes {
        let message = "part.shell_mm must go with a land without holes, found holes in it".into();
        return refuse(message, "leave shell_mm out, or drill in the flat rim alone".into());
    }
    let (steepest, _) = SurfaceSamples::new(mirror).largest(|place| place.slope.length());
    // Two graphs over the plan that are apart by d along Z are apart by d / sqrt(1 + p^2) at least, if p is their largest
    // slope.
    let drop_mm = (1.0 + CHORD) * wall_mm * f64::sqrt(1.0 + steepest * steepest);
    let base_mm = profile.part.base_mm;
    let least_mm = wall_mm + drop_mm + ShellSpec::LEAST_HEIGHT_MM;
    if !(base_mm >= least_mm) {
        let enough = (least_mm * PER_MM).ceil() / PER_MM;
        return refuse(
            format!(
                "part.shell_mm = {wall_mm} must leave a cavity {} mm high over base_mm = {base_mm}, of which floor and roof \
                 take {:.3}",
                ShellSpec::LEAST_HEIGHT_MM,
                wall_mm + drop_mm
            ),
            format!("set base_mm = {enough}"),
        );
    }
    let Some(outline) = within(mirror, wall_mm) else {
        let hint = "make the walls thinner or the mirror wider, or leave shell_mm out".into();
        return refuse(
            format!("part.shell_mm must leave room for a cavity, found {wall_mm}"),
            hint,
        );
    };
    let mut roof = Mirror { outline, ..mirror.clone() };
    roof.chart.plane_mm -= drop_mm;
    let foot = foot(&roof);
    for hole in blind {
        let meridian = hole.meridian();
        let at = meridian.axis;
        if foot.inset(at) > -(meridian.mouth_radius() + wall_mm) {
            let message = format!(
                "part.shell_mm must stay clear of blind holes, found one at [{}, {}] under the cavity",
                at.x, at.y
            );
            let hint = "drill blind holes in a flat rim, part.border_mm, or leave shell_mm out";
            return refuse(message, hint.into());
        }
    }
    let drains = match &shell.drains {
        Some(drains) => drains.clone(),
        None => usual_drains(&foot),
    };
    drained(&foot, &drains)?;
    let drains = drains.iter().map(|drain| Hole::plain(drain.at, drain.diameter_mm)).collect();
    let floor = CavityFloor { z_mm: wall_mm, drains };
    let drained_mm3: f64 = floor.meridians().map(|drain: HoleMeridian| drain.volume()).sum();
    let volume_mm3 = roof.volume() - wall_mm * roof.footprint(wall_mm) + drained_mm3;
    Ok(Some(Cavity { roof, drop_mm, wall_mm, floor, volume_mm3 }))
}

/// The outline of the cavity: so far within the mirror's, in the plan, that upright walls of this thickness are left.
fn within(mirror: &Mirror, wall_mm: f64) -> Option<Outline> {
    let outer = foot(mirror);
    let [chart, plan] =
        [mirror.full_outline().bounds(), outer.bounds()].map(|b| b.size().max_element());
    let wanted = wall_mm * (1.0 + CLOSE);
    let mut inset = wanted * chart / plan;
    for _ in 0..ROUNDS {
        let outline = shrunk(mirror, inset)?;
        let inner = foot(&Mirror { outline, ..mirror.clone() });
        let found = inner.0.iter().map(|p| outer.inset(*p)).fold(f64::INFINITY, f64::min);
        if (found - wanted).abs() <= CLOSE * wall_mm {
            return Some(outline);
        }
        if !(found > 0.0) {
            return None;
        }
        inset *= wanted / found;
    }
    None
}

/// The mirror's outline without a strip of this width along its outer rim; of a folded mirror that of its designed panel.
fn shrunk(mirror: &Mirror, inset: f64) -> Option<Outline> {
    match mirror.outline {
        Outline::Ring { inner, outer } => {
            (outer - inset > inner).then_some(Outline::Ring { inner, outer: outer - inset })
        }
        Outline::Rect(Rect { mut min, mut max }) => {
            (min.x, max.x) = (min.x + inset, max.x - inset);
            // A folded mirror's ridge stays where it is.
            let is_upper = mirror.outline.bounds().centre().y > 0.0;
            if !mirror.folded || !is_upper {
                min.y += inset;
            }
            if !mirror.folded || is_upper {
                max.y -= inset;
            }
            (min.x < max.x && min.y < max.y).then_some(Outline::Rect(Rect { min, max }))
        }
    }
}

/// The outer rim of `mirror` in the plan.
fn foot(mirror: &Mirror) -> PlanPolygon {
    let rim = mirror.full_outline().rims(STEPS).swap_remove(0);
    let at = |q: DVec2| -> DVec3 { mirror.position(q, &mirror.at(q)) };
    PlanPolygon(rim.into_iter().map(|q| at(q).truncate()).collect())
}

/// Two drains at the ends of a cavity's longer side, where the last of what is inside gathers when the part is tilted.
fn usual_drains(foot: &PlanPolygon) -> Vec<Drilled> {
    let diameter_mm = ShellSpec::USUAL_DRAIN_MM;
    let Rect { min, max } = foot.bounds();
    let beside = 0.5 * diameter_mm + 1.0;
    let size = max - min;
    let middle = 0.5 * (min + max);
    let way = if size.x >= size.y { DVec2::X } else { DVec2::Y };
    let reach = 0.5 * size.dot(way) - beside;
    let at = |side: f64| Drilled { at: middle + side * reach * way, diameter_mm };
    vec![at(-1.0), at(1.0)]
}

/// Whether drains lead into a cavity with this foot, and are apart from each other.
fn drained(foot: &PlanPolygon, drains: &[Drilled]) -> Result<(), DesignError> {
    let clear = BorderSpec::CLEAR_MM - BorderSpec::ROUNDING_MM;
    for (k, drain) in drains.iter().enumerate() {
        let (at, radius) = (drain.at, drain.radius());
        let apart = |other: &Drilled| at.distance(other.at) - radius - other.radius();
        let beside = drains[..k].iter().map(apart).fold(f64::INFINITY, f64::min);
        let inside = foot.inset(at) - radius;
        if inside.min(beside) >= clear {
            continue;
        }
        let what = if inside < clear { "the cavity's walls" } else { "each other" };
        let Rect { min, max } = foot.bounds();
        return Err(DesignError::Border {
            message: format!(
                "part.drains_mm must stay {} mm clear of {what}, found [{:.6}, {:.6}, {}]",
                BorderSpec::CLEAR_MM,
                at.x,
                at.y,
                drain.diameter_mm
            ),
            hint: format!(
                "the cavity is from X = {:.3} to {:.3} mm and from Y = {:.3} to {:.3} mm; give places and diameters \
                 within, as in drains_mm = [[{:.3}, {:.3}, {:.3}]]",
                min.x,
                max.x,
                min.y,
                max.y,
                0.5 * (min.x + max.x),
                0.5 * (min.y + max.y),
                0.25 * (max - min).min_element()
            ),
        });
    }
    Ok(())
}
