//! Signatures of coefficients, for boards that ask for one: Ed25519, as `firmware::items` has it.

use std::fs::File;
use std::io::Write as _;
use std::path::Path;

use ed25519_compact::{KeyPair, Seed};
use firmware::items::{SIGNATURE_BYTES, key_of_hex};
use support::error::{Error, Result};

/// Whoever has it may write coefficients.
pub struct SecretKey(KeyPair);

impl SecretKey {
    /// Of 32 random bytes.
    pub fn from_seed(seed: [u8; 32]) -> Self {
        Self(KeyPair::from_seed(Seed::new(seed)))
    }

    /// A new one, in a new file that nobody else may read: 64 hexadecimal digits.
    ///
    /// # Errors
    /// There is such a file already; what the operating system refuses.
    pub fn create(file: &Path) -> Result<Self> {
        let mut seed = [0; 32];
        getrandom::fill(&mut seed)
            .map_err(|error| Error::failed(format!("the system has no randomness: {error}")))?;
        let refused = |error: std::io::Error| Error::io(file, &error);
        let mut options = File::options();
        options.write(true).create_new(true);
        #[cfg(unix)]
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
        let mut opened = options.open(file).map_err(refused)?;
        writeln!(opened, "{}", hex(&seed)).and_then(|()| opened.sync_all()).map_err(refused)?;
        Ok(Self::from_seed(seed))
    }

    /// As [`create`](Self::create) has written it.
    ///
    /// # Errors
    /// The file cannot be read, or is no key.
    pub fn read(file: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(file).map_err(|error| Error::io(file, &error))?;
        let seed = key_of_hex(text.trim()).ok_or_else(|| {
            Error::failed("no key; expected 64 hexadecimal digits, as `gmr key new` writes them")
                .in_file(file)
        })?;
        Ok(Self::from_seed(seed))
    }

    /// What a board is built with, in hexadecimal digits.
    pub fn public_hex(&self) -> String {
        hex(self.0.pk.as_ref())
    }

    /// The image, followed by its signature.
    pub fn sign(&self, image: &[u8]) -> Vec<u8> {
        // Without noise: the same image has the same signature (RFC 8032).
        let signature: [u8; SIGNATURE_BYTES] = *self.0.sk.sign(image, None);
        [image, &signature].concat()
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// RFC 8032, section 7.1, test 2: one byte, 72h.
    #[test]
    fn signs_as_the_standard_says() {
        let seed = key_of_hex("4ccd089b28ff96da9db6c346ec114e0f5b8a319f35aba624da8cf6ed4fb8a6fb").unwrap();
        let key = SecretKey::from_seed(seed);
        assert_eq!(key.public_hex(), "3d4017c3e843895a92b70aa74d1b7ebc9c982ccf2ec4968cc0cd55f12af4660c");
        let expected = "92a009a9f0d4cab8720e820b5f642540a2b27b5416503f8fb3762223ebdb69da\
                        085ac1e43e15996e458f3613d0f11d8c387b2eaeb4302aeeb00d291612bb0c00";
        assert_eq!(hex(&key.sign(&[0x72])), format!("72{expected}"));
    }

    #[test]
    fn a_key_is_written_once_and_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("robots.key");
        let made = SecretKey::create(&file).unwrap();
        assert_eq!(SecretKey::read(&file).unwrap().public_hex(), made.public_hex());
        assert!(SecretKey::create(&file).is_err());
        assert_eq!(SecretKey::read(&file).unwrap().public_hex(), made.public_hex());
        std::fs::write(&file, "secret").unwrap();
        assert!(SecretKey::read(&file).is_err());
    }
}
