//! Which format a file is in, by its first bytes: names lie.
//!
//! VESC Tool's is text, but no table of this dialect: its time counts from midnight, its separator
//! is a semicolon.

/// A format of logs that is no table in text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// MCAP (mcap.dev/spec).
    Mcap,
    /// SQLite 3.
    Sqlite,
    /// ULog of PX4.
    Ulog,
    /// Apache Parquet.
    Parquet,
    /// Zstandard, which some recorders put around a whole file.
    Zstd,
    /// gzip.
    Gzip,
    /// LZ4 frame.
    Lz4,
    /// A bag of ROS 1.
    Ros1,
    /// DataFlash of ArduPilot.
    Dataflash,
    /// What VESC Tool logs.
    VescTool,
}

/// First bytes, by format (each format's specification; a bag of ROS 1: wiki.ros.org/Bags/Format).
const MAGIC: [(&[u8], Format); 10] = [
    (b"\x89MCAP0\r\n", Format::Mcap),
    (b"SQLite format 3\0", Format::Sqlite),
    (b"ULog\x01\x12\x35", Format::Ulog),
    (b"PAR1", Format::Parquet),
    (b"\x28\xB5\x2F\xFD", Format::Zstd),
    (b"\x1F\x8B", Format::Gzip),
    (b"\x04\x22\x4D\x18", Format::Lz4),
    (b"#ROSBAG V", Format::Ros1),
    // Its first message says what such a message is.
    (b"\xA3\x95\x80\x80", Format::Dataflash),
    (b"ms_today;", Format::VescTool),
];

impl Format {
    /// Of a file that begins so; `None` if none of these.
    pub fn of(head: &[u8]) -> Option<Self> {
        MAGIC.iter().find(|(magic, _)| head.starts_with(magic)).map(|(_, format)| *format)
    }

    /// Bytes that [`of`](Self::of) needs.
    pub const HEAD_BYTES: usize = 16;

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Mcap => "MCAP",
            Self::Sqlite => "SQLite",
            Self::Ulog => "ULog",
            Self::Parquet => "Parquet",
            Self::Zstd => "zstd",
            Self::Gzip => "gzip",
            Self::Lz4 => "LZ4",
            Self::Ros1 => "ROS 1 bag",
            Self::Dataflash => "DataFlash",
            Self::VescTool => "VESC Tool log",
        }
    }

    /// Whether it is read here, or why not and what helps.
    ///
    /// # Errors
    /// Of the formats that only wrap another one.
    pub fn check(self) -> crate::Result<()> {
        let unpack = match self {
            Self::Mcap
            | Self::Sqlite
            | Self::Ulog
            | Self::Parquet
            | Self::Ros1
            | Self::Dataflash
            | Self::VescTool => return Ok(()),
            Self::Zstd => "zstd -d",
            Self::Gzip => "gunzip",
            Self::Lz4 => "lz4 -d",
        };
        Err(crate::Error::Unsupported(format!(
            "is compressed as a whole ({}); expected the log itself ({unpack} FILE)",
            self.name()
        )))
    }
}
