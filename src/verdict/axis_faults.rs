//! What a program of a slow tool servo asks of the machine's axes beyond what they can.

use crate::profile::LatheSpec;
use crate::program::TurningPath;
use crate::results::CuttingFault;

/// What may be asked for over a limit: the rounding of figures.
const ROUNDED: f64 = 1.005;

/// The faults of a program whose spindle is an axis, by the axes of a machine.
pub(crate) fn axis_faults(machine: &LatheSpec, path: &TurningPath) -> Vec<CuttingFault> {
    let rates = path.axis_rates();
    let [limit_mm_s2, limit_mm_min] = [machine.acceleration_mm_s2, machine.rapid_mm_min];
    let (acceleration, speed) = (rates.acceleration, rates.speed);
    let fast = !(acceleration.most <= ROUNDED * limit_mm_s2);
    let acceleration = fast.then_some(CuttingFault::Acceleration {
        line: acceleration.line,
        found_mm_s2: acceleration.most,
        limit_mm_s2,
    });
    let speed = (!(speed.most <= ROUNDED * limit_mm_min)).then_some(CuttingFault::AxisSpeed {
        line: speed.line,
        found_mm_min: speed.most,
        limit_mm_min,
    });
    acceleration.into_iter().chain(speed).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::ServoSpec;

    /// At 60 turns a minute steps of 10 degrees take 1/36 s: from 0 to 0.01 mm in one of them is 0.01 x 36^2 mm/s^2, and 21.6 mm/min.
    #[test]
    fn axes_are_held_to_the_machines_limits() {
        let text = "# spindle_rpm 60\n10 5 0\n10 5 10\n10 5.01 20\n10 5.02 30\n";
        let path = TurningPath::read_table(text.as_bytes()).unwrap();
        let mut machine = ServoSpec::lathe().machine;
        assert_eq!(axis_faults(&machine, &path), []);
        (machine.acceleration_mm_s2, machine.rapid_mm_min) = (12.0, 20.0);
        match &axis_faults(&machine, &path)[..] {
            [
                CuttingFault::Acceleration { line: 4, found_mm_s2, .. },
                CuttingFault::AxisSpeed { line: 4 | 5, found_mm_min, .. },
            ] => {
                assert!((found_mm_s2 - 12.96).abs() < 1e-6, "{found_mm_s2}");
                assert!((found_mm_min - 21.6).abs() < 1e-6, "{found_mm_min}");
            }
            other => panic!("{other:?}"),
        }
    }
}
