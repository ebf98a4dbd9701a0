//! `baudbot new firmware`: a sketch, a makefile that builds it with Debian's packages, and a robot whose chip runs it.

use super::{File, check_free, package_name, write_all};
use crate::args::{FirmwareLanguage, NewFirmwareArgs};
use crate::text;

pub(crate) fn firmware(args: &NewFirmwareArgs) -> anyhow::Result<()> {
    let folder = &args.folder;
    check_free(folder)?;
    let name = package_name(folder)?;
    let (sketch, source, makefile, packages) = match args.lang {
        FirmwareLanguage::Arduino => (
            format!("{name}.ino"),
            include_str!("../../templates/firmware/sketch.ino"),
            include_str!("../../templates/firmware/arduino.mk"),
            "gcc-avr avr-libc binutils-avr arduino-core-avr make",
        ),
        FirmwareLanguage::C => (
            format!("{name}.c"),
            include_str!("../../templates/firmware/sketch.c"),
            include_str!("../../templates/firmware/c.mk"),
            "gcc-avr avr-libc binutils-avr make",
        ),
    };
    let install = format!("sudo apt install {packages}");
    let fill = |template: &str| {
        let filled = template.replace("{name}", &name).replace("{sketch}", &sketch);
        filled.replace("{install}", &install).into_bytes()
    };
    let files: Vec<File> = vec![
        (sketch.clone(), source.into(), false),
        ("Makefile".into(), fill(makefile), false),
        ("robot.toml".into(), fill(include_str!("../../templates/firmware/robot.toml")), false),
        ("README.md".into(), fill(include_str!("../../templates/firmware/README.md")), false),
        (".gitignore".into(), b"/build/\n*.elf\n*.hex\n".to_vec(), false),
    ];
    write_all(folder, files)?;
    text::print(&format!("{} is ready. In that folder:\n  {install}\n  make && make run\n", folder.display()))
}
