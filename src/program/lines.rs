//! RS-274 text to moves, line by line.

use super::modal::ControlState;
use super::reader::{LineWords, Vocabulary};
use super::words::words;
use super::{ProgramFault, ToolPath};

/// Most moves that are kept.
const MOST: usize = 5_000_000;

impl ToolPath {
    /// The moves of a program: the tip of the tool in its work offset, mm.
    ///
    /// Known are G0 to G4, G17 to G21, G28, G30, G40, G43, G49, G53 to G59, G61, G61.1, G64, G80, G90, G90.1, G91, G91.1, G94 and
    /// G97; M0 to M9, M30, M48 and M49; F, H, I, J, K, N, O, P, R, S, T, X, Y and Z. Tool lengths and work offsets are the
    /// machine's: places are those of the tip in the offset that is chosen. Corners are taken as they are written, whatever
    /// G64 lets a control round.
    ///
    /// # Errors
    /// [`ProgramFault`] with the line of what is not known, or contradicts itself.
    pub fn read(bytes: &[u8]) -> Result<Self, ProgramFault> {
        each_line(bytes, ControlState::new(), Vocabulary::Mill, |block, state, path| {
            block.run(state, &mut path.moves)
        })
    }
}

/// The moves of a program, of which `run` takes in one line after the other.
pub(super) fn each_line(
    bytes: &[u8],
    mut state: ControlState,
    vocabulary: Vocabulary,
    mut run: impl FnMut(&LineWords, &mut ControlState, &mut ToolPath) -> Result<(), ProgramFault>,
) -> Result<ToolPath, ProgramFault> {
    let text = std::str::from_utf8(bytes)
        .map_err(|error| ProgramFault::Text { byte: error.valid_up_to() })?;
    let mut path = ToolPath::default();
    for (k, text) in text.lines().enumerate() {
        let line = u32::try_from(k + 1).unwrap_or(u32::MAX);
        path.lines = line;
        let block = LineWords::new(line, &words(line, text)?, vocabulary)?;
        run(&block, &mut state, &mut path)?;
        if path.moves.len() > MOST {
            return Err(ProgramFault::Many { line, most: MOST });
        }
        if block.ends() {
            break;
        }
    }
    if !path.moves.iter().any(|step| step.feed.is_some()) {
        return Err(ProgramFault::Empty);
    }
    Ok(path)
}
