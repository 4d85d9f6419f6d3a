//! A study of tolerances in words, as a page and in plots.

mod conclusions;
mod page;
mod plots;
mod rows;
mod words;
