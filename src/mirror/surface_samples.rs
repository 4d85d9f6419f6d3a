//! A mirror sampled all over, and the place where a measure of it is largest.

use super::{LocalSurface, Mirror};
use crate::geom::DVec2;
use crate::parallel;

/// Samples of the face along each axis of a panel, the rim among them.
const SAMPLES: usize = 96;

/// Places all over a mirror, rim included.
#[derive(Debug, Clone)]
pub struct SurfaceSamples<'a> {
    mirror: &'a Mirror,
    /// Each place's chart coordinates, mm, and the surface there.
    pub face: Vec<(DVec2, LocalSurface)>,
}

impl<'a> SurfaceSamples<'a> {
    /// Samples of `mirror`.
    #[must_use]
    pub fn new(mirror: &'a Mirror) -> Self {
        let panel = mirror.outline.samples(SAMPLES).concat();
        let flip = DVec2::new(1.0, -1.0);
        let images = panel.iter().map(|(q, _)| *q * flip).filter(|_| mirror.folded);
        let places: Vec<DVec2> = panel.iter().map(|(q, _)| *q).chain(images).collect();
        let face = parallel::map_slice(&places, 1, |&q| (q, mirror.extended_surface(q)));
        Self { mirror, face }
    }

    /// The mirror.
    #[must_use]
    pub fn mirror(&self) -> &'a Mirror {
        self.mirror
    }

    /// The place of the face where `measure` is largest: the samples' best, refined by a compass search.
    #[must_use]
    pub fn largest(&self, measure: impl Fn(&LocalSurface) -> f64) -> (f64, LocalSurface) {
        let whole = self.mirror.full_outline();
        let first = self.face[0];
        let start = (measure(&first.1), first);
        let (mut most, (mut q, mut place)) = self.face.iter().fold(start, |best, &sample| {
            let value = measure(&sample.1);
            if value > best.0 { (value, sample) } else { best }
        });
        let size = whole.bounds().size().max_element();
        let mut step = size / SAMPLES as f64;
        while step > 1e-9 * size {
            let ways = [DVec2::X, DVec2::Y, DVec2::ONE, DVec2::new(1.0, -1.0)];
            let around = ways.into_iter().flat_map(|way| [q + way * step, q - way * step]);
            let better = around
                .filter(|&q| whole.contains(q))
                .map(|q| (q, self.mirror.extended_surface(q)))
                .map(|(q, place)| (measure(&place), q, place))
                .find(|found| found.0 > most);
            match better {
                Some(found) => (most, q, place) = found,
                None => step *= 0.5,
            }
        }
        (most, place)
    }
}
