//! `grasp-builder man`.

use clap::CommandFactory as _;

/// Print the manual page, e.g. `grasp-builder man | man -l -`.
#[derive(Debug, clap::Args)]
pub(crate) struct Man {}

impl Man {
    pub(crate) fn run(&self) -> anyhow::Result<()> {
        let mut page = Vec::new();
        clap_mangen::Man::new(super::Arguments::command()).render(&mut page)?;
        std::io::Write::write_all(&mut std::io::stdout().lock(), &page)?;
        Ok(())
    }
}
