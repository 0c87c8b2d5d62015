//! The board as a device on its link.
