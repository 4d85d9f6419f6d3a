//! The forming tool that a profile asks for in the place of the part, and what is around its face.

use super::DesignError;
use crate::forming::FormingTool;
use crate::geom::{Border, DVec2, Drilled, Hole, Outline, Rect};
use crate::mirror::Mirror;
use crate::num::{cos, sin};
use crate::profile::{BorderSpec, HoleSpec, PartSpec, Profile, Vents};
use std::f64::consts::TAU;

/// The tool for `mirror`, if the profile asks for one.
///
/// # Errors
/// [`DesignError::Forming`] where no sheet follows the mirror, [`DesignError::Border`] when a hole, a mark or a vent does
/// not fit around it.
pub(super) fn wanted(
    profile: &Profile,
    mirror: &Mirror,
) -> Result<Option<FormingTool>, DesignError> {
    let part = &profile.part;
    let Some(spec) = part.forming else { return Ok(None) };
    let foot_mm = part.border.as_ref().map_or(0.0, |border| border.rim_mm);
    let tool = FormingTool::new(mirror, spec, [foot_mm, part.base_mm])?;
    let foot = tool.foot_about_axis(mirror);
    let around = |border| around(part, border, &tool, foot);
    let border = part.border.as_ref().map(around).transpose()?;
    Ok(Some(tool.with_border(mirror, border)))
}

/// The border around the foot of a tool's walls.
fn around(
    part: &PartSpec,
    border: &BorderSpec,
    tool: &FormingTool,
    foot: Outline,
) -> Result<Border, DesignError> {
    let mut border = BorderSpec { rim_mm: tool.flange_mm, ..border.clone() };
    border.holes.extend(vents(tool.spec.vents, foot));
    let around = PartSpec { border: Some(border.clone()), ..part.clone() };
    if let Some(conflict) = around.conflicts(&foot).into_iter().next() {
        let message = match conflict.message.strip_prefix("part.holes_mm must") {
            Some(rest) if tool.spec.vents.count > 0 => {
                format!("holes_mm and vents of a {} must{rest}", tool.spec.form.name())
            }
            _ => conflict.message,
        };
        return Err(DesignError::Border { message, hint: conflict.hint });
    }
    // Places are the part's, seen from above.
    let turned = |at: DVec2| if tool.is_hollow() { at * DVec2::new(1.0, -1.0) } else { at };
    let plain = border.holes.iter().map(|spot| Hole::plain(spot.at, spot.diameter_mm));
    let holes = plain.chain(part.holes.iter().map(|spec: &HoleSpec| spec.hole));
    Ok(Border {
        contour: border.contour(&foot),
        top_mm: border.rim_mm,
        edge_chamfer_mm: border.edge_chamfer_mm,
        holes: holes.map(|hole| Hole { at: turned(hole.at), ..hole }).collect(),
        marks: border.marks.iter().map(|m| Drilled { at: turned(m.at), ..*m }).collect(),
        land: None,
    })
}

/// Vents as near the foot of the walls as holes may be, evenly along it.
fn vents(vents: Vents, foot: Outline) -> Vec<Drilled> {
    let Vents { count, diameter_mm } = vents;
    let out = 0.5 * diameter_mm + BorderSpec::CLEAR_MM + BorderSpec::ROUNDING_MM;
    let share = |k: usize| (k as f64 + 0.5) / count as f64;
    let at = |k: usize| match foot {
        Outline::Ring { outer, .. } => {
            let turn = TAU * share(k);
            (outer + out) * DVec2::new(cos(turn), sin(turn))
        }
        Outline::Rect(Rect { min, max }) => {
            around_rectangle(Rect { min: min - out, max: max + out }, share(k))
        }
    };
    (0..count).map(|k| Drilled { at: at(k), diameter_mm }).collect()
}

/// The place at a share of the way around a rectangle, counter-clockwise from its lower left corner.
fn around_rectangle(around: Rect, share: f64) -> DVec2 {
    let Rect { min, max } = around;
    let corners = [min, DVec2::new(max.x, min.y), max, DVec2::new(min.x, max.y)];
    let mut left = share * 2.0 * around.size().element_sum();
    for k in 0..4 {
        let (from, to) = (corners[k], corners[(k + 1) % 4]);
        let side = from.distance(to);
        if left <= side {
            return from.lerp(to, left / side);
        }
        left -= side;
    }
    corners[0]
}
