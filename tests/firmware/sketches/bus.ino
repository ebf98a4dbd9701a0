// A compass HMC5883L, an ultrasonic range finder SRF02, and an address at which nothing is.
#include <Wire.h>

const uint8_t COMPASS = 0x1E, RANGE_FINDER = 0x70;

void command(uint8_t device, uint8_t place, uint8_t value) {
  Wire.beginTransmission(device);
  Wire.write(place);
  Wire.write(value);
  Wire.endTransmission();
}

int word() {
  int high = Wire.read();
  return high << 8 | Wire.read();
}

void setup() {
  Serial.begin(9600);
  Wire.begin();
  Wire.beginTransmission(0x42);
  Serial.print(F("0x42: "));
  Serial.println(Wire.endTransmission());
  Wire.beginTransmission(COMPASS);
  Wire.write(10);
  Serial.print(F("0x1E: "));
  Serial.println(Wire.endTransmission());
  Wire.requestFrom(COMPASS, (uint8_t)3);
  while (Wire.available()) {
    Serial.write(Wire.read());
  }
  Serial.println();
  command(COMPASS, 0, 0x70);
  command(COMPASS, 1, 0x20);
  command(COMPASS, 2, 0);
}

void loop() {
  command(RANGE_FINDER, 0, 0x51);
  delay(70);
  Wire.beginTransmission(RANGE_FINDER);
  Wire.write(2);
  Wire.endTransmission(false);
  Wire.requestFrom(RANGE_FINDER, (uint8_t)2);
  int centimetres = word();
  Wire.beginTransmission(COMPASS);
  Wire.write(3);
  Wire.endTransmission();
  Wire.requestFrom(COMPASS, (uint8_t)6);
  int x = word(), z = word(), y = word();
  float heading = atan2(y, x) * 180 / PI;
  Serial.print(centimetres);
  Serial.print(F(" cm "));
  Serial.print(x);
  Serial.print(' ');
  Serial.print(y);
  Serial.print(' ');
  Serial.print(z);
  Serial.print(' ');
  Serial.println(heading < 0 ? heading + 360 : heading);
  delay(30);
}
