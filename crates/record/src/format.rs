//! Formats of the tables.

/// Format of the tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableFormat {
    /// Apache Parquet; unit and description of a column stand in its field metadata.
    Parquet,
    /// Comma-separated text; units and descriptions stand in `columns.csv` beside it.
    Csv,
}

impl TableFormat {
    /// Extension of its files, without the dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Parquet => "parquet",
            Self::Csv => "csv",
        }
    }
}
