"""gpsd, as it is, at a receiver's port. Argument: the port."""

import json
import socket
import subprocess
import sys

free = socket.create_server(("127.0.0.1", 0))
number = free.getsockname()[1]
free.close()
gpsd = subprocess.Popen(["gpsd", "-N", "-n", "-b", "-S", str(number), sys.argv[1]], stderr=subprocess.DEVNULL)
try:
    while gpsd.poll() is None:
        try:
            stream = socket.create_connection(("127.0.0.1", number), timeout=60)
            break
        except ConnectionRefusedError:
            continue
    stream.sendall(b'?WATCH={"enable":true,"json":true};\n')
    bauds = set()
    for line in stream.makefile():
        report = json.loads(line)
        if report["class"] == "DEVICE":
            bauds.add(report.get("bps"))
        if report["class"] == "TPV" and report.get("mode") == 3:
            break
    assert 4800 in bauds, bauds
    assert abs(report["lat"]) < 1e-3 and abs(report["lon"]) < 1e-3, report
finally:
    gpsd.kill()
print("gps.py: 4800 baud found, a fix in three dimensions")
