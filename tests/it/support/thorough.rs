//! The switch for long runs.

/// `usual`, or what a long run takes instead: `MORION_THOROUGH=1` asks for one.
pub fn times(usual: usize, thorough: usize) -> usize {
    let asked = std::env::var_os("MORION_THOROUGH").is_some_and(|value| value == "1");
    if asked { thorough } else { usual }
}

/// Every `n`-th of `cases`, begun with another one for each `turn`; all of them in a long run.
pub fn share<T>(
    n: usize,
    turn: usize,
    cases: impl IntoIterator<Item = T>,
) -> impl Iterator<Item = T> {
    let n = times(n, 1);
    cases.into_iter().skip(turn % n).step_by(n)
}
