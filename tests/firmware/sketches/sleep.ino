// Sleeps in power-down until pin 2 is low, and then for eight seconds by the interrupt of the watchdog; at last idle.
#include <avr/sleep.h>
#include <avr/wdt.h>

void wake() {
  detachInterrupt(digitalPinToInterrupt(2));
}

ISR(WDT_vect) {
  wdt_disable();
}

void say(const __FlashStringHelper *text) {
  Serial.println(text);
  Serial.flush();
}

void setup() {
  Serial.begin(9600);
  pinMode(2, INPUT_PULLUP);
  say(F("power down"));
  set_sleep_mode(SLEEP_MODE_PWR_DOWN);
  noInterrupts();
  attachInterrupt(digitalPinToInterrupt(2), wake, LOW);
  sleep_enable();
  sleep_bod_disable();
  interrupts();
  sleep_cpu();
  sleep_disable();
  say(F("pin"));
  noInterrupts();
  wdt_reset();
  WDTCSR = bit(WDCE) | bit(WDE);
  WDTCSR = bit(WDIE) | bit(WDP3) | bit(WDP0);
  sleep_enable();
  interrupts();
  sleep_cpu();
  sleep_disable();
  say(F("watchdog"));
  set_sleep_mode(SLEEP_MODE_IDLE);
}

void loop() {
  static unsigned long start = millis();
  if (millis() - start >= 1000) {
    start += 1000;
    say(F("idle"));
  }
  sleep_mode();
}
