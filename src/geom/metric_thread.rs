//! Metric threads M2 to M8 with coarse pitch, and what is drilled for them and for their screws.

use std::fmt;

/// A metric thread of the coarse series, first choice of ISO 261.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MetricThread {
    /// M2 x 0.4.
    M2,
    /// M2.5 x 0.45.
    M2_5,
    /// M3 x 0.5.
    M3,
    /// M4 x 0.7.
    M4,
    /// M5 x 0.8.
    M5,
    /// M6 x 1.
    M6,
    /// M8 x 1.25.
    M8,
}

impl MetricThread {
    /// All of them, with their names in a profile.
    pub const ALL: [(&'static str, Self); 7] = [
        ("M2", Self::M2),
        ("M2.5", Self::M2_5),
        ("M3", Self::M3),
        ("M4", Self::M4),
        ("M5", Self::M5),
        ("M6", Self::M6),
        ("M8", Self::M8),
    ];

    /// Threads of a tap's chamfer, which are not of full depth, and one turn of clearance from the ground of the hole,
    /// in pitches: a chamfer of form C has two to three threads (DIN 2197).
    const OVERRUN: f64 = 4.0;

    /// Nominal diameter, pitch, tap drill, clearance hole and counterbore, mm: ISO 261 (coarse pitch), ISO 2306 (drills for
    /// use prior to tapping), ISO 273 (medium series) and DIN 974-1 (series 1).
    const fn row(self) -> [f64; 5] {
        match self {
            Self::M2 => [2.0, 0.4, 1.6, 2.4, 4.4],
            Self::M2_5 => [2.5, 0.45, 2.05, 2.9, 5.5],
            Self::M3 => [3.0, 0.5, 2.5, 3.4, 6.5],
            Self::M4 => [4.0, 0.7, 3.3, 4.5, 8.0],
            Self::M5 => [5.0, 0.8, 4.2, 5.5, 10.0],
            Self::M6 => [6.0, 1.0, 5.0, 6.6, 11.0],
            Self::M8 => [8.0, 1.25, 6.8, 9.0, 15.0],
        }
    }

    /// Nominal (major) diameter, mm.
    #[must_use]
    pub fn diameter_mm(self) -> f64 {
        self.row()[0]
    }

    /// Pitch of the coarse series (ISO 261), mm.
    #[must_use]
    pub fn pitch_mm(self) -> f64 {
        self.row()[1]
    }

    /// Diameter of the drill before tapping (ISO 2306), mm.
    #[must_use]
    pub fn pilot_mm(self) -> f64 {
        self.row()[2]
    }

    /// Diameter of the clearance hole for a bolt or screw (ISO 273, medium series), mm.
    #[must_use]
    pub fn clearance_mm(self) -> f64 {
        self.row()[3]
    }

    /// Diameter of the counterbore for the head of a screw ISO 4762 (DIN 974-1, series 1), mm.
    #[must_use]
    pub fn counterbore_mm(self) -> f64 {
        self.row()[4]
    }

    /// Depth of the counterbore in which the head of a screw ISO 4762, as high as its nominal diameter, is sunk: 0.4 mm
    /// deeper than the head, of M8 0.6 mm (DIN 974-1), mm.
    #[must_use]
    pub fn counterbore_depth_mm(self) -> f64 {
        let diameter = self.diameter_mm();
        diameter + if diameter > 6.0 { 0.6 } else { 0.4 }
    }

    /// Depth by which a blind pilot hole exceeds the usable thread, mm: four pitches.
    #[must_use]
    pub fn overrun_mm(self) -> f64 {
        Self::OVERRUN * self.pitch_mm()
    }
}

impl fmt::Display for MetricThread {
    /// Size and pitch, as in `M3 x 0.5`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "M{} x {}", self.diameter_mm(), self.pitch_mm())
    }
}

/// Upper limit deviation of a hole of tolerance class H7, whose lower one is 0, mm: ISO 286-2, nominal sizes up to 10 mm.
/// None of larger ones.
#[must_use]
pub fn h7_upper_mm(nominal_mm: f64) -> Option<f64> {
    match nominal_mm {
        d if d > 0.0 && d <= 3.0 => Some(0.010),
        d if d > 3.0 && d <= 6.0 => Some(0.012),
        d if d > 6.0 && d <= 10.0 => Some(0.015),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The pilot leaves about 0.76 of the thread's height: d - P is the rule of thumb that ISO 2306 rounds.
    #[test]
    fn pilots_are_the_nominal_diameter_less_the_pitch_to_a_tenth() {
        for (name, thread) in MetricThread::ALL {
            let rule = thread.diameter_mm() - thread.pitch_mm();
            assert!((thread.pilot_mm() - rule).abs() <= 0.05 + 1e-12, "{name}");
            assert!(thread.to_string().starts_with(&format!("{name} x ")), "{thread}");
            // Minor diameter of the internal thread (ISO 724): d - 1.0825 P; the 6H limits (ISO 965-1) are above it.
            let minor = thread.diameter_mm() - 1.0825 * thread.pitch_mm();
            assert!(thread.pilot_mm() > minor, "{name}");
        }
    }

    /// ISO 4762: heads are 1.5 diameters wide from M5 on and somewhat wider below, and one diameter high.
    #[test]
    fn heads_go_into_their_counterbores_and_rest_on_their_grounds() {
        let heads = [3.8, 4.5, 5.5, 7.0, 8.5, 10.0, 13.0];
        for ((name, thread), head) in MetricThread::ALL.into_iter().zip(heads) {
            assert!(
                thread.counterbore_mm() > head && thread.counterbore_mm() < head + 2.5,
                "{name}"
            );
            assert!(thread.clearance_mm() > thread.diameter_mm(), "{name}");
            assert!(thread.clearance_mm() < head - 0.9, "{name}");
            assert!(thread.counterbore_depth_mm() > thread.diameter_mm(), "{name}");
        }
        assert_eq!(MetricThread::M8.counterbore_depth_mm(), 8.6);
        assert_eq!(MetricThread::M3.counterbore_depth_mm(), 3.4);
    }

    /// IT7 of ISO 286-1: 16 i of i = 0.45 cbrt(D) + 0.001 D um, D the geometric mean of the range (1 to 3 for the first).
    #[test]
    fn limits_of_h7_are_sixteen_standard_tolerance_units() {
        for [low, high] in [[1.0, 3.0], [3.0, 6.0], [6.0, 10.0]] {
            let mean = f64::sqrt(low * high);
            let unit = 0.45 * crate::num::exp(crate::num::log(mean) / 3.0) + 0.001 * mean;
            let um = 1e3 * h7_upper_mm(high).unwrap();
            assert!((um - 16.0 * unit).abs() < 1.5, "{high}: {um}, not {}", 16.0 * unit);
        }
        assert_eq!([0.0, 10.5, f64::NAN].map(h7_upper_mm), [None; 3]);
    }
}
