// Bytes over SPI with nothing at the other end, which holds MISO high by a pull-up: 1 byte at each of three clocks, timed by timer 1.
#include <SPI.h>

void measure(uint32_t clock) {
  SPI.beginTransaction(SPISettings(clock, MSBFIRST, SPI_MODE0));
  digitalWrite(SS, LOW);
  noInterrupts();
  TCNT1 = 0;
  uint8_t answer = SPI.transfer(0xA5);
  uint16_t cycles = TCNT1;
  interrupts();
  digitalWrite(SS, HIGH);
  SPI.endTransaction();
  Serial.print(answer, HEX);
  Serial.print(' ');
  Serial.println(cycles);
}

void setup() {
  Serial.begin(115200);
  TCCR1A = 0;
  TCCR1B = 1;
  SPI.begin();
  digitalWrite(MISO, HIGH);
  measure(8000000);
  measure(4000000);
  measure(125000);
}

void loop() {}
