// Feeds the watchdog five times, then hangs; after the reset it says why it was started.
#include <avr/wdt.h>

void setup() {
  uint8_t cause = MCUSR;
  MCUSR = 0;
  wdt_disable();
  Serial.begin(115200);
  Serial.print(F("cause "));
  Serial.println(cause, HEX);
  wdt_enable(WDTO_250MS);
  for (int i = 0; i < 5; i++) {
    delay(200);
    wdt_reset();
  }
  Serial.println(F("hang"));
  Serial.flush();
  wdt_reset();
  while (true) {
  }
}

void loop() {}
