//! `grasp-query man`.

use clap::CommandFactory as _;

/// Print the manual page, e.g. `grasp-query man | man -l -`.
#[derive(Debug, clap::Args)]
pub(super) struct Man {}

impl Man {
    pub(super) fn run(&self) -> anyhow::Result<u8> {
        let mut page = Vec::new();
        clap_mangen::Man::new(super::Arguments::command()).render(&mut page)?;
        std::io::Write::write_all(&mut std::io::stdout().lock(), &page)?;
        Ok(super::SUCCESS)
    }
}
