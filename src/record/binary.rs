//! Formats that are no text, known by their first bytes.

use std::path::Path;

use super::bytes::Broken;
use super::care::{Care, MOST, Standing};
use super::groups::Groups;
use super::{Asked, mat, mdf, tdms};
use crate::complaint::{Complaint, Kind};

/// A format that is no text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Binary {
    Parquet,
    /// A ZIP archive that holds the sheets of Excel, or another.
    Workbook,
    /// MATLAB v5 to v7.2.
    Mat,
    /// MATLAB v7.3, which is HDF5.
    Hdf,
    Mdf,
    /// MDF whose writing broke off.
    UnfinishedMdf,
    /// MDF before version 4.
    OldMdf,
    Tdms,
    /// The index that LabVIEW keeps beside a TDMS file.
    TdmsIndex,
}

impl Binary {
    /// The format of a file that begins so.
    pub fn of(bytes: &[u8]) -> Option<Self> {
        const MARKS: &[(&[u8], Binary)] = &[
            (b"PAR1", Binary::Parquet),
            (b"PK\x03\x04", Binary::Workbook),
            (b"MATLAB 7.3", Binary::Hdf),
            (b"\x89HDF\r\n", Binary::Hdf),
            (b"MATLAB 5.0", Binary::Mat),
            (b"MDF     ", Binary::Mdf),
            (b"UnFinMF ", Binary::UnfinishedMdf),
            (b"TDSm", Binary::Tdms),
            (b"TDSh", Binary::TdmsIndex),
        ];
        let found = MARKS.iter().find(|(mark, _)| bytes.starts_with(mark)).map(|(_, format)| *format);
        let version = bytes.get(8).copied().unwrap_or(b'4');
        found.map(|format| if format == Self::Mdf && version != b'4' { Self::OldMdf } else { format })
    }

    /// What people call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Parquet => "Parquet",
            Self::Workbook => "Excel workbook",
            Self::Mat => "MATLAB v5",
            Self::Hdf => "MATLAB v7.3 or HDF5",
            Self::Mdf => "MDF 4",
            Self::UnfinishedMdf => "MDF whose writing broke off",
            Self::OldMdf => "MDF before version 4",
            Self::Tdms => "TDMS",
            Self::TdmsIndex => "the index of a TDMS file",
        }
    }

    /// The complaint of whoever reads a record piece by piece.
    pub fn not_in_pieces(self, path: &Path) -> Complaint {
        Complaint::new(Kind::Syntax, format!("the file is {}, which is not read piece by piece", self.name()))
            .in_file(path)
            .help("write the record as CSV, columns `name [unit]`, the time first; or diagnose it whole, without `--window`")
    }

    /// Reads the record.
    ///
    /// # Errors
    /// A format that is not read, or that this program was built without; and what is wrong in the record.
    pub fn read(self, path: &Path, bytes: &[u8], care: Care, asked: &Asked) -> Result<Standing, Complaint> {
        let gathered = |groups: Result<Groups, Broken>| {
            groups.map_err(|broken| self.told(path, broken))?.assemble(path, care, asked)
        };
        match self {
            Self::Workbook => workbook(path, bytes, care, asked),
            Self::Parquet => parquet(path, bytes, care, asked),
            Self::Mat => gathered(mat::read(bytes, MOST)),
            Self::Mdf => gathered(mdf::read(bytes, MOST)),
            Self::Hdf => hdf5(path, bytes, care, asked),
            Self::UnfinishedMdf => {
                Err(self.not_read(path, "let the program that wrote it finish it, or repair it there"))
            }
            Self::OldMdf => Err(self.not_read(path, "convert it to MDF 4, or write the record as CSV")),
            Self::Tdms => gathered(tdms::read(bytes)),
            Self::TdmsIndex => Err(self.not_read(path, "name the file `.tdms` beside it, which has the values")),
        }
    }

    fn told(self, path: &Path, broken: Broken) -> Complaint {
        match broken {
            Broken::TooLarge => crate::files::too_large(path, MOST),
            Broken::NotRead(what) => {
                Complaint::new(Kind::Syntax, format!("the {} file holds {what}, which are not read", self.name()))
                    .in_file(path)
                    .help("write the record as CSV, columns `name [unit]`, the time first")
            }
            Broken::Damaged(what) => {
                Complaint::new(Kind::Syntax, format!("the {} file is damaged: {what}", self.name()))
                    .in_file(path)
                    .help("copy it again, or write the record as CSV, columns `name [unit]`, the time first")
            }
        }
    }

    fn not_read(self, path: &Path, help: &str) -> Complaint {
        Complaint::new(Kind::Syntax, format!("the file is {}, which is not read", self.name())).in_file(path).help(help)
    }
}

#[cfg(feature = "hdf5")]
fn hdf5(path: &Path, bytes: &[u8], care: Care, asked: &Asked) -> Result<Standing, Complaint> {
    super::hdf5::read(bytes, MOST).map_err(|broken| Binary::Hdf.told(path, broken))?.assemble(path, care, asked)
}

#[cfg(not(feature = "hdf5"))]
fn hdf5(path: &Path, _: &[u8], _: Care, _: &Asked) -> Result<Standing, Complaint> {
    let what = "the file is MATLAB v7.3 or HDF5, and this borescope was built without the feature `hdf5`";
    Err(Complaint::new(Kind::Syntax, what).in_file(path).help(
        "build it with `cargo build --release --features hdf5`, save it in MATLAB with `-v7`, or write the record as CSV",
    ))
}

#[cfg(feature = "excel")]
fn workbook(path: &Path, bytes: &[u8], care: Care, asked: &Asked) -> Result<Standing, Complaint> {
    super::workbook::read(path, bytes, care, asked)
}

#[cfg(not(feature = "excel"))]
fn workbook(path: &Path, _: &[u8], _: Care, _: &Asked) -> Result<Standing, Complaint> {
    let what = "the file is a ZIP archive or a workbook of a spreadsheet, and this borescope was built without the feature `excel`";
    Err(Complaint::new(Kind::Syntax, what).in_file(path).help("unpack it, or save the sheet as CSV"))
}

#[cfg(feature = "parquet")]
fn parquet(path: &Path, bytes: &[u8], care: Care, asked: &Asked) -> Result<Standing, Complaint> {
    super::parquet::read(path, bytes, care, asked)
}

#[cfg(not(feature = "parquet"))]
fn parquet(path: &Path, _: &[u8], _: Care, _: &Asked) -> Result<Standing, Complaint> {
    let what = "the file is Parquet, and this borescope was built without the feature `parquet`";
    Err(Complaint::new(Kind::Syntax, what)
        .in_file(path)
        .help("build it with `cargo build --release --features parquet`, or write the record as CSV"))
}
