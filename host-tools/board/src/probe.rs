//! The store of a board on a debug probe (SWD), through probe-rs: with the cargo feature `probe`
//! only.
//!
//! The processor is halted meanwhile, and the wheel servos keep turning at their last command: lift
//! the robot off the floor.

#[cfg(not(feature = "probe"))]
pub use absent::{read, write};
#[cfg(feature = "probe")]
pub use attached::{read, write};

#[cfg(feature = "probe")]
mod attached {
    use probe_rs::flashing::{DownloadOptions, FlashLoader};
    use probe_rs::probe::list::Lister;
    use probe_rs::{MemoryInterface, Permissions, Session};
    use support::error::{Error, Result};

    use crate::store_image::StoreImage;

    /// The OpenCR's, as probe-rs calls it.
    const CHIP: &str = "STM32F746ZGTx";

    /// The store as the board has it. Its firmware runs on afterwards.
    ///
    /// # Errors
    /// There is not exactly one probe, no board on it, or reading fails.
    pub fn read() -> Result<StoreImage> {
        read_with(&mut attach()?)
    }

    /// Writes the store, reads it back, compares, and starts the board again.
    ///
    /// # Errors
    /// As [`read`]; what was read back is something else.
    pub fn write(image: &StoreImage) -> Result<()> {
        let failed = |error: &dyn std::fmt::Display| Error::failed(format!("writing by the probe: {error}"));
        let mut session = attach()?;
        let mut loader: FlashLoader = session.target().flash_loader();
        loader.add_data(u64::from(StoreImage::ADDRESS), image.as_bytes()).map_err(|error| failed(&error))?;
        let mut options = DownloadOptions::default();
        options.verify = true;
        loader.commit(&mut session, options).map_err(|error| failed(&error))?;
        if read_with(&mut session)? != *image {
            return Err(Error::failed(
                "what was read back is not what was written: the store is damaged; write it again",
            ));
        }
        session.core(0).and_then(|mut core| core.reset()).map_err(|error| failed(&error))
    }

    fn attach() -> Result<Session> {
        let probes = Lister::new().list_all();
        let [probe] = &probes[..] else {
            return Err(Error::failed(match probes.len() {
                0 => "there is no debug probe; expected one (ST-Link, J-Link, CMSIS-DAP 2) on USB".to_owned(),
                many => format!("there are {many} debug probes; expected one"),
            }));
        };
        let failed = |error: &dyn std::fmt::Display| {
            Error::failed(format!(
                "no board answers on the probe: {error}; expected the OpenCR's J1, with power on"
            ))
        };
        let probe = probe.open().map_err(|error| failed(&error))?;
        probe.attach(CHIP, Permissions::default()).map_err(|error| failed(&error))
    }

    fn read_with(session: &mut Session) -> Result<StoreImage> {
        let mut bytes = vec![0; StoreImage::BYTES];
        let read = session
            .halted_access(|session| session.core(0)?.read(u64::from(StoreImage::ADDRESS), &mut bytes));
        read.map_err(|error| Error::failed(format!("reading by the probe: {error}")))?;
        StoreImage::from_bytes(bytes)
    }
}

#[cfg(not(feature = "probe"))]
mod absent {
    use support::error::{Error, Result};

    use crate::store_image::StoreImage;

    /// Says how to build with probes.
    ///
    /// # Errors
    /// Always.
    pub fn read() -> Result<StoreImage> {
        Err(Error::usage(
            "--probe: this gmr was built without debug probes; expected one built with \
             `cargo install --path host-tools --features probe` (or --dfu, or --port)",
        ))
    }

    /// As [`read`].
    ///
    /// # Errors
    /// Always.
    pub fn write(_: &StoreImage) -> Result<()> {
        read().map(drop)
    }
}
