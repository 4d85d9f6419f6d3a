//! What a refused profile can ask for instead: changes of single keys, each of which is followed
//! here by designing the changed profile before it is advised.

use super::cause::{Cause, Goal, Trouble};
use super::solve::SolveError;
use super::{Design, DesignError, designed};
use crate::profile::{
    Camera, Layout, MethodKind, Profile, Projection, RadialLaw, SagGrid, Shape, StripLaw, Target,
};
use std::fmt;

/// Most changed profiles that are designed to find a remedy.
pub const MOST_TRIALS: usize = 40;
/// Of these, most with a change of a single key: all that there are for any cause.
const MOST_SINGLE: usize = 20;
/// Alternatives that are told at most.
const ALTERNATIVES: usize = 2;

/// A change of one key of a profile.
#[derive(Debug, Clone, PartialEq)]
pub enum Change {
    /// A key is left out.
    Without(&'static str),
    /// A key has another value.
    Set(&'static str, Value),
    /// A table has another name in its section: another method or another law.
    Take(&'static str, &'static str),
}

/// A value of a key.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A number.
    Number(f64),
    /// A range.
    Range([f64; 2]),
    /// Rows and their elevations.
    Rows(Vec<[f64; 2]>),
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(x) => write!(f, "{x}"),
            Self::Range(range) => write!(f, "{range:?}"),
            Self::Rows(rows) => write!(f, "{rows:?}"),
        }
    }
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Without(key) => write!(f, "leave {key} out"),
            Self::Set(key, value) => write!(f, "set {key} = {value}"),
            Self::Take(section, name) => write!(f, "take {section}.{name}"),
        }
    }
}

/// What to do about a refusal: alternatives, each of changes that are made together, after any of
/// which the mirror can be designed.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Remedy {
    /// The alternatives.
    pub alternatives: Vec<Vec<Change>>,
    /// How many changed profiles were designed to find them.
    pub trials: usize,
}

impl fmt::Display for Remedy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.alternatives.is_empty() {
            return f.write_str(
                "no change of a single key was found that helps: begin with a profile that is \
                 shipped, and change it step by step",
            );
        }
        let together = |changes: &Vec<Change>| {
            changes.iter().map(ToString::to_string).collect::<Vec<_>>().join(" and ")
        };
        let all: Vec<String> = self.alternatives.iter().map(together).collect();
        f.write_str(&all.join(", or "))
    }
}

/// A number as someone would write it, to four digits: what is tried is what is told.
fn short(x: f64) -> f64 {
    format!("{x:.3e}").parse().expect("a number")
}

/// A number to nine digits: rows that lie close together stay apart.
fn round(x: f64) -> f64 {
    format!("{x:.8e}").parse().expect("a number")
}

/// A profile after a change.
struct Changed {
    change: Change,
    profile: Profile,
}

/// What helps against `cause`, for which `profile` is refused.
pub fn remedy(profile: &Profile, sag: Option<&SagGrid>, cause: &Cause) -> Remedy {
    let mut search = Search { sag, trials: 0, most: MOST_SINGLE };
    let mut found: Vec<Vec<Change>> = Vec::new();
    for key in keys(profile, cause) {
        if found.len() == ALTERNATIVES {
            break;
        }
        let helps = key(profile).into_iter().find(|changed| search.helps(&changed.profile));
        found.extend(helps.map(|changed| vec![changed.change]));
    }
    if found.is_empty() {
        found.extend(search.together(profile));
    }
    Remedy { alternatives: found, trials: search.trials }
}

/// Trial designs.
struct Search<'a> {
    sag: Option<&'a SagGrid>,
    trials: usize,
    /// No more are made.
    most: usize,
}

impl Search<'_> {
    /// Whether the mirror of `profile` can be designed; no more are tried when that has been asked
    /// too often.
    fn helps(&mut self, profile: &Profile) -> bool {
        if self.trials >= self.most {
            return false;
        }
        self.trials += 1;
        let design: Result<Design, DesignError> = designed(profile, self.sag);
        // What does not fit around the mirror is another matter.
        matches!(design, Ok(_) | Err(DesignError::Border { .. }))
    }

    /// Changes that help together: the plainest profile, if it can be designed, less what is not
    /// needed for that.
    fn together(&mut self, profile: &Profile) -> Option<Vec<Change>> {
        self.most = MOST_TRIALS;
        let plainest = |key: &Key, profile: &Profile| key(profile).pop();
        let made = |keys: &[Key]| {
            let (mut now, mut changes) = (profile.clone(), Vec::new());
            for key in keys {
                if let Some(changed) = plainest(key, &now) {
                    changes.push(changed.change);
                    now = changed.profile;
                }
            }
            (now, changes)
        };
        let all: [Key; 8] =
            [unfilled, least_squares, vector_field, law, untargeted, degree, elevation, distance];
        let mut keys: Vec<Key> = Vec::new();
        for key in all {
            keys.push(key);
            if plainest(&key, profile).is_some() && self.helps(&made(&keys).0) {
                break;
            }
        }
        if !self.helps(&made(&keys).0) {
            return None;
        }
        for k in (0..keys.len()).rev() {
            let mut fewer = keys.clone();
            fewer.remove(k);
            if plainest(&keys[k], profile).is_none() || self.helps(&made(&fewer).0) {
                keys = fewer;
            }
        }
        Some(made(&keys).1)
    }
}

/// Ways to change one key, the smallest change first.
type Key = fn(&Profile) -> Vec<Changed>;

/// What may help against `cause`, the likeliest first.
fn keys(profile: &Profile, cause: &Cause) -> Vec<Key> {
    let given = !matches!(profile.shape, Shape::Designed(_));
    match cause {
        Cause::Law(_) => vec![law, targets, untargeted, elevation],
        Cause::Fit { source: SolveError::Undetermined(_), .. } => vec![degree_down, elevation],
        Cause::Fit { goal: Goal::Method, .. } | Cause::At { goal: Some(Goal::Method), .. } => {
            vec![unfilled, vector_field, targets, untargeted, degree, elevation, distance]
        }
        Cause::Fit { goal: Goal::Minimax, .. } | Cause::At { goal: Some(Goal::Minimax), .. } => {
            vec![unfilled, least_squares, vector_field, targets, untargeted, degree, elevation]
        }
        Cause::Back { .. } => vec![unfilled, elevation, distance, degree, targets, untargeted],
        // What a given mirror shows does not depend on what it should.
        Cause::At { trouble: Trouble::Nowhere { .. }, .. } if given => {
            vec![unfilled, law, distance]
        }
        Cause::At { trouble: Trouble::Missed { .. }, .. } if given => {
            vec![unfilled, untargeted, distance]
        }
        _ if given => vec![unfilled, law, untargeted, targets, distance, elevation],
        _ => vec![unfilled, targets, untargeted, degree, vector_field, elevation, law, distance],
    }
}

fn changed(profile: &Profile, change: Change, edit: impl FnOnce(&mut Profile)) -> Changed {
    let mut profile = profile.clone();
    edit(&mut profile);
    Changed { change, profile }
}

/// The frame is not filled.
fn unfilled(profile: &Profile) -> Vec<Changed> {
    let mut layout = profile.layout;
    match &mut layout {
        Layout::Strip { fill_frame } | Layout::Conquistador { fill_frame, .. } if *fill_frame => {
            *fill_frame = false;
        }
        _ => return Vec::new(),
    }
    vec![changed(profile, Change::Without("fill_frame"), |p| p.layout = layout)]
}

fn least_squares(profile: &Profile) -> Vec<Changed> {
    let Shape::Designed(mut method) = profile.shape else { return Vec::new() };
    if !method.minimax {
        return Vec::new();
    }
    method.minimax = false;
    vec![changed(profile, Change::Without("minimax"), |p| p.shape = Shape::Designed(method))]
}

fn vector_field(profile: &Profile) -> Vec<Changed> {
    let Shape::Designed(mut method) = profile.shape else { return Vec::new() };
    if method.kind == MethodKind::VectorField {
        return Vec::new();
    }
    method.kind = MethodKind::VectorField;
    let change = Change::Take("method", method.kind.name());
    vec![changed(profile, change, |p| p.shape = Shape::Designed(method))]
}

fn of_degrees(profile: &Profile, degrees: impl IntoIterator<Item = usize>) -> Vec<Changed> {
    let Shape::Designed(method) = profile.shape else { return Vec::new() };
    let of = |degree: usize| {
        let change = Change::Set("degree", Value::Number(degree as f64));
        let shape = Shape::Designed(crate::profile::Method { degree, ..method });
        changed(profile, change, |p| p.shape = shape)
    };
    degrees.into_iter().map(of).collect()
}

/// A degree that follows the picture more closely, where that is a matter of degree.
fn degree(profile: &Profile) -> Vec<Changed> {
    let Shape::Designed(method) = profile.shape else { return Vec::new() };
    of_degrees(profile, [4, 8, 12].into_iter().filter(|&degree| degree > method.degree))
}

/// A degree that the samples determine.
fn degree_down(profile: &Profile) -> Vec<Changed> {
    let Shape::Designed(method) = profile.shape else { return Vec::new() };
    let halves = std::iter::successors(Some(method.degree / 2), |degree| Some(degree / 2));
    of_degrees(profile, halves.take_while(|&degree| degree > 0))
}

fn set_target(profile: &mut Profile, to: Target) {
    match &mut profile.projection {
        None => {}
        Some(Projection::Strip(strip)) => strip.target = to,
        Some(Projection::Radial(radial)) => radial.target = to,
    }
}

/// The target further away.
fn targets(profile: &Profile) -> Vec<Changed> {
    let Some(target) = profile.projection.as_ref().map(Projection::target) else {
        return Vec::new();
    };
    let moved = |factor: f64| {
        let (key, far, to) = match target {
            Target::Infinity => return None,
            Target::Cylinder { radius_mm } => {
                let far = short(factor * radius_mm);
                ("target_radius_mm", far, Target::Cylinder { radius_mm: far })
            }
            Target::Plane { height_mm } => {
                let far = short(factor * height_mm);
                ("target_plane_mm", far, Target::Plane { height_mm: far })
            }
        };
        let change = Change::Set(key, Value::Number(far));
        Some(changed(profile, change, |p| set_target(p, to)))
    };
    [2.0, 8.0, 64.0].into_iter().filter_map(moved).collect()
}

/// The target at infinity.
fn untargeted(profile: &Profile) -> Vec<Changed> {
    let key = match profile.projection.as_ref().map(Projection::target) {
        None | Some(Target::Infinity) => return Vec::new(),
        Some(Target::Cylinder { .. }) => "target_radius_mm",
        Some(Target::Plane { .. }) => "target_plane_mm",
    };
    vec![changed(profile, Change::Without(key), |p| set_target(p, Target::Infinity))]
}

/// Part of the elevations or polar angles: the part that is furthest from the horizon where a plane
/// is to be seen, or else the middle.
fn elevation(profile: &Profile) -> Vec<Changed> {
    let of = |share: f64| -> Option<Changed> {
        let mut profile = profile.clone();
        let change = match profile.projection.as_mut()? {
            Projection::Strip(strip) => {
                let [low, high] = strip.elevation_deg;
                let fixed = match strip.target {
                    Target::Plane { height_mm } if height_mm > 0.0 => high,
                    Target::Plane { .. } => low,
                    _ => 0.5 * (low + high),
                };
                let narrowed = |e: f64| short(fixed + share * (e - fixed));
                strip.elevation_deg = [low, high].map(narrowed);
                let value = match &mut strip.law {
                    // Rows of as many degrees each.
                    StripLaw::Table(rows) => {
                        let first = rows[0][0];
                        for [row, e] in rows.iter_mut() {
                            *row = round(first + share * (*row - first));
                            *e = round(fixed + share * (*e - fixed));
                        }
                        strip.elevation_deg = [rows[rows.len() - 1][1], rows[0][1]];
                        Value::Rows(rows.clone())
                    }
                    _ => Value::Range(strip.elevation_deg),
                };
                Change::Set("elevation_deg", value)
            }
            Projection::Radial(radial) => {
                let inner = radial.inner_polar_deg.unwrap_or(0.0);
                let floor = match radial.target {
                    Target::Plane { height_mm } if height_mm < 0.0 => inner.max(90.0),
                    _ => inner,
                };
                let outer = short(floor + share * (radial.outer_polar_deg - floor));
                radial.outer_polar_deg = outer;
                Change::Set("outer_polar_deg", Value::Number(outer))
            }
        };
        Some(Changed { change, profile })
    };
    [0.5, 0.25, 0.0625].into_iter().filter_map(of).collect()
}

/// A law that has a place for every direction.
fn law(profile: &Profile) -> Vec<Changed> {
    let mut projection = profile.projection.clone();
    let name = match &mut projection {
        Some(Projection::Strip(strip)) => match strip.law {
            StripLaw::Best => {
                strip.law = StripLaw::Mercator;
                "mercator"
            }
            StripLaw::Cylindrical | StripLaw::Mercator => {
                strip.law = StripLaw::Equirectangular;
                "equirectangular"
            }
            _ => return Vec::new(),
        },
        Some(Projection::Radial(radial))
            if radial.law.has_two_parameters() && radial.law != RadialLaw::Equiangular =>
        {
            radial.law = RadialLaw::Equiangular;
            "equiangular"
        }
        _ => return Vec::new(),
    };
    vec![changed(profile, Change::Take("projection", name), |p| p.projection = projection)]
}

/// The camera further away.
fn distance(profile: &Profile) -> Vec<Changed> {
    let Camera::Pinhole { pixels, focal_px, distance_mm } = profile.camera else {
        return Vec::new();
    };
    // A part that fills the frame would have to grow with it.
    if !unfilled(profile).is_empty() {
        return Vec::new();
    }
    let moved = |factor: f64| {
        let distance_mm = short(factor * distance_mm);
        let change = Change::Set("distance_mm", Value::Number(distance_mm));
        let camera = Camera::Pinhole { pixels, focal_px, distance_mm };
        changed(profile, change, |p| p.camera = camera)
    };
    [2.0, 8.0, 64.0].into_iter().map(moved).collect()
}
