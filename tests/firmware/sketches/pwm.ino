// All six outputs with PWM; after a second other values, among them both ends.
void setup() {
  analogWrite(3, 10);
  analogWrite(5, 63);
  analogWrite(6, 191);
  analogWrite(9, 85);
  analogWrite(10, 200);
  analogWrite(11, 254);
  delay(1000);
  analogWrite(3, 0);
  analogWrite(5, 255);
  analogWrite(6, 0);
  analogWrite(9, 255);
  analogWrite(10, 1);
  analogWrite(11, 128);
}

void loop() {}
