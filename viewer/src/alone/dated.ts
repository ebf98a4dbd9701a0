/** When files in memory were last written to: the shim of WASI does not know, and says 1970. */
import { File, type Directory, type Fd } from "@bjorn3/browser_wasi_shim";

/** From now on files that are made in this folder have a date. */
export function date(folder: Directory): void {
  const create = folder.create_entry_for_path.bind(folder);
  folder.create_entry_for_path = (path, isFolder) => {
    const made = create(path, isFolder);
    if (made.entry instanceof File) dateFile(made.entry);
    return made;
  };
}

function dateFile(file: File): void {
  let written_ms = Date.now();
  const [open, stat] = [file.path_open.bind(file), file.stat.bind(file)];
  file.path_open = (...how) => {
    const opened = open(...how);
    if (opened.fd_obj) note(opened.fd_obj);
    return opened;
  };
  function note(opened: Fd): void {
    const write = opened.fd_write.bind(opened);
    opened.fd_write = (data) => {
      written_ms = Date.now();
      return write(data);
    };
  }
  file.stat = () => {
    const found = stat();
    const written_ns = BigInt(written_ms) * 1_000_000n;
    // The shim writes times to other places than those of `filestat` in WASI.
    found.write_bytes = (view, at) => {
      view.setBigUint64(at, found.dev, true);
      view.setBigUint64(at + 8, found.ino, true);
      view.setUint8(at + 16, found.filetype);
      view.setBigUint64(at + 24, found.nlink, true);
      view.setBigUint64(at + 32, found.size, true);
      for (const time of [40, 48, 56]) view.setBigUint64(at + time, written_ns, true);
    };
    return found;
  };
}
