//! The controls (ioctl) of a port.

use super::Outcome;
use crate::cables::{Cables, ModemOutputs};
use crate::fault::Fault;
use crate::kernel::Kernel;
use crate::task::{Activity, Task};
use crate::tty::termios::{SIZE, SIZE2, Termios};

const TCGETS2: u64 = 0x802C_542A;
const TCSETS2: u64 = 0x402C_542B;
const TCSETSW2: u64 = 0x402C_542C;
const TCSETSF2: u64 = 0x402C_542D;
const TIOCGICOUNT: u64 = 0x545D;
const TIOCMIWAIT: u64 = 0x545C;
const LINES_REMEDY: &str = "read the lines with TIOCMGET from time to time";
/// A break of `tcsendbreak`, in nanoseconds.
const BREAK_NS: u64 = 250_000_000;
/// A UART with queues (PORT_16550A), and its bits for a divisor of one's own (ASYNC_SPD_CUST, ASYNC_SPD_MASK of linux/tty_flags.h).
const PORT_16550A: u32 = 4;
const CUSTOM_SPEED: u32 = 0x30;
const SPEED: u32 = 0x1030;

pub(super) fn call(kernel: &mut Kernel, task: usize, cables: &mut dyn Cables) -> Result<Outcome, Fault> {
    let caller = &kernel.tasks[task];
    let Some(port) = kernel.port(task, caller.descriptor(0)) else { return Ok(Outcome::Native) };
    let (request, place) = (u64::from(caller.argument(1) as u32), caller.argument(2));
    let tty = &mut kernel.ports[port];
    match request {
        libc::TCGETS => caller.write(place, &tty.termios.to_bytes()[..SIZE])?,
        TCGETS2 => caller.write(place, &tty.termios.to_bytes())?,
        libc::TCSETS | libc::TCSETSW | libc::TCSETSF | TCSETS2 | TCSETSW2 | TCSETSF2 => {
            return set(kernel, task, port, request, cables);
        }
        libc::FIONREAD => return tell(caller, place, tty.input.available()),
        libc::TIOCOUTQ => return tell(caller, place, cables.unsent(port)),
        libc::TCSBRK if place != 0 => return Ok(drained(kernel, port, cables).unwrap_or(Outcome::Answer(0))),
        libc::TCSBRKP if place != 0 => {
            return send_break(kernel, task, port, u64::from(place as u32) * 100_000_000, cables);
        }
        libc::TCSBRK | libc::TCSBRKP => return send_break(kernel, task, port, BREAK_NS, cables),
        libc::TIOCSBRK | libc::TIOCCBRK => cables.send_break(port, request == libc::TIOCSBRK),
        libc::TCFLSH => flush(kernel, port, place, cables)?,
        libc::TIOCEXCL | libc::TIOCNXCL => tty.is_exclusive = request == libc::TIOCEXCL,
        // The flow of bytes by hand: there is nothing that could run over.
        libc::TCXONC => {}
        TIOCGICOUNT => caller.write(place, &[0; 80])?,
        TIOCMIWAIT => return Err(caller.refuse("ioctl(TIOCMIWAIT)", LINES_REMEDY).into()),
        libc::TIOCGWINSZ => caller.write(place, &[0; 8])?,
        libc::TIOCMGET => return tell_lines(kernel, task, port, cables),
        libc::TIOCMSET | libc::TIOCMBIS | libc::TIOCMBIC => {
            return set_lines(kernel, task, port, request, cables);
        }
        libc::TIOCGSERIAL | libc::TIOCSSERIAL => return serial(kernel, task, port, request),
        // These are about descriptors rather than terminals.
        libc::FIONBIO | libc::FIOCLEX | libc::FIONCLEX => return Ok(Outcome::Native),
        _ => return Err(Fault::Errno(libc::ENOTTY)),
    }
    Ok(Outcome::Answer(0))
}

fn tell(task: &Task, place: u64, number: usize) -> Result<Outcome, Fault> {
    task.write(place, &(number as i32).to_ne_bytes())?;
    Ok(Outcome::Look(0))
}

/// The wait until all has left the UART; none if it has.
fn drained(kernel: &Kernel, port: usize, cables: &dyn Cables) -> Option<Outcome> {
    let sent_at_ns = cables.sent_at_ns(port);
    let waits = sent_at_ns > kernel.now_ns;
    waits.then_some(Outcome::Wait(Activity::Ours { until_ns: Some(sent_at_ns), seen: kernel.progress }))
}

fn set(
    kernel: &mut Kernel,
    task: usize,
    port: usize,
    request: u64,
    cables: &mut dyn Cables,
) -> Result<Outcome, Fault> {
    let waits = !matches!(request, libc::TCSETS | TCSETS2);
    if waits && let Some(wait) = drained(kernel, port, cables) {
        return Ok(wait);
    }
    let caller = &kernel.tasks[task];
    let tty = &mut kernel.ports[port];
    let mut bytes = tty.termios.to_bytes();
    let size = if matches!(request, TCSETS2 | TCSETSW2 | TCSETSF2) { SIZE2 } else { SIZE };
    caller.read(caller.argument(2), &mut bytes[..size])?;
    let (old, new) = (tty.termios.clone(), Termios::from_bytes(&bytes));
    if matches!(request, libc::TCSETSF | TCSETSF2) {
        tty.input.clear();
    }
    if old.is_canonical() != new.is_canonical() {
        tty.input.change_mode(new.is_canonical());
    }
    let (before, settings) = (old.line_settings(), new.line_settings());
    tty.termios = new;
    tty.show();
    match settings {
        Some(settings) if before != Some(settings) => cables.configure(port, settings),
        Some(_) | None => {}
    }
    if before.is_some() != settings.is_some() {
        tty.outputs = ModemOutputs { dtr: settings.is_some(), rts: settings.is_some() };
        cables.set_outputs(port, tty.outputs);
    }
    Ok(Outcome::Answer(0))
}

/// A break: it begins once all is sent, and ends after its time.
fn send_break(
    kernel: &mut Kernel,
    task: usize,
    port: usize,
    break_ns: u64,
    cables: &mut dyn Cables,
) -> Result<Outcome, Fault> {
    let now_ns = kernel.now_ns;
    if kernel.tasks[task].call.done == 0 {
        if let Some(wait) = drained(kernel, port, cables) {
            return Ok(wait);
        }
        cables.send_break(port, true);
        kernel.tasks[task].call.done = now_ns + break_ns;
    }
    let until_ns = kernel.tasks[task].call.done;
    if until_ns > now_ns {
        return Ok(Outcome::Wait(Activity::Ours { until_ns: Some(until_ns), seen: kernel.progress }));
    }
    cables.send_break(port, false);
    Ok(Outcome::Answer(0))
}

fn flush(kernel: &mut Kernel, port: usize, queue: u64, cables: &mut dyn Cables) -> Result<(), Fault> {
    let (input, output) = match queue as i32 {
        libc::TCIFLUSH => (true, false),
        libc::TCOFLUSH => (false, true),
        libc::TCIOFLUSH => (true, true),
        _ => return Err(Fault::Errno(libc::EINVAL)),
    };
    if input {
        kernel.ports[port].input.clear();
        kernel.ports[port].show();
    }
    if output {
        cables.discard_unsent(port);
    }
    Ok(())
}

fn tell_lines(kernel: &Kernel, task: usize, port: usize, cables: &dyn Cables) -> Result<Outcome, Fault> {
    let (inputs, outputs) = (cables.inputs(port), kernel.ports[port].outputs);
    let lines = [
        (outputs.dtr, libc::TIOCM_DTR),
        (outputs.rts, libc::TIOCM_RTS),
        (inputs.cts, libc::TIOCM_CTS),
        (inputs.dsr, libc::TIOCM_DSR),
        (inputs.dcd, libc::TIOCM_CAR),
        (inputs.ri, libc::TIOCM_RNG),
    ];
    let bits = lines.iter().map(|(is_on, bit)| if *is_on { *bit as usize } else { 0 }).sum();
    tell(&kernel.tasks[task], kernel.tasks[task].argument(2), bits)
}

fn set_lines(
    kernel: &mut Kernel,
    task: usize,
    port: usize,
    request: u64,
    cables: &mut dyn Cables,
) -> Result<Outcome, Fault> {
    let caller = &kernel.tasks[task];
    let bits = caller.read_u32(caller.argument(2))?.cast_signed();
    let next = |was: bool, bit: i32| match request {
        libc::TIOCMBIS => was || bits & bit != 0,
        libc::TIOCMBIC => was && bits & bit == 0,
        _ => bits & bit != 0,
    };
    let tty = &mut kernel.ports[port];
    let (dtr, rts) = (next(tty.outputs.dtr, libc::TIOCM_DTR), next(tty.outputs.rts, libc::TIOCM_RTS));
    let outputs = ModemOutputs { dtr, rts };
    if outputs != tty.outputs {
        tty.outputs = outputs;
        cables.set_outputs(port, outputs);
    }
    Ok(Outcome::Answer(0))
}

/// `struct serial_struct` (72 bytes): type, line, port, irq, flags, xmit_fifo_size, custom_divisor, baud_base, …
fn serial(kernel: &mut Kernel, task: usize, port: usize, request: u64) -> Result<Outcome, Fault> {
    let caller = &kernel.tasks[task];
    let place = caller.argument(2);
    let tty = &mut kernel.ports[port];
    if request == libc::TIOCSSERIAL {
        let flags = caller.read_u32(place + 16)?;
        if flags & SPEED == CUSTOM_SPEED {
            return Err(Fault::Errno(libc::EINVAL));
        }
        tty.serial_flags = flags;
        return Ok(Outcome::Answer(0));
    }
    let mut told = [0; 72];
    let fields = [PORT_16550A, port as u32, 0, 0, tty.serial_flags, 16, 0, 24_000_000 / 16];
    for (place, field) in fields.into_iter().enumerate() {
        told[4 * place..4 * place + 4].copy_from_slice(&field.to_ne_bytes());
    }
    caller.write(place, &told)?;
    Ok(Outcome::Answer(0))
}
