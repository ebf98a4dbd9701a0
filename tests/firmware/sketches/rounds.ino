// Each round of loop() inverts pin 13 once, at its beginning. setup() has loops of its own, and the serial port interrupts.

volatile uint16_t sink;

void setup() {
  pinMode(13, OUTPUT);
  Serial.begin(9600);
  for (uint16_t i = 0; i < 2000; i++) sink = analogRead(0);
  delay(20);
}

void loop() {
  PINB = _BV(5);
  for (uint8_t i = 0; i < 3; i++) sink = analogRead(i);
  for (uint8_t i = 0; i < 10; i++) {
    for (uint8_t j = 0; j < i; j++) sink += j;
  }
  static uint8_t round = 0;
  if (round++ == 0) Serial.println(sink);
  if (round & 1) return;
  delay(1);
}
