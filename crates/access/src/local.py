import hashlib, os, stat

def local_token(address):
    """The token of this user's own server at "127.0.0.1:7400" or "unix:/tmp/baudbot.sock"; None if there is none."""
    if address.startswith("unix:"):
        path = os.path.realpath(address.removeprefix("unix:"))
        name = "unix-" + hashlib.sha256(os.fsencode(path)).hexdigest()
    else:
        name = address.replace("localhost:", "127.0.0.1:")
    runtime = os.environ.get("XDG_RUNTIME_DIR")
    for folder in [f"{runtime}/baudbot"] * bool(runtime) + [f"/tmp/baudbot-{os.getuid()}", os.path.expanduser("~/.baudbot")]:
        try:
            there = os.lstat(folder)
            if stat.S_ISDIR(there.st_mode) and there.st_uid == os.getuid() and not there.st_mode & 0o077:
                with open(f"{folder}/{name}.token", encoding="ascii") as file:
                    return file.read()
        except FileNotFoundError:
            pass
    return None
