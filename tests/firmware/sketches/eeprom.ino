// Counts its starts in the EEPROM, and keeps a structure there.
#include <EEPROM.h>

struct Calibration {
  float gain;
  int offset;
  char name[8];
};

void setup() {
  Serial.begin(115200);
  uint8_t starts = EEPROM.read(0);
  starts = starts == 0xFF ? 1 : starts + 1;
  EEPROM.update(0, starts);
  if (starts == 1) {
    Calibration fresh = {1.25, -300, "left"};
    unsigned long before = micros();
    EEPROM.put(16, fresh);
    Serial.println(micros() - before);
  }
  Calibration kept;
  EEPROM.get(16, kept);
  Serial.print(starts);
  Serial.print(' ');
  Serial.print(kept.gain);
  Serial.print(' ');
  Serial.print(kept.offset);
  Serial.print(' ');
  Serial.print(kept.name);
  Serial.print(' ');
  Serial.println(EEPROM.length());
}

void loop() {}
