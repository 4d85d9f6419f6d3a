//! What programs of a lathe leave of a bar, one after the other, held against the mirror.

use crate::design::Design;
use crate::geom::DVec2;
use crate::milling::OperationKind;
use crate::program::{TurnedBar, TurningPath};
use crate::results::{CuttingFault, LeftFacts, StockMeeting};
use crate::turning::{Bar, Meridian, TurnedOperation};

/// Least that roughing and semi-finishing leave over what they are asked to.
const LEAST_ALLOWANCE: f64 = 0.9;
/// What finishing may cut into the mirror beyond the chords of its moves, mm: half a micrometre, for the decimals of programs and
/// the rounding of figures.
const GOUGE_MM: f64 = 5e-4;

/// A bar in the course of its programs, held against the mirror.
pub(crate) struct BarOnLathe {
    bar: TurnedBar,
    /// Z of the mirror over each place, mm, and how much of Z its normal takes; none off the mirror.
    mirror: Vec<Option<[f64; 2]>>,
    /// The mirror's section, from the axis to the rim.
    section: Vec<DVec2>,
}

/// Least distance from the mirror, mm, at which its bend and its rims count.
const NEAR_MM: f64 = 0.01;

/// What a program leaves of it.
pub(crate) struct TurnedLeft {
    /// How much on the mirror; none where no place is over it.
    pub left: Option<LeftFacts>,
    /// What is wrong.
    pub faults: Vec<CuttingFault>,
}

impl BarOnLathe {
    /// The bar before its programs.
    pub(crate) fn new(design: &Design, meridian: &Meridian, bar: Bar) -> Self {
        let turned = TurnedBar::new(bar.radius_mm, bar.top_mm);
        let [inner, outer] = meridian.ends().map(|q| meridian.at(q).at.x);
        let near_mm = meridian.at(meridian.ends()[1]).at.y;
        let mirror = (0..turned.heights().count()).map(|k| {
            let radius = turned.place(k);
            if !(inner..=outer).contains(&radius) {
                return None;
            }
            let at = DVec2::new(radius, 0.0);
            let place = design.mirror.local_surface_over(at, near_mm)?;
            Some([place.at.z, place.normal().z])
        });
        let mirror = mirror.collect();
        let mut section: Vec<DVec2> = meridian.places().map(|place| place.at).collect();
        section.reverse();
        Self { bar: turned, mirror, section }
    }

    /// Takes away what a program of an operation cuts, whose moves are within `chord_mm` of their paths.
    pub(crate) fn cut(
        &mut self,
        path: &TurningPath,
        operation: &TurnedOperation,
        chord_mm: f64,
    ) -> TurnedLeft {
        let TurnedOperation { kind, nose_mm, allowance_mm, .. } = *operation;
        let moved = self.bar.cut(path, nose_mm);
        let met = [(moved.rapid, StockMeeting::Rapid), (moved.plunge, StockMeeting::Plunge)];
        let met = met.into_iter().filter_map(|(found, meeting)| {
            let found = found?;
            Some(CuttingFault::IntoStock {
                meeting,
                line: found.line,
                at_mm: [found.at.x, 0.0],
                depth_mm: found.depth_mm,
            })
        });
        let left = self.left();
        let least_mm = match kind {
            OperationKind::Finishing => -chord_mm - GOUGE_MM,
            _ => LEAST_ALLOWANCE * allowance_mm,
        };
        let deep = left.filter(|left| !(1e-3 * left.least_um >= least_mm));
        let gouge = deep.map(|left| CuttingFault::TooDeep {
            left_um: left.least_um,
            asked_um: 1e3 * allowance_mm,
            at_mm: left.least_at_mm,
        });
        TurnedLeft { left, faults: met.chain(gouge).collect() }
    }

    /// The least and the most left on the mirror over each distance from the axis, mm, um.
    pub(crate) fn section(&self) -> Vec<[f64; 3]> {
        let all = self.bar.heights().zip(&self.mirror).enumerate();
        let left = all.filter_map(|(k, (heights, mirror))| {
            let [at, normal] = (*mirror)?;
            let radius = self.bar.place(k);
            let [low, high] = heights.map(|z| {
                let off_mm = (z - at) * normal;
                let is_near = off_mm.abs() < NEAR_MM;
                1e3 * if is_near {
                    off_mm
                } else {
                    self.distance(DVec2::new(radius, z)).copysign(off_mm)
                }
            });
            Some([radius, low, high])
        });
        left.collect()
    }

    /// Distance of a place from the mirror's section, mm, which is no more than that straight down.
    fn distance(&self, at: DVec2) -> f64 {
        let straight = |pair: &[DVec2]| {
            let (from, way) = (pair[0], pair[1] - pair[0]);
            let share = ((at - from).dot(way) / way.length_squared()).clamp(0.0, 1.0);
            at.distance(from + share * way)
        };
        let middle =
            self.section.partition_point(|place| place.x < at.x).clamp(1, self.section.len() - 1);
        let mut least = straight(&self.section[middle - 1..=middle]);
        let near = |pair: &&[DVec2], least: f64| {
            let [low, high] = [pair[0].x, pair[1].x];
            low - at.x < least && at.x - high < least
        };
        for pair in self.section[middle..].windows(2) {
            if !near(&pair, least) {
                break;
            }
            least = least.min(straight(pair));
        }
        for k in (1..middle).rev() {
            let pair = &self.section[k - 1..=k];
            if !near(&pair, least) {
                break;
            }
            least = least.min(straight(pair));
        }
        least
    }

    fn left(&self) -> Option<LeftFacts> {
        let section = self.section();
        let least = section.iter().reduce(|a, b| if b[1] < a[1] { b } else { a })?;
        let most = section.iter().reduce(|a, b| if b[2] > a[2] { b } else { a })?;
        Some(LeftFacts {
            least_um: least[1],
            least_at_mm: [least[0], 0.0],
            most_um: most[2],
            most_at_mm: [most[0], 0.0],
        })
    }
}
