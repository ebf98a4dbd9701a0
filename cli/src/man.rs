//! `baudbot man`: the command line, for `man`.

use std::fs;

use anyhow::Context;

use crate::args::{self, ManArgs};
use crate::text;

/// Writes a page of the manual for each command into the folder's section 1.
pub(crate) fn man(args: &ManArgs) -> anyhow::Result<()> {
    let section = args.folder.join("man1");
    fs::create_dir_all(&section).with_context(|| format!("cannot make {}", section.display()))?;
    clap_mangen::generate_to(args::command(), &section)
        .with_context(|| format!("cannot write into {}", section.display()))?;
    text::print(&format!(
        "the manual is in {}: man -M {} baudbot\n",
        section.display(),
        args.folder.display()
    ))
}
