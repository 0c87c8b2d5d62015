//! A browser without a screen, where there is one.

use std::path::Path;
use std::process::Command;

use super::skipped::skipped;

/// Browsers that show a page without a screen.
const BROWSERS: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];

/// One that is installed; without one the test that asks is skipped.
pub(crate) struct Browser(&'static str);

impl Browser {
    pub(crate) fn find() -> Option<Self> {
        let runs =
            |name: &&str| Command::new(name).arg("--version").output().is_ok_and(|out| out.status.success());
        let browser = BROWSERS.into_iter().find(runs);
        if browser.is_none() {
            skipped(&format!("no browser ({}) is installed", BROWSERS.join(", ")));
        }
        browser.map(Self)
    }

    /// What a page has become when its scripts have run, in a window of this width, pixels.
    pub(crate) fn show(&self, page: &Path, width: u32) -> String {
        let profile = tempfile::tempdir().unwrap();
        let shown = Command::new(self.0)
            .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--dump-dom"])
            // What pages do behind their load, in time that does not pass.
            .arg("--virtual-time-budget=3000")
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .arg(format!("--window-size={width},900"))
            .arg(format!("file://{}", page.display()))
            .output()
            .unwrap();
        let dom = String::from_utf8_lossy(&shown.stdout).into_owned();
        assert!(dom.contains("</html>"), "{}", String::from_utf8_lossy(&shown.stderr));
        dom
    }
}
