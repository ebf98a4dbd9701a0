"""hokuyolx, as it is, reads 100 scans of a laser over TCP, which are those of a room of 4 m by 4 m. Argument: its TCP port."""

import itertools
import math
import sys

import hokuyolx

HALF_M = 2.0

# It takes a scan to end with what it has received by chance: two that a busy machine receives together would be one, which is
# broken. Of single bytes none belongs to the next scan.
laser = hokuyolx.HokuyoLX(addr=("127.0.0.1", int(sys.argv[1])), timeout=20, buf=1)
angles = laser.get_angles()


def wall_mm(angle: float) -> float:
    return 1e3 * HALF_M / max(abs(math.cos(angle)), abs(math.sin(angle)))


stamps = []
for scan, stamp, *_ in itertools.islice(laser.iter_dist(), 100):
    assert len(scan) == len(angles) == 1081, len(scan)
    worst = max(abs(float(read) - wall_mm(angle)) for read, angle in zip(scan, angles))
    assert worst <= 1, f"{worst} mm"
    stamps.append(stamp)
gaps = {b - a for a, b in itertools.pairwise(stamps)}
assert len(stamps) == 100 and gaps == {25}, gaps
laser.close()
print("urg.py: 100 scans, each of the room, 25 ms apart")
