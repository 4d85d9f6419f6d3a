//! The switch for long runs.

/// `usual`, or what a long run takes instead: `MORION_THOROUGH=1` asks for one.
pub fn times(usual: usize, thorough: usize) -> usize {
    let asked = std::env::var_os("MORION_THOROUGH").is_some_and(|value| value == "1");
    if asked { thorough } else { usual }
}
