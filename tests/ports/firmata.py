"""pyfirmata2, as it is, and StandardFirmata, as it is, at the two ends of a cable. Argument: the port.

Nothing here depends on how late this program is. The last line has what was seen, as JSON.
"""

import json
import sys
import time

import pyfirmata2

board = pyfirmata2.Arduino(sys.argv[1], timeout=10)
name, version = board.firmware, board.get_firmata_version()
assert version is not None and version[0] == 2, version
assert name is not None and name.startswith("StandardFirmata"), name
seen: list[float] = []
board.samplingOn(20)
board.analog[0].register_callback(seen.append)
board.analog[0].enable_reporting()
led = board.get_pin("d:13:o")
led.write(1)
# Through the L298N of the left motor: forwards at half the duty.
forwards, enable = board.get_pin("d:7:o"), board.get_pin("d:5:p")
forwards.write(1)
enable.write(0.5)
until = time.monotonic() + 30
while len(seen) < 50 and time.monotonic() < until:
    time.sleep(0.05)
enable.write(0)
time.sleep(0.3)
assert len(seen) >= 50, f"{len(seen)} readings of A0 came"
board.exit()
print(json.dumps({"firmware": name, "version": version, "readings": seen}))
