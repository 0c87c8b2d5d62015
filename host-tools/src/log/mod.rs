//! Run logs: CSV with a header, read as a stream.
