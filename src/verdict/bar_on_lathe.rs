//! What programs of a lathe leave of a bar, one after the other, held against the mirror.

use crate::design::Design;
use crate::geom::DVec2;
use crate::milling::OperationKind;
use crate::num::{cos, sin};
use crate::parallel;
use crate::program::{TurnedBar, TurningPath};
use crate::results::{CuttingFault, LeftFacts, StockMeeting};
use crate::turning::{Bar, DiscSections, Meridian};
use std::f64::consts::TAU;

/// Least that roughing and semi-finishing leave over what they are asked to.
const LEAST_ALLOWANCE: f64 = 0.9;
/// What finishing may cut into the mirror beyond the chords of its moves, mm: half a micrometre, for the decimals of programs and
/// the rounding of figures.
const GOUGE_MM: f64 = 5e-4;

/// A bar in the course of its programs, held against the mirror.
pub(crate) struct BarOnLathe {
    bar: TurnedBar,
    /// The mirror: of a round one its one section, of others that at each azimuth of the bar.
    spokes: Vec<Spoke>,
}

/// A section of the mirror.
struct Spoke {
    /// Direction from the axis.
    out: DVec2,
    /// Z of the mirror over each place of the bar, mm, and how much of Z its normal takes; none off the mirror.
    mirror: Vec<Option<[f64; 2]>>,
    /// The section, from the axis to the rim.
    section: Vec<DVec2>,
}

/// Least distance from the mirror, mm, at which its bend and its rims count.
const NEAR_MM: f64 = 0.01;
/// Azimuths at which a disc is looked at.
const AZIMUTHS: usize = 32;
/// Places of a section of a disc.
const PLACES: usize = 500;

/// What a program is to do.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CutTask {
    /// What it is.
    pub kind: OperationKind,
    /// Radius of the nose, mm.
    pub nose_mm: f64,
    /// What it is to leave on the mirror, mm.
    pub allowance_mm: f64,
    /// What its moves may be off their paths, mm.
    pub chord_mm: f64,
}

/// What a program leaves of it.
pub(crate) struct TurnedLeft {
    /// How much on the mirror; none where no place is over it.
    pub left: Option<LeftFacts>,
    /// What is wrong.
    pub faults: Vec<CuttingFault>,
}

impl BarOnLathe {
    /// The bar of a round mirror before its programs.
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
        Self { bar: turned, spokes: vec![Spoke { out: DVec2::X, mirror, section }] }
    }

    /// The bar of a disc. What is left of it is told within its sections.
    pub(crate) fn of_disc(disc: &DiscSections, bar: Bar) -> Self {
        let turned = TurnedBar::at_azimuths(bar.radius_mm, bar.top_mm, AZIMUTHS);
        let places = turned.heights().count();
        let spokes = parallel::map(AZIMUTHS, 1, |k| {
            let azimuth = TAU * k as f64 / AZIMUTHS as f64;
            let rim = disc.rim(azimuth).map_or(0.0, |rim| rim.at.x);
            let at = |radius: f64| disc.at(azimuth, radius);
            let mirror = (0..places).map(|place| {
                let place = at(turned.place(place)).filter(|place| place.at.x <= rim)?;
                Some([place.at.y, place.normal().y])
            });
            let share = |place: usize| rim * place as f64 / PLACES as f64;
            let section = (0..=PLACES).filter_map(|place| at(share(place)).map(|at| at.at));
            let out = DVec2::new(cos(azimuth), sin(azimuth));
            Spoke { out, mirror: mirror.collect(), section: section.collect() }
        });
        Self { bar: turned, spokes }
    }

    /// Takes away what a program cuts.
    pub(crate) fn cut(
        &mut self,
        path: &TurningPath,
        CutTask { kind, nose_mm, allowance_mm, chord_mm }: CutTask,
    ) -> TurnedLeft {
        let moved = self.bar.cut(path, nose_mm);
        let met = [(moved.rapid, StockMeeting::Rapid), (moved.plunge, StockMeeting::Plunge)];
        let met = met.into_iter().filter_map(|(found, meeting)| {
            let found = found?;
            Some(CuttingFault::IntoStock {
                meeting,
                line: found.line,
                at_mm: [found.at.x, found.at.y],
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

    /// The least and the most left on the mirror over each distance from the axis, of all azimuths, mm, um.
    pub(crate) fn section(&self) -> Vec<[f64; 3]> {
        let mut all: Vec<Option<[f64; 3]>> = Vec::new();
        for (spoke, left) in self.spokes.iter().zip(self.lefts()) {
            all.resize(all.len().max(spoke.mirror.len()), None);
            for (place, [radius, low, high]) in left {
                let found = all[place].map_or([radius, low, high], |[_, least, most]| {
                    [radius, low.min(least), high.max(most)]
                });
                all[place] = Some(found);
            }
        }
        all.into_iter().flatten().collect()
    }

    /// Of each section the distance from the axis, mm, and the least and the most that is left there, um, with the number of the place.
    fn lefts(&self) -> Vec<Vec<(usize, [f64; 3])>> {
        parallel::map(self.spokes.len(), 1, |k| match self.spokes.len() {
            1 => self.left_on(&self.spokes[k], self.bar.heights()),
            _ => self.left_on(&self.spokes[k], self.bar.heights_at(k)),
        })
    }

    fn left_on(
        &self,
        spoke: &Spoke,
        heights: impl Iterator<Item = [f64; 2]>,
    ) -> Vec<(usize, [f64; 3])> {
        let all = heights.zip(&spoke.mirror).enumerate();
        let left = all.filter_map(|(k, (heights, mirror))| {
            let [at, normal] = (*mirror)?;
            let radius = self.bar.place(k);
            let [low, high] = heights.map(|z| {
                let off_mm = (z - at) * normal;
                let is_near = off_mm.abs() < NEAR_MM;
                1e3 * if is_near {
                    off_mm
                } else {
                    spoke.distance(DVec2::new(radius, z)).copysign(off_mm)
                }
            });
            Some((k, [radius, low, high]))
        });
        left.collect()
    }

    fn left(&self) -> Option<LeftFacts> {
        let lefts = self.lefts();
        let all = || {
            let spokes = self.spokes.iter().zip(&lefts);
            spokes.flat_map(|(spoke, left)| left.iter().map(|(_, left)| (spoke.out, *left)))
        };
        let (least_out, least) = all().reduce(|a, b| if b.1[1] < a.1[1] { b } else { a })?;
        let (most_out, most) = all().reduce(|a, b| if b.1[2] > a.1[2] { b } else { a })?;
        Some(LeftFacts {
            least_um: least[1],
            least_at_mm: (least[0] * least_out).to_array(),
            most_um: most[2],
            most_at_mm: (most[0] * most_out).to_array(),
        })
    }
}

impl Spoke {
    /// Distance of a place from the section, mm, which is no more than that straight down.
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
}
