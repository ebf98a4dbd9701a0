//! `baudbot completions` and `baudbot man`: the command line, for shells and for `man`.

use std::fs;

use anyhow::Context;

use crate::args::{self, CompletionsArgs, ManArgs};
use crate::text;

/// Prints a shell's completions of commands and options.
pub(crate) fn completions(args: &CompletionsArgs) -> anyhow::Result<()> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut args::command(), "baudbot", &mut script);
    text::print(&String::from_utf8(script).context("a script is text")?)
}

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
