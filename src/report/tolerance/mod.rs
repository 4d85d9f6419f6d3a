//! A study of tolerances in words, as a page and in charts.

mod conclusions;
mod page;
mod plots;
mod rows;
mod words;
