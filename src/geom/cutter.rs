//! The end of a milling cutter: ball, bull-nosed or flat.

/// A milling cutter below its shank, of revolution about its axis: a disc with a rounded edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cutter {
    /// Its radius, mm.
    pub radius_mm: f64,
    /// Radius of its rounded edge, mm: the cutter's own of a ball, 0 of a flat cutter, between both of a bull-nosed one.
    pub corner_mm: f64,
}

impl Cutter {
    /// A ball.
    #[must_use]
    pub fn ball(radius_mm: f64) -> Self {
        Self { radius_mm, corner_mm: radius_mm }
    }

    /// The radius, if it is a ball, mm.
    #[must_use]
    pub fn ball_mm(&self) -> Option<f64> {
        (self.corner_mm == self.radius_mm).then_some(self.radius_mm)
    }

    /// Radius of the flat part of its end, mm: 0 of a ball.
    #[must_use]
    pub fn flat_mm(&self) -> f64 {
        self.radius_mm - self.corner_mm
    }

    /// Height of its lower side over its tip at a distance from its axis, mm; none beyond its radius.
    #[must_use]
    pub fn height(&self, off_mm: f64) -> Option<f64> {
        let beyond = off_mm - self.flat_mm();
        if beyond <= 0.0 {
            return Some(0.0);
        }
        let square = self.corner_mm * self.corner_mm - beyond * beyond;
        // c - sqrt(c^2 - x^2) without its cancellation.
        (square > 0.0).then(|| beyond * beyond / (self.corner_mm + square.sqrt()))
    }

    /// Its name in words.
    #[must_use]
    pub fn words(&self) -> String {
        let Self { radius_mm, corner_mm } = self;
        if self.ball_mm().is_some() {
            format!("ball of {radius_mm} mm radius")
        } else if *corner_mm > 0.0 {
            format!("bull-nosed cutter of {radius_mm} mm radius, corner {corner_mm} mm")
        } else {
            format!("flat cutter of {radius_mm} mm radius")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lower_side_is_flat_and_then_a_quarter_of_a_circle() {
        let bull = Cutter { radius_mm: 3.0, corner_mm: 1.0 };
        for (off, exact) in [(0.0, 0.0), (2.0, 0.0), (2.6, 0.2), (2.8, 0.4)] {
            assert!((bull.height(off).unwrap() - exact).abs() < 1e-12, "{off}");
        }
        assert_eq!(bull.height(3.01), None);
        assert_eq!(Cutter { radius_mm: 3.0, corner_mm: 0.0 }.height(3.0), Some(0.0));
        let ball = Cutter::ball(2.0);
        assert!((ball.height(1.2).unwrap() - 0.4).abs() < 1e-15);
        assert_eq!((ball.ball_mm(), bull.ball_mm()), (Some(2.0), None));
    }
}
