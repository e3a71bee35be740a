//! Writes man pages, and completions for bash, zsh and fish, from the definition of the command
//! line. An example, so that the program itself does not carry it.
//!
//! `cargo run --release -p lightbox --example assets -- FOLDER`

use std::path::Path;

use clap::CommandFactory as _;
use clap_complete::{Shell, generate_to};
use lightbox::args::Args;

fn main() -> std::io::Result<()> {
    let Some(folder) = std::env::args_os().nth(1) else {
        return Err(std::io::Error::other("name a folder to write to"));
    };
    let folder = Path::new(&folder);
    std::fs::create_dir_all(folder)?;
    for shell in [Shell::Bash, Shell::Zsh, Shell::Fish] {
        generate_to(shell, &mut Args::command(), "lightbox", folder)?;
    }
    clap_mangen::generate_to(Args::command(), folder)
}
