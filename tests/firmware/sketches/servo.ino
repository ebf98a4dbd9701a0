// A servo of number 1 that answers pings and reads of its model (0x000c) in Dynamixel's protocol 1.0.

byte got = 0, packet[16];

void answer(byte parameters) {
  byte status[] = {0xff, 0xff, 1, (byte)(2 + parameters), 0, 0x0c, 0x00, 0};
  byte last = 5 + parameters, sum = 0;
  for (byte i = 2; i < last; i++) sum += status[i];
  status[last] = ~sum;
  Serial.write(status, last + 1);
}

void setup() { Serial.begin(57600); }

void loop() {
  if (!Serial.available()) return;
  byte next = Serial.read();
  if (got < 2 && next != 0xff) {
    got = 0;
    return;
  }
  packet[got++] = next;
  // Header, number, length, instruction, parameters, checksum.
  if (got < 4 || (got < 4 + packet[3] && got < sizeof packet)) return;
  got = 0;
  if (packet[2] != 1) return;
  if (packet[4] == 1) answer(0);
  if (packet[4] == 2) answer(2);
}
