//! Units of measurement as data.
